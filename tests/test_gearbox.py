"""Gears of DctPlant as an importer sees them: out, synchronised, in; reverse; saved half-way."""

from __future__ import annotations

import pytest
from closed_loop_runs import FMUS
from fmpy.fmi1 import FMICallException
from fmu_instance import Instance

STEP = 1e-3
TWO_ODD_GEARS = {"shaft1.gearRatio[2]": 1.35}


def drive(plant: Instance, start: float, steps: int, **inputs: float) -> list[dict]:
    """Go `steps` on with inputs (`__` for a dot); return the outputs after every step."""
    for name, value in inputs.items():
        plant.set(name.replace("__", "."), value)
    rows = []
    for k in range(steps):
        plant.step(start + k * STEP, STEP)
        rows.append(plant.outputs())
    return rows


PLANT = FMUS / "DctPlant.fmu"


@pytest.fixture
def plant():
    """A plant in second gear on its even clutch, the odd shaft in neutral, logged."""
    with Instance(PLANT) as plant:
        plant.slave.setDebugLogging(True, ["logEvents", "logStatusWarning"])
        for name, value in TWO_ODD_GEARS.items():
            plant.set(name, value)
        plant.set("engine.speed_start", 115.2)
        plant.set("vehicle.speed_start", 3.0)
        plant.set("shaft1.gear", 0)
        plant.set("clutch2.position", 9e-3)
        plant.set("engine.torque", 40.0)
        plant.start()
        drive(plant, 0.0, 100)
        yield plant


def texts(plant: Instance) -> list[str]:
    """What the plant logged."""
    return [message.message for message in plant.log]


