"""What a supplier's plant must do, as pytest tests: copy, point at your system file, change.

python -m pytest examples/ci
"""

from __future__ import annotations

LOOP = "../closed_loop/paper_case1.toml"
HEAVY = 1700.0  # kg; the paper's vehicle has 1500 kg


def test_the_loop_meets_the_limits_of_its_system_file(closed_loop) -> None:
    assert closed_loop(LOOP).verdict == "pass"


def test_the_observer_copes_with_a_heavier_vehicle(closed_loop) -> None:
    loop = closed_loop(LOOP, plant__vehicle__mass=HEAVY)
    error = loop.kpi("estimation.percentOfRms", "driveShaft.torque", estimate="observer")
    assert error < 3.0  # %


def test_friction_of_the_observer_leaves_the_plant_alone(closed_loop, assert_tube) -> None:
    loop = closed_loop(LOOP, observer__clutch1__nominalFriction=0.3)
    assert_tube(loop, closed_loop(LOOP), ["plant.*", "scenario.*"], abs=0.0, rel=0.0)


def test_a_plant_at_rest_stays_at_rest(plant) -> None:
    plant["engine.speed_start"] = 0.0  # the vehicle's is 0 already
    plant.step(0.001, count=1000)
    assert plant["vehicle.speed"] == 0.0


def test_the_observer_starts_valid(observer) -> None:
    observer["engine.speed"] = 90.0
    observer.step(0.001)
    assert observer["status.valid"] == 1.0
