"""What `calibrating` learnt in a run is written, and another run starts with it."""

from __future__ import annotations

from pathlib import Path

import closed_loop_runs
import numpy as np
import pytest
from closed_loop_runs import FMUS, SYSTEMS, rms
from dct_harness import cli, parameters, results

STOP = "6"  # s: the launch of the paper's scenario, and a drive
SOFT = "observer.driveShaft.stiffness=4300"  # of 4887 N.m/rad
LAUNCH = 3.0  # s


def run(out: Path, *more: str) -> results.Results:
    """Run the system with wrong engine inertia and shaft stiffness until after the launch."""
    command = ["run", str(SYSTEMS / "calibration_case1.toml"), "--fmu-dir", str(FMUS)]
    cli.main([*command, "--stop", STOP, "--set", SOFT, "--out", str(out), "--quiet", *more])
    return results.load(out)


def launch_error(run: results.Results) -> float:
    """Return the RMS error of T_o over the launch [N.m]."""
    error = run["observer.driveShaft.torque"] - run["plant.driveShaft.torque"]
    return rms(error[run.time < LAUNCH])


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> results.Results:
    """A run that starts with nothing learnt."""
    return run(tmp_path_factory.mktemp("first"))


def test_a_second_run_starts_with_what_the_first_has_learnt(
    first: results.Results, tmp_path: Path
) -> None:
    assert first.path is not None
    second = run(tmp_path, "--calibration", str(first.path / "calibration.ssv"))
    name = "observer.calibration.inertiaError"
    assert second[name][0] == pytest.approx(first[name][-1], abs=1e-3)
    assert launch_error(second) < 0.5 * launch_error(first)


def test_the_file_has_every_parameter_with_deviation_and_friction(first: results.Results) -> None:
    assert first.path is not None
    told = parameters.read(first.path / "calibration.ssv")
    assert len(told) == 2 * 8 + 2
    assert told["calibration.inertiaErrorStart"] == first["observer.calibration.inertiaError"][-1]
    deviation = first["observer.calibration.torqueBiasDeviation"][-1]
    assert told["calibration.torqueBiasSigma"] == deviation
    assert told["clutch1.nominalFriction"] == first["observer.clutch1.friction"][-1]
    assert np.isfinite(list(told.values())).all()


def test_an_observer_that_learns_nothing_leaves_no_file(first: results.Results) -> None:
    assert first.path is not None
    assert [path.name for path in first.path.glob("*.ssv")] == ["calibration.ssv"]


def test_a_torque_that_is_misread_is_found(tmp_path: Path) -> None:
    """Read 5 % and 2 N.m too high; the system limits what the torques miss."""
    loop = closed_loop_runs.run("calibration_torque", (), tmp_path)
    scale, bias = (f"observer.calibration.torque{end}" for end in ("Scale", "Bias"))
    assert loop[scale][-1] == pytest.approx(1 / 1.05 - 1, abs=0.005)
    assert loop[bias][-1] == pytest.approx(-2 / 1.05, abs=0.05)
    for name in (scale, bias):
        believed = loop.run["parameters"]["observer"][name.removeprefix("observer.") + "Sigma"]
        assert loop[f"{name}Deviation"][-1] < 0.5 * believed["value"], name


def test_a_system_without_observer_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    system = tmp_path / "alone.toml"
    text = (SYSTEMS / "paper_case1.toml").read_text(encoding="utf-8")
    text = text.replace("[components.observer]", "[components.watcher]").split("[[kpis]]")[0]
    system.write_text(text.replace("scenarios/", f"{SYSTEMS}/scenarios/"), encoding="utf-8")
    command = ["run", str(system), "--fmu-dir", str(FMUS), "--calibration", "x.ssv", "--quiet"]
    assert cli.main(command) == 2
    assert "--calibration" in capsys.readouterr().err
