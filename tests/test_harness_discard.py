"""fmi2Discard of fmi2DoStep: the step is divided, or the error says why it cannot be."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import fmi2Discard, fmi2LastSuccessfulTime, fmi2Terminated
from fmu_instance import Instance
from harness_fixture.lag_fmu import LAG, run, variable, write_fmu, write_system

STARTS = (("reach", "1e9"), ("most", "1e9"), ("mute", "0"))
MORE = tuple(variable(name, k, "parameter", start) for k, (name, start) in enumerate(STARTS, 6))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """Folder with a lag as Lag.fmu that discards steps."""
    path = tmp_path_factory.mktemp("discard")
    write_fmu(path / "Lag.fmu", lag_library, (*LAG, *MORE))
    return path


@pytest.mark.parametrize("isolate", ["none", "all"])
@pytest.mark.parametrize("option", ["plant.reach=0.0004", "plant.most=0.0003"])
def test_a_discarded_step_is_divided(
    tmp_path: Path, folder: Path, isolate: str, option: str
) -> None:
    """The lag answers a held input exactly, in steps of any length."""
    done = run(write_system(tmp_path), folder, "--isolate", isolate, "--set", option)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    assert np.abs(found["plant.x"] - 2 * (1 - np.exp(-found.time))).max() < 1e-12
    (told,) = found.run["log"]
    assert (told["time"], told["status"]) == (0.0, "Warning")
    assert told["message"].endswith("returned fmi2Discard; this step was divided")


@pytest.mark.parametrize("isolate", ["none", "all"])
@pytest.mark.parametrize(("options", "said"), [
    (("plant.most=0.0",), "it does not get past t = 0 s, whatever the step"),
    (("plant.most=0.0003", "plant.mute=1.0"), "it does not tell how far it got"),
])  # fmt: skip
def test_an_fmu_that_does_not_get_on_ends_the_run(
    tmp_path: Path, folder: Path, isolate: str, options: tuple[str, ...], said: str
) -> None:
    given = [word for option in options for word in ("--set", option)]
    done = run(write_system(tmp_path), folder, "--isolate", isolate, *given)
    assert done.returncode == 4, done.stderr
    assert f"plant: fmi2DoStep at t = 0 s returned fmi2Discard: {said}" in done.stderr


def test_an_fmu_of_one_step_size_is_not_asked_for_another(
    tmp_path: Path, lag_library: Path
) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG, *MORE), can="")
    done = run(write_system(tmp_path), tmp_path, "--set", "plant.reach=0.0004")
    assert done.returncode == 4
    assert "it cannot take this step and takes no other one; change system.step" in done.stderr


@pytest.mark.parametrize("engine", ["fmpy", "native"])
def test_a_step_too_long_for_our_observer_is_halved_until_it_is_not(
    repo_root: Path, tmp_path: Path, engine: str
) -> None:
    """Half a second is above its longest step, a sixteenth is not: eight substeps."""
    text = (repo_root / "examples/closed_loop/paper_case1.toml").read_text()
    text = text.replace('"scenarios/', f'"{repo_root}/examples/closed_loop/scenarios/')
    text = text.replace("step = 0.001", "step = 0.5").split("[[kpis]]")[0]
    fmu = 'fmu = "DctObserver.fmu"\n'
    found = []
    for name, more in (("whole", ""), ("parts", "substeps = 8\n")):
        (tmp_path / name).mkdir()
        system = tmp_path / name / "s.toml"
        system.write_text(text.replace(fmu, fmu + more))
        done = run(system, repo_root / "target/fmu", "--engine", engine)
        assert done.returncode == 0, done.stderr
        found.append(results.load(system.parent / "out"))
    whole, parts = found
    told = [m["message"] for m in whole.run["log"] if m["status"] in ("Warning", "Discard")]
    assert "fmi2DoStep: communicationStepSize = 0.5 s is above 0.1 s" in told
    assert "fmi2DoStep at t = 0 s returned fmi2Discard; this step was divided" in told
    assert not [m for m in parts.run["log"] if "communicationStepSize" in m["message"]]
    for signal, values in whole.signals.items():
        assert np.array_equal(values, parts[signal]), signal


@pytest.mark.parametrize("engine", ["fmpy", "native"])
@pytest.mark.parametrize("step", [0.2, 0.3, 0.12])
def test_steps_that_are_no_binary_fractions_are_divided_all_the_way(
    repo_root: Path, tmp_path: Path, engine: str, step: float
) -> None:
    """The observer adds up its steps, a master multiplies: they differ in a last bit."""
    loops = repo_root / "examples/closed_loop"
    system = tmp_path / "s.toml"
    system.write_text(
        (loops / "paper_case1.toml").read_text().replace('"scenarios', f'"{loops}/scenarios')
    )
    more = ("--engine", engine, "--step", f"{step}", "--stop", f"{25 * step}")
    done = run(system, repo_root / "target/fmu", *more)
    assert done.returncode in (0, 1), done.stderr  # it ran; limits are for 1 ms
    assert results.load(tmp_path / "out").time[-1] == pytest.approx(25 * step, abs=1e-9)


def test_fmpy_may_go_on_after_a_step_that_was_too_long(repo_root: Path) -> None:
    speeds = []
    for first in (100.0, None):
        with Instance(repo_root / "target/fmu/DctPlant.fmu") as plant:
            plant.slave.setupExperiment()
            plant.slave.enterInitializationMode()
            plant.set("engine.torque", 60.0)
            plant.slave.exitInitializationMode()
            plant.slave.doStep(0.0, 0.25)
            if first is not None:
                refused(plant, lambda: plant.slave.doStep(0.25, 100.0))
                assert plant.slave.getRealStatus(fmi2LastSuccessfulTime) == 0.25
                refused(plant, lambda: plant.slave.getBooleanStatus(fmi2Terminated))
            plant.slave.doStep(0.25, 0.25)
            speeds.append(plant.get("engine.speed"))
            plant.slave.terminate()
    assert speeds[0] == speeds[1] > 0


def refused(fmu: Instance, call: Callable[[], object]) -> None:
    """Demand fmi2Discard of a call, and that it is told."""
    with pytest.raises(FMICallException) as caught:
        call()
    assert caught.value.status == fmi2Discard == fmu.log[-1].status