def test_a_preselected_gear_is_synchronised_before_it_is_in(plant):
    before = plant.outputs()
    rows = drive(plant, 0.1, 300, shaft1__gear=3)
    rubbing = [row["shaft1.synchronising"] for row in rows]
    count = rubbing.index(False)
    assert all(rubbing[:count])
    assert not any(rubbing[count:])
    lag = 8.1 * before["output.speed"]  # the shaft stood still
    assert count * STEP == pytest.approx(lag * 0.1 / 100.0, rel=0.05)  # J_ct lag / T_s
    last = rows[-1]
    assert last["clutch1.speed"] == pytest.approx(8.1 * last["output.speed"], abs=0.1)
    assert last["synchroniser.energy"] == pytest.approx(0.5 * 0.1 * lag**2, rel=0.1)
    assert abs(last["energy.residual"]) < 1e-6
    assert rows[count // 2]["shaft1.torque"] == pytest.approx(-1.35 * 100.0)
    assert any("gears [0, 2] become [3, 2]" in text for text in texts(plant))
    assert any("synchroniser 1 Backward -> Open" in text for text in texts(plant))


def test_a_run_goes_on_from_a_state_saved_while_a_synchroniser_rubs(plant):
    drive(plant, 0.1, 20, shaft1__gear=3)
    assert plant.get("shaft1.synchronising")
    saved = plant.saved()
    first = drive(plant, 0.12, 300)
    plant.restore(saved)
    assert drive(plant, 0.12, 300) == first


def test_preselecting_under_a_closed_clutch_is_logged_once_and_ignored(plant):
    speed = drive(plant, 0.1, 50, shaft2__gear=4)[-1]["clutch2.speed"]
    assert speed == pytest.approx(11.52 * plant.get("output.speed"), rel=1e-2)
    ignored = "shaft2.gear = 4 is ignored while clutch 2 transmits; gear 2 stays"
    assert sum(ignored in text for text in texts(plant)) == 1


def test_a_clutch_pressed_too_early_finds_its_shaft_in_neutral(plant):
    drive(plant, 0.1, 20, shaft1__gear=3)
    wheel = plant.get("wheel.speed")
    drive(plant, 0.12, 400, clutch1__position=5e-3)
    assert plant.get("clutch1.speed") == pytest.approx(plant.get("engine.speed"), rel=1e-2)
    assert plant.get("shaft1.torque") == 0.0
    assert plant.get("wheel.speed") > wheel
    ignored = "shaft1.gear = 3 is ignored while clutch 1 transmits; gear 0 stays"
    assert any(ignored in text for text in texts(plant))
    rows = drive(plant, 0.52, 300, clutch1__position=0.0)
    assert rows[0]["shaft1.synchronising"]
    assert not rows[-1]["shaft1.synchronising"]


def test_reverse_drives_backwards():
    with Instance(PLANT) as plant:
        plant.set("shaft2.reverseRatio", 2.6)
        plant.set("shaft2.gear", -1)
        plant.set("engine.speed_start", 110.0)
        plant.set("engine.torque", 60.0)
        plant.start()
        last = drive(plant, 0.0, 1500, clutch2__position=6e-3)[-1]
        assert last["vehicle.speed"] < -1.0
        assert last["clutch2.speed"] > 0.0
        assert last["driveShaft.torque"] < 0.0
        assert abs(last["energy.residual"]) < 1e-6


def test_a_gear_without_a_ratio_is_neutral_and_told(plant):
    last = drive(plant, 0.1, 50, shaft1__gear=7)[-1]
    assert not last["shaft1.synchronising"]
    assert last["shaft1.torque"] == 0.0
    told = "shaft1.gear = 7 has no ratio on shaft 1: neutral"
    assert sum(told in text for text in texts(plant)) == 1


def test_the_inertia_of_a_gear_slows_the_vehicle_down():
    speeds = []
    for inertia in (0.0, 0.05):
        with Instance(PLANT) as plant:
            plant.set("shaft1.gearInertia[1]", inertia)
            plant.set("engine.torque", 60.0)
            plant.set("clutch1.position", 9e-3)
            plant.start()
            speeds.append(drive(plant, 0.0, 500)[-1]["vehicle.speed"])
    # rigid driveline: J_v + J_o + g² (J_e + J_d + J_ct) + g2² J_ct, seen at the wheel
    seen = 134.6 + 0.04 + 18.0**2 * (0.745 + 0.0165 + 0.1) + 11.52**2 * 0.1
    expected = 1.0 + 18.0**2 * 0.05 / seen
    assert speeds[0] / speeds[1] == pytest.approx(expected, rel=2e-3)


def lossy(**values: float) -> Instance:
    """A plant in first gear alone at 3 m/s, whose gear loses 10 %, before its start."""
    plant = Instance(PLANT)
    start = {
        "shaft2__gear": 0,
        "engine__speed_start": 180.0,
        "vehicle__speed_start": 3.0,
        "clutch1__position": 9e-3,
    }
    for name, value in (start | {"shaft1__gearEfficiency[1]": 0.9} | values).items():
        plant.set(name.replace("__", "."), value)
    return plant


@pytest.mark.parametrize("rigid", [False, True])
def test_a_gear_that_loses_power_passes_on_less_driving_and_takes_more_driven(rigid):
    for torque, share in ((60.0, 0.9), (-60.0, 1 / 0.9)):
        with lossy(engine__torque=torque, transmission__rigid=rigid) as plant:
            plant.start()
            last = drive(plant, 0.0, 800)[-1]
            reached = last["driveShaft.torque"] + 0.04 * last["vehicle.acceleration"] / 0.3
            assert reached / (6.0 * last["shaft1.torque"]) == pytest.approx(share, rel=2e-3)
            assert abs(last["energy.residual"]) < 1e-6


@pytest.mark.parametrize("rigid", [False, True])
def test_a_run_goes_on_from_a_state_saved_in_jammed_gears(rigid):
    start = {"engine__speed_start": 110.0, "vehicle__speed_start": 0.0}
    with lossy(**start, transmission__rigid=rigid) as plant:
        plant.slave.setDebugLogging(True, ["logEvents"])
        plant.set("brake.torque", 5000.0)
        plant.start()
        drive(plant, 0.0, 1000, clutch1__position=4e-3)
        assert plant.get("output.speed") == 0.0
        assert any("output Forward -> Stuck" in text for text in texts(plant))
        saved = plant.saved()
        first = drive(plant, 1.0, 300, brake__torque=0.0)
        assert first[-1]["vehicle.speed"] > 0.1
        plant.restore(saved)
        assert drive(plant, 1.0, 300, brake__torque=0.0) == first


def test_a_gear_that_no_shaft_can_have_is_refused():
    with Instance(PLANT) as plant, pytest.raises(FMICallException):
        plant.set("shaft1.gear", 9)
