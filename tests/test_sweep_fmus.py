"""FMUs that stay open from run to run of a sweep: which do, and that nobody can tell."""

from __future__ import annotations

import json
import shutil
import zipfile
from pathlib import Path

import pytest
from dct_harness.errors import ConfigError
from dct_harness.fmu import fmu as fmu_module
from dct_harness.fmu.archive import unpack
from dct_harness.fmu.kept import Kept
from dct_harness.sweep import runs
from dct_harness.sweep.cases import Job
from dct_harness.sweep.runs import Row, Setup
from harness_fixture.lag_fmu import harness, write_system

LOOP = "examples/closed_loop/torque_tracking_case1.toml"
MASSES = (1300.0, 1500.0)  # kg


@pytest.fixture
def unpacked(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """FMUs that are unpacked, by a process that has none open."""
    found: list[Path] = []

    def noted(path: Path) -> Path:
        found.append(path)
        return unpack(path)

    monkeypatch.setattr(fmu_module, "unpack", noted)
    monkeypatch.setattr(runs, "KEPT", Kept())
    return found


def rows(folder: Path, engine: str, fmus: Path) -> list[Row]:
    """Return the rows of runs that differ in the vehicle's mass."""
    common = ("run", Path(LOOP), "--engine", engine, "--fmu-dir", fmus, "--stop", "3")
    prepared = runs.Prepared(Setup((*common, "--step", "0.005"), folder))
    jobs = [Job(k, {}, (), (f"plant.vehicle.mass={m}",)) for k, m in enumerate(MASSES)]
    return [prepared.run_one(job) for job in jobs]


@pytest.mark.parametrize("engine", ["fmpy", "native"])
def test_a_run_finds_fmus_open_and_gives_the_same_row(
    tmp_path: Path, repo_root: Path, unpacked: list[Path], monkeypatch: pytest.MonkeyPatch,
    engine: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(repo_root)
    first = rows(tmp_path, engine, Path("target/fmu"))
    assert len(unpacked) == 3  # by the first run
    again = rows(tmp_path, engine, Path("target/fmu"))
    assert len(unpacked) == 3
    assert json.dumps(again) == json.dumps(first)
    monkeypatch.setattr(runs, "KEPT", None)
    alone = rows(tmp_path, engine, Path("target/fmu"))
    assert len(unpacked) == 9
    assert json.dumps(alone) == json.dumps(first)
    assert first[0]["verdict"] == "not judged"
    assert first[0] != {**first[1], "run": 0}


def test_a_file_that_changes_is_opened_again(
    tmp_path: Path, repo_root: Path, unpacked: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repo_root)
    fmus = tmp_path / "fmus"
    shutil.copytree("target/fmu", fmus)
    first = rows(tmp_path, "native", fmus)
    with zipfile.ZipFile(fmus / "DctPlant.fmu", "a") as archive:
        archive.writestr("extra/note.txt", "of a later build")
    assert json.dumps(rows(tmp_path, "native", fmus)) == json.dumps(first)
    assert [path.name for path in unpacked[3:]] == ["DctPlant.fmu"]


def test_fmus_with_resources_and_of_others_are_opened_every_time(
    tmp_path: Path, repo_root: Path, lag_dir: Path, unpacked: list[Path],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(repo_root)
    fmus = tmp_path / "fmus"
    shutil.copytree("target/fmu", fmus)
    with zipfile.ZipFile(fmus / "DctObserver.fmu", "a") as archive:
        archive.writestr("resources/table.csv", "1")
    rows(tmp_path, "fmpy", fmus)
    assert [path.name for path in unpacked[3:]] == ["DctObserver.fmu"]
    unpacked.clear()
    lag = runs.Prepared(Setup(("run", write_system(tmp_path), "--fmu-dir", lag_dir), tmp_path))
    for number in range(2):
        lag.run_one(Job(number, {}))
    assert len(unpacked) == 2


def test_a_run_that_fails_leaves_no_fmu_behind(
    tmp_path: Path, repo_root: Path, unpacked: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repo_root)
    common = ("run", Path(LOOP), "--stop", "1", "--set", "plant.vehicle.mass=-1.0")
    with pytest.raises(ConfigError, match="is refused"):
        runs.Prepared(Setup(common, tmp_path)).run_one(Job(1, {}))
    count = len(unpacked)
    rows(tmp_path, "fmpy", Path("target/fmu"))
    assert len(unpacked) == count + 3


@pytest.mark.parametrize("more", [(), ("--jobs", "2"), ("--dask", "local", "--jobs", "1")])
def test_a_sweep_leaves_no_unpacked_file(
    tmp_path: Path, repo_root: Path, more: tuple[str, ...]
) -> None:
    words = ("sweep", repo_root / LOOP, "--fmu-dir", repo_root / "target/fmu", "--engine", "native",
             "--stop", "1", "--runs", "3", "--vary", "plant.vehicle.mass=uniform(1300,1500)",
             "--out", tmp_path / "out", *more)  # fmt: skip
    done = harness(*words, folder=tmp_path)  # it looks into the folder of temporary files
    assert done.returncode == 0, done.stderr
    assert "3 runs" in done.stdout
