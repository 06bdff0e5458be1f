"""DctClutchControl alone: limits, sense of a request, and whom it believes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from closed_loop_runs import FMUS, Runs
from dct_harness import kpi
from fmu_instance import Instance

STEP = 1e-3  # s
REACH = 100  # steps: at 0.2 m/s the actuator crosses its whole stroke in 50
TOUCH = 2e-3  # m, of clutch 1, preset `paper`
NOMINAL = 0.4  # friction case 1
SOFT = 60.0  # N·m·s/rad: a drive shaft that swings, where Table 1 has 567
DAMPED = 0.9  # RMS jerk with `damping` / without, promised where the shaft swings


@pytest.fixture
def control() -> Instance:
    """The control, initialised by the test."""
    with Instance(FMUS / "DctClutchControl.fmu") as instance:
        instance.clock = itertools.count()
        yield instance


def _settle(control: Instance, **inputs: float | bool) -> float:
    """Set inputs (`__` for a dot), wait until the actuator stands, return its position [m]."""
    for name, value in inputs.items():
        control.set(name.replace("__", "."), value)
    for _ in range(REACH):
        control.step(next(control.clock) * STEP, STEP)
    return control.get("clutch1.position")


def _position(torque: float, friction: float) -> float:
    """Return the position [m] of clutch 1 that carries a torque [N·m], from its map."""
    stroke = np.array([2, 3, 4, 5, 6, 7, 8, 9, 10]) / 1000
    force = [0, 250, 700, 1350, 2200, 3300, 4700, 6400, 8500]
    return float(np.interp(torque / (friction * 0.095), force, stroke))


def test_a_braking_request_waits_until_it_can_brake(control: Instance) -> None:
    control.start()
    faster = {"engine__speed": 200.0, "clutch1__speed": 150.0}
    slower = {"engine__speed": 150.0, "clutch1__speed": 200.0}
    request = {"clutch1__torqueRequest": -40.0, "feedback__enabled": False}
    assert _settle(control, **request, **faster) == TOUCH
    assert _settle(control, **slower) == pytest.approx(_position(40.0, NOMINAL))
    assert _settle(control, clutch1__speed=150.0) == pytest.approx(_position(40.0, NOMINAL))


def test_a_driving_request_is_a_capacity_whatever_the_slip(control: Instance) -> None:
    control.start()
    request = {"clutch1__torqueRequest": 40.0, "feedback__enabled": False}
    for engine in (100.0, 150.0, 200.0):
        held = _settle(control, **request, engine__speed=engine, clutch1__speed=150.0)
        assert held == pytest.approx(_position(40.0, NOMINAL))


def test_the_actuator_stays_within_rate_and_stroke(control: Instance) -> None:
    control.set("clutch1.strokeMaximum", 0.008)
    control.set("clutch1.strokeMinimum", 0.001)
    control.set("clutch1.rateLimit", 0.1)
    control.start()
    positions = [control.get("clutch1.position")]
    for k in range(2 * REACH):
        control.set("clutch1.torqueRequest", 1000.0 if k < REACH else 0.0)
        control.step(k * STEP, STEP)
        positions.append(control.get("clutch1.position"))
    assert max(positions) == 0.008
    assert min(positions) == 0.001
    assert np.abs(np.diff(positions)).max() == pytest.approx(0.1 * STEP)


def test_a_stroke_without_length_is_refused(control: Instance) -> None:
    control.set("clutch2.strokeMinimum", 0.01)
    with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
        control.start()
    assert "clutch2.strokeMaximum = 0.01 must be above strokeMinimum" in control.log[-1].message


def test_an_estimate_that_is_not_valid_changes_nothing(control: Instance) -> None:
    control.start()
    slipping = {"engine__speed": 200.0, "clutch1__speed": 150.0, "clutch1__torqueRequest": 40.0}
    learnt = {"clutch1__friction": 0.26, "clutch1__torque": 40.0}
    assert _settle(control, **slipping, **learnt) == pytest.approx(_position(40.0, 0.26))
    wrong = {"status__valid": False, "clutch1__friction": 0.05, "clutch1__torque": 5.0}
    assert _settle(control, **wrong) == pytest.approx(_position(40.0, 0.26))
    assert control.get("clutch1.trim") == 0.0
    assert _settle(control, status__valid=True) != pytest.approx(_position(40.0, 0.26))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Runs of the closed loop."""
    return Runs(tmp_path_factory.mktemp("control"))


def _jerk(runs: Runs, damping: float) -> dict[str, float]:
    """Return the RMS jerk [m/s³] per scope with a soft drive shaft."""
    shaft = [f"{part}.driveShaft.damping={SOFT}" for part in ("plant", "observer")]
    gains = [f"control.clutch{i}.damping={damping}" for i in (1, 2)]
    loop = runs("torque_tracking_case1", *shaft, *gains)
    rows = kpi.compute(loop, loop.run)["rows"]
    return {r["scope"]: r["value"] for r in rows if r["kpi"] == "shift.jerkRms"}


def test_drive_shaft_feedback_damps_a_shaft_that_swings(runs: Runs) -> None:
    damped, free = (_jerk(runs, gain) for gain in (0.01, 0.0))
    for phase in ("phase/launch", "phase/upshift"):
        assert damped[phase] <= DAMPED * free[phase], (phase, damped[phase], free[phase])


def test_the_control_reads_estimates_not_the_truth(runs: Runs) -> None:
    wires = {w["to"]: w["from"] for w in runs("torque_tracking_case1").run["wiring"]}
    for name in ("clutch1.torque", "clutch2.torque", "driveShaft.torque", "status.valid"):
        assert wires[f"control.{name}"] == f"observer.{name}"
    assert wires["control.engine.speed"] == "plant.engine.speed"
