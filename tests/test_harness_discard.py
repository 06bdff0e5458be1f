"""fmi2Discard of fmi2DoStep: the step is divided, or the error says why it cannot be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
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
