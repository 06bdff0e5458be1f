"""`dct-harness sweep --dask`: the same rows from a cluster, also when a worker dies."""

from __future__ import annotations

import csv
import os
import signal
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from dct_harness.errors import ConfigError, FmuRuntimeError, HarnessError
from dct_harness.sweep.bundle import BLOBS, Bundle
from dct_harness.sweep.cases import Job
from dct_harness.sweep.on_dask import HERE, RUN, SCRATCH, cluster
from dct_harness.sweep.runs import Prepared, Row, Setup
from distributed import LocalCluster, get_worker
from harness_fixture.lag_fmu import harness, write_system

VARY = ("--runs", "4", "--vary", "plant.failAt=uniform(0.5,1.5)")
RUNS = 12
PATIENCE = 600.0  # s, for what is to happen soon, on a busy machine too


def rows(folder: Path, lag_dir: Path, name: str, *options: str) -> list[dict[str, str]]:
    """Return the rows of a sweep."""
    given = ("--fmu-dir", lag_dir, "--out", folder / name, *VARY, *options)
    done = harness("sweep", folder / "s.toml", *given, folder=folder)
    assert done.returncode == 1, done.stderr
    with (folder / name / "sweep.csv").open() as file:
        return list(csv.DictReader(file))


def test_a_cluster_of_this_machine_gives_the_same_rows(tmp_path: Path, lag_dir: Path) -> None:
    write_system(tmp_path)
    here = rows(tmp_path, lag_dir, "here")
    there = rows(tmp_path, lag_dir, "there", "--dask", "local", "--jobs", "2")
    assert there == here
    assert {row["verdict"] for row in here} == {"exit 4", "not judged"}


def kill_one_amid_a_run(folder: Path) -> None:
    """Kill a worker process as soon as a run of it has made its folder."""
    end = time.monotonic() + PATIENCE
    while not (made := list(folder.rglob(f"{RUN}*"))):
        assert time.monotonic() < end, "no run has begun"
        time.sleep(1e-3)
    os.kill(int(made[0].name.removeprefix(RUN).split("-")[0]), signal.SIGKILL)


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_worker_that_is_killed_loses_nothing_and_leaves_nothing(
    tmp_path: Path, lag_dir: Path, monkeypatch: pytest.MonkeyPatch, elsewhere: bool
) -> None:
    """The runs of the dead worker are taken by another one; by address, as a cluster elsewhere."""
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    system = write_system(tmp_path, "0.3")
    jobs = [Job(k, {"plant.tau": 1.0 + k}, (), (f"plant.tau={1.0 + k}",)) for k in range(RUNS)]
    slow = ("--set", "plant.delay=0.001")  # so that a run is met before its end
    setup = Setup(("run", system, "--fmu-dir", lag_dir, *slow), tmp_path / "out")
    files = [system, tmp_path / "s.csv", lag_dir / "Lag.fmu"]
    with ExitStack() as stack:
        address = HERE
        if elsewhere:
            there = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
            address = stack.enter_context(there).scheduler_address
        found = []
        for row in cluster(jobs, setup, files, address, 2):
            if not found:
                kill_one_amid_a_run(tmp_path)
            found.append(row)
    assert sorted(row["run"] for row in found) == list(range(RUNS))
    assert {row["verdict"] for row in found} == {"not judged"}
    alone = Prepared(setup).run_one(jobs[3])
    assert next(row for row in found if row["run"] == 3) == alone
    assert not [*tmp_path.rglob("dct-harness-*"), *tmp_path.rglob(SCRATCH)]


def test_what_a_killed_sweep_left_goes_with_the_next_one(tmp_path: Path, lag_dir: Path) -> None:
    left = tmp_path / "there" / SCRATCH / "dask-scratch-space" / "worker-of-old"
    left.mkdir(parents=True)
    write_system(tmp_path)
    rows(tmp_path, lag_dir, "there", "--dask", "local", "--jobs", "2")
    assert not (tmp_path / "there" / SCRATCH).exists()


def test_a_file_travels_by_its_content_once_whatever_its_name(tmp_path: Path) -> None:
    """Two names of one FMU are one content; the tree keeps how files lie to each other."""
    here, there = tmp_path / "here", tmp_path / "there"
    (here / "fmu").mkdir(parents=True)
    there.mkdir()
    named = {"fmu/A.fmu": b"fmu", "fmu/B.fmu": b"fmu", "s.toml": b"toml"}
    for name, content in named.items():
        (here / name).write_bytes(content)
    bundle = Bundle.of(here / name for name in named)
    assert sorted(bundle.blobs().values()) == [b"fmu", b"toml"]
    root = bundle.unpack(there, bundle.blobs())
    assert {n: (root / n).read_bytes() for n in named} == named
    assert len(list((there / BLOBS).iterdir())) == 2
    assert bundle.unpack(there, {}) == root  # nothing is asked for twice
    words = ("run", here / "s.toml", "--fmu-dir", here / "fmu", "--set", "plant.x=1")
    assert bundle.moved(words, root) == (
        "run", root / "s.toml", "--fmu-dir", root / "fmu", "--set", "plant.x=1")  # fmt: skip
    (here / "fmu/A.fmu").write_bytes(b"newer")
    changed = Bundle.of(here / name for name in named)
    assert changed.unpack(there, changed.blobs()) != root


def test_an_address_without_a_scheduler_is_a_sentence(
    tmp_path: Path, lag_dir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dct_harness.sweep.on_dask.GRACE", "1 s")
    setup = Setup(("run", write_system(tmp_path)), tmp_path)
    files = [tmp_path / "s.toml"]
    said = r"--dask tcp://127\.0\.0\.1:9: no scheduler there: .* after 1 s"
    with pytest.raises(ConfigError, match=said):
        list(cluster([Job(1, {})], setup, files, "tcp://127.0.0.1:9", 1))


def test_a_run_that_fails_is_tried_again_on_another_worker(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of three workers is broken: it fails whatever it gets, no run meets it twice."""
    made: dict[int, list[str]] = {}

    def broken(_: Prepared, job: Job, **__: object) -> tuple[Row, HarnessError | None]:
        worker = get_worker().address
        made.setdefault(job.number, []).append(worker)
        bad = worker == workers[0]
        row = {"run": job.number, "verdict": "exit 4" if bad else "not judged"}
        return row, FmuRuntimeError("broken") if bad else None

    monkeypatch.setattr(Prepared, "attempt", broken)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    jobs = [Job(k, {}, ()) for k in range(3 * RUNS)]
    system, setup = write_system(tmp_path), Setup((), tmp_path, retries=1)
    with LocalCluster(
        n_workers=3, threads_per_worker=1, processes=False, dashboard_address=None
    ) as there:
        workers = [w.address for w in there.workers.values()]
        found = list(cluster(jobs, setup, [system], there.scheduler_address, 3))
    assert sorted(row["run"] for row in found) == [job.number for job in jobs]
    assert {row["verdict"] for row in found} == {"not judged"}
    failed = [by for by in made.values() if len(by) > 1]
    assert failed, "the broken worker had nothing to do"
    assert all(by[0] == workers[0] != by[1] and len(by) == 2 for by in failed)
