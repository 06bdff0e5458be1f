"""fmi2Terminated: an FMU that wants the simulation to end ends the run in good order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import (
    LAG,
    compile_library,
    run,
    variable,
    write_fmu,
    write_system,
)

STARTS = ((6, "reach"), (7, "most"), (8, "mute"), (13, "ends"), (14, "unsure"))
MORE = tuple(
    variable(name, k, "parameter", "0" if name in ("mute", "unsure") else "1e9")
    for k, name in STARTS
)
WAYS = (("none", "fmpy"), ("all", "fmpy"), ("none", "native"), ("all", "native"))
EVERY_WAY = pytest.mark.parametrize(("isolate", "engine"), WAYS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """Folder with a lag as Lag.fmu that ends the simulation; it takes one step size only."""
    path = tmp_path_factory.mktemp("terminated")
    write_fmu(path / "Lag.fmu", lag_library, (*LAG, *MORE), can="")
    return path


def ended(
    place: Path, fmus: Path, way: tuple[str, str], *settings: str, more: tuple[str, ...] = ()
) -> tuple[int, str, results.Results]:
    """Return exit code, what was told, and the results of a run with parameters of the lag."""
    given = [word for setting in settings for word in ("--set", f"plant.{setting}")]
    system = write_system(place)
    done = run(system, fmus, "--isolate", way[0], "--engine", way[1], *given, *more)
    return done.returncode, done.stderr, results.load(place / "out")


@EVERY_WAY
@pytest.mark.parametrize(("at", "samples"), [(0.25, 251), (0.2505, 251), (0.001, 2)])
def test_rows_up_to_the_end_that_it_asked_for_are_kept(
    tmp_path: Path, folder: Path, isolate: str, engine: str, at: float, samples: int
) -> None:
    code, told, found = ended(tmp_path, folder, (isolate, engine), f"ends={at}")
    said = f"asked to end the simulation at {at} s (fmi2Terminated)"
    assert (code, len(found.time)) == (4, samples)
    assert f"dct-harness: plant {said}, before the run's stop\n" in told
    assert np.abs(found["plant.x"] - 2 * (1 - np.exp(-found.time))).max() < 1e-12
    assert found.run["status"] == "partial"
    assert [(m["status"], m["message"]) for m in found.run["log"]] == [("Warning", said)]
    assert not (tmp_path / "out/kpis.json").exists()


@EVERY_WAY
def test_an_end_at_the_stop_itself_is_a_whole_run(
    tmp_path: Path, folder: Path, isolate: str, engine: str
) -> None:
    code, told, found = ended(tmp_path, folder, (isolate, engine), "ends=0.25",
                              more=("--stop", "0.25"))  # fmt: skip
    assert (code, len(found.time), found.run["status"]) == (0, 251, "complete"), told
    (message,) = found.run["log"]
    assert message["message"].startswith("asked to end the simulation at 0.25 s")


@EVERY_WAY
def test_one_that_does_not_tell_its_time_ends_at_the_last_point(
    tmp_path: Path, folder: Path, isolate: str, engine: str
) -> None:
    code, told, found = ended(tmp_path, folder, (isolate, engine), "ends=0.25", "mute=1.0")
    assert (code, len(found.time)) == (4, 250)
    assert "plant asked to end the simulation at 0.249 s (fmi2Terminated)" in told


@EVERY_WAY
def test_substeps_end_within_the_step(
    tmp_path: Path, folder: Path, isolate: str, engine: str
) -> None:
    system = write_system(tmp_path)
    system.write_text(system.read_text() + "substeps = 2\n")
    done = run(system, folder, "--isolate", isolate, "--engine", engine,
               "--set", "plant.ends=0.2505")  # fmt: skip
    assert done.returncode == 4
    assert "plant asked to end the simulation at 0.2505 s" in done.stderr
    assert len(results.load(tmp_path / "out").time) == 251


@EVERY_WAY
def test_an_end_that_it_is_not_sure_of_is_none(
    tmp_path: Path, folder: Path, isolate: str, engine: str
) -> None:
    code, told, _ = ended(tmp_path, folder, (isolate, engine), "ends=0.25", "unsure=1.0")
    assert code == 4
    assert "it cannot take this step and takes no other one" in told


def without(place: Path, function: str) -> Path:
    """Write the lag of a library that lacks a function; returns its folder."""
    hides = place / "hides.map"
    hides.write_text(f"{{ global: *; local: {function}; }};")
    library = compile_library(place, Path(f"-Wl,--version-script={hides}"))
    write_fmu(place / "Lag.fmu", library, (*LAG, *MORE), can="")
    return place


@EVERY_WAY
def test_an_fmu_without_the_function_is_not_asked(
    tmp_path: Path, isolate: str, engine: str
) -> None:
    fmus = without(tmp_path, "fmi2GetBooleanStatus")
    code, told, _ = ended(tmp_path, fmus, (isolate, engine), "ends=0.25")
    assert code == 4
    assert "it cannot take this step and takes no other one" in told


@EVERY_WAY
def test_a_function_that_a_run_does_not_call_may_be_missing(
    tmp_path: Path, isolate: str, engine: str
) -> None:
    fmus = without(tmp_path, "fmi2GetFMUstate")
    code, told, found = ended(tmp_path, fmus, (isolate, engine), "ends=1e9")
    assert (code, len(found.time)) == (0, 1001), told


@EVERY_WAY
def test_one_that_it_calls_is_named_where_it_is_missing(
    tmp_path: Path, isolate: str, engine: str
) -> None:
    fmus = without(tmp_path, "fmi2GetReal")
    done = run(write_system(tmp_path), fmus, "--isolate", isolate, "--engine", engine)
    said = "plant: fmi2GetReal at t = 0 s returned nothing: the FMU has no such function"
    assert (done.returncode, said in done.stderr) == (4, True), done.stderr


@EVERY_WAY
def test_a_library_without_what_every_run_calls_is_refused(
    tmp_path: Path, isolate: str, engine: str
) -> None:
    fmus = without(tmp_path, "fmi2DoStep")
    done = run(write_system(tmp_path), fmus, "--isolate", isolate, "--engine", engine)
    assert (done.returncode, "its library has no fmi2DoStep" in done.stderr) == (3, True)
