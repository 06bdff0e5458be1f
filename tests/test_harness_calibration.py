"""What `calibrating` learnt in a run is written, and another run starts with it."""

from __future__ import annotations

from pathlib import Path

import closed_loop_runs
import numpy as np
import pytest
from closed_loop_runs import FMUS, SYSTEMS, rms
from dct_harness import cli, results
from dct_harness.ssp import calibration
from dct_harness.system import parameters

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
    second = run(tmp_path, "--calibration", str(first.path))  # or the file in it, as below
    name = "observer.calibration.inertiaError"
    assert second[name][0] == pytest.approx(first[name][-1], abs=1e-3)
    assert launch_error(second) < 0.5 * launch_error(first)


def test_the_file_has_every_parameter_with_deviation_and_friction(first: results.Results) -> None:
    assert first.path is not None
    told = parameters.read(first.path / "calibration.ssv")
    assert len(told) == 2 * (8 + 1 + 5 + 10)  # friction, its map's deviations, forces
    assert told["calibration.inertiaErrorStart"] == first["observer.calibration.inertiaError"][-1]
    deviation = first["observer.calibration.torqueBiasDeviation"][-1]
    assert told["calibration.torqueBiasSigma"] == deviation
    assert told["clutch1.nominalFriction"] == first["observer.clutch1.friction"][-1]
    assert np.isfinite(list(told.values())).all()


def test_an_observer_that_learns_nothing_leaves_no_file(first: results.Results) -> None:
    assert first.path is not None
    assert [path.name for path in first.path.glob("*.ssv")] == ["calibration.ssv"]


def worn(known: dict[str, dict], clutch: str) -> list[str]:
    """Return settings of a plant whose clutch has lost a third of its force where it touches."""
    position, force = calibration.force_map(known, clutch)
    left = 1 - np.maximum(9e-3 - position, 0) / 21e-3
    return [
        f"plant.{clutch}.map.force[{k}]={f!r}" for k, f in enumerate((force * left).tolist(), 1)
    ]


def tracked(out: Path, plant: list[str], *more: str) -> results.Results:
    """Run the launch on requested torques, the control by its map alone."""
    settings = ["observer.observer.method=calibrating", "control.feedback.enabled=false", *plant]
    command = ["run", str(SYSTEMS / "torque_tracking_case1.toml"), "--fmu-dir", str(FMUS)]
    command += ["--stop", STOP, "--out", str(out), "--quiet", *more]
    cli.main([*command, *(word for text in settings for word in ("--set", text))])
    return results.load(out)


def test_a_control_that_starts_with_the_learnt_map_carries_what_is_asked(tmp_path: Path) -> None:
    """Torque in the slip of a launch: a new control, one friction that was learnt, and the map."""
    start = closed_loop_runs.run("paper_case1", (), tmp_path / "parameters")
    plant = [text for k in (1, 2) for text in worn(start.run["parameters"]["plant"], f"clutch{k}")]
    first = tracked(tmp_path / "first", plant)
    learnt = tmp_path / "first" / "calibration.ssv"
    friction = parameters.read(learnt)["clutch1.nominalFriction"]
    number = ("--set", f"control.clutch1.nominalFriction={friction!r}")
    second = tracked(tmp_path / "number", plant, *number)
    third = tracked(tmp_path / "map", plant, "--calibration", str(learnt))
    missed = []
    for loop in (first, second, third):
        slips = (loop.time > 1.0) & (loop["plant.clutch1.slip"] > 3.0) & (loop.time < LAUNCH)
        asked = np.concatenate([[0.0], loop["scenario.clutch1.torqueRequest"][:-1]])
        missed.append(rms((loop["plant.clutch1.torque"] - asked)[slips]))
    assert missed[0] > 10.0
    assert missed[1] < 0.2 * missed[0]
    assert missed[2] < 0.4 * missed[1]


def test_a_torque_that_is_misread_is_found(tmp_path: Path) -> None:
    """Read 5 % and 2 N.m too high; the system limits what the torques miss."""
    loop = closed_loop_runs.run("calibration_torque", (), tmp_path)
    scale, bias = (f"observer.calibration.torque{end}" for end in ("Scale", "Bias"))
    told = loop[f"{scale}Deviation"][-1]  # 0.009: the factor that no speed shows
    assert loop[scale][-1] == pytest.approx(1 / 1.05 - 1, abs=told)
    assert loop[bias][-1] == pytest.approx(-2 / 1.05, abs=0.05)
    for name in (scale, bias):
        believed = loop.run["parameters"]["observer"][name.removeprefix("observer.") + "Sigma"]
        assert loop[f"{name}Deviation"][-1] < 0.5 * believed["value"], name
    page = (SYSTEMS.parent.parent / "docs/pages/howto/methods.md").read_text(encoding="utf-8")
    assert f"by {_missed(loop, 'kalman')} % of their RMS" in page
    assert f"`calibrating` by {_missed(loop, 'observer')} %" in page


def _missed(loop: results.Results, estimate: str) -> str:
    """Return what an estimate misses T_c1/T_c2/T_o by, in % of their RMS, as pages print it."""
    names = ("clutch1.torque", "clutch2.torque", "driveShaft.torque")
    pairs = [(loop[f"{estimate}.{name}"], loop[f"plant.{name}"]) for name in names]
    percent = [100.0 * rms(found - true) / rms(true) for found, true in pairs]
    return "/".join(f"{x:.1f}" if x < 9.95 else f"{x:.0f}" for x in percent)


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


@pytest.mark.parametrize(("there", "said"), [
    ("results.csv", "no calibration.ssv in this folder; `dct-harness run` writes it to --out at "
                    "the end of a run whose observer learns: "
                    "--set observer.observer.method=calibrating"),
    ("calibration.second.ssv", "of other observers there is calibration.second.ssv: name the file"),
    ("earlier/calibration.ssv", "no calibration.ssv in this folder; did you mean"),
])  # fmt: skip
def test_a_folder_without_what_was_learnt_is_told_with_the_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], there: str, said: str
) -> None:
    (tmp_path / there).parent.mkdir(exist_ok=True)
    (tmp_path / there).write_text("")
    command = ["run", str(SYSTEMS / "calibration_case1.toml"), "--fmu-dir", str(FMUS)]
    assert cli.main([*command, "--calibration", str(tmp_path), "--out", str(tmp_path / "o")]) == 2
    told = capsys.readouterr().err
    assert f"--calibration {tmp_path}: " in told
    assert said in told
