"""`dct-harness sweep`: plans that a seed repeats, runs that fail or are lost, going on later."""

from __future__ import annotations

import csv
import fcntl
import json
import math
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from dct_harness.errors import ConfigError
from dct_harness.sweep.cases import Job
from dct_harness.sweep.sampling import METHODS, parse, points
from dct_harness.sweep.workers import LOST, THREADS, parallel
from harness_fixture import computing
from harness_fixture.lag_fmu import HARNESS, environment, harness, write_system
from pyarrow import parquet

MANY = 20_000
STOPS = 60.0  # s; a sweep of minutes is to end long before, on a busy machine too
ENDS = 50.0  # s after which a process that is to end has ended, on a busy machine
HANG = 2  # mode of the hostile FMU
FOUR_SIGMA = 4.0  # of the sampling error: one wrong alarm in 16 000, and the seed is fixed


def drawn(texts: list[str], runs: int, seed: int, method: str = "random") -> dict[str, np.ndarray]:
    """Return the values of each varied number, shape (runs,)."""
    rows = points([parse(text) for text in texts], runs, seed, method)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def test_draws_have_the_moments_of_their_distribution() -> None:
    found = drawn(["a.x=uniform(2, 5)", "b.y=normal(10,0.5)"], MANY, 1)
    sigma = {"a.x": 3 / 12**0.5, "b.y": 0.5}
    for name, mean in (("a.x", 3.5), ("b.y", 10.0)):
        near = FOUR_SIGMA * sigma[name] / MANY**0.5
        assert found[name].mean() == pytest.approx(mean, abs=near)
        assert found[name].std() == pytest.approx(sigma[name], rel=0.03)
    assert (found["a.x"].min() >= 2, found["a.x"].max() <= 5) == (True, True)
    assert abs(np.corrcoef(found["a.x"], found["b.y"])[0, 1]) < FOUR_SIGMA / MANY**0.5


def test_a_seed_repeats_its_draws_and_another_does_not() -> None:
    first, again, other = (drawn(["a.x=uniform(0,1)"], 5, seed)["a.x"] for seed in (3, 3, 4))
    assert (first == again).all()
    assert (first != other).all()


@pytest.mark.parametrize("text", [
    "a.x", "a.x=uniform(1)", "a.x=gauss(1,2)", "a.x=uniform(2,1)", "a.x=normal(1,-1)",
    "a.x=normal(one,2)", "a.x=normal(nan,2)",
])  # fmt: skip
def test_what_is_no_draw_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="write COMPONENT"):
        drawn([text], 3, 0)


@pytest.mark.parametrize("method", [m for m in METHODS if m != "grid"])  # it draws nothing
def test_every_method_repeats_itself_by_the_seed(method: str) -> None:
    texts = ["a.x=uniform(0,1)", "b.y=normal(0,1)"]
    first, again, other = (drawn(texts, 8, seed, method) for seed in (3, 3, 4))
    assert all((first[n] == again[n]).all() and (first[n] != other[n]).all() for n in first)


@pytest.mark.parametrize("method", ["latin-hypercube", "sobol"])
def test_each_part_of_equal_probability_has_one_value(method: str) -> None:
    """Of a normal distribution too: its quantiles are found by the error function."""
    found = drawn(["a.x=uniform(2,4)", "b.y=normal(10,2)"], 64, 5, method)
    parts = {
        "a.x": (found["a.x"] - 2) / 2,
        "b.y": np.array([0.5 * (1 + math.erf((y - 10) / (2 * 2**0.5))) for y in found["b.y"]]),
    }
    for place in parts.values():
        assert sorted((64 * place).astype(int)) == list(range(64))


def test_sobol_fills_the_plane_better_than_chance() -> None:
    """Each of the 8 x 8 squares holds one of 64 points: the sequence is a (0, 6, 2)-net."""
    found = drawn(["a.x=uniform(0,8)", "b.y=uniform(0,8)"], 64, 1, "sobol")
    squares = set(zip(found["a.x"].astype(int), found["b.y"].astype(int), strict=True))
    assert len(squares) == 64


def test_choices_are_combined_with_every_set_of_numbers() -> None:
    factors = [parse(t) for t in ("a.x=uniform(0,1)", "b.n=choice(1, 2)", "b.m=choice(on,off)")]
    rows = points(factors, 3, 0, "random")
    assert len(rows) == 12
    assert len({row["a.x"] for row in rows}) == 3
    assert {(row["b.n"], row["b.m"]) for row in rows} == {(n, m) for n in (1, 2)
                                                          for m in ("on", "off")}  # fmt: skip
    assert len(points(factors[1:], 20, 0, "sobol")) == 4


@pytest.mark.parametrize(("texts", "runs", "method", "said"), [
    (["a.x=uniform(0,1)"], 48, "sobol", "--runs 48: sobol needs a power of two: 32 or 64"),
    (["a.x=uniform(0,1)", "a.x=normal(0,1)"], 4, "random", "--vary a.x: is varied twice"),
    (["a.x=choice(1,1)"], 4, "random", "name each choice once"),
    (["a.x=unifrom(0,1)"], 4, "random", "Did you mean 'uniform'?"),
    (["a.x=uniform(0,1)"], 0, "random", "needs at least one run"),
])  # fmt: skip
def test_a_plan_that_cannot_be_is_refused(
    texts: list[str], runs: int, method: str, said: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        drawn(texts, runs, 0, method)
    assert said in str(caught.value)


def sweep_rows(folder: Path, *options: str | Path) -> tuple[int, list[dict[str, str]]]:
    """Return exit code and rows of a sweep into `out` of a folder."""
    done = harness("sweep", folder / "s.toml", "--out", folder / "out", *options, folder=folder)
    assert "Traceback" not in done.stderr
    with (folder / "out/sweep.csv").open() as file:
        return done.returncode, list(csv.DictReader(file))


def test_several_processes_give_the_same_rows(lag_dir: Path, tmp_path: Path) -> None:
    write_system(tmp_path)
    options = (
        "--fmu-dir",
        lag_dir,
        "--runs",
        "4",
        "--sampling",
        "sobol",
        "--vary",
        "plant.failAt=uniform(0.5,1.5)",
        "--vary",
        "plant.tau=choice(1.0,2.0)",
    )
    code, rows = sweep_rows(tmp_path, *options)
    assert (code, len(rows)) == (1, 8)
    assert (code, rows) == sweep_rows(tmp_path, *options, "--jobs", "2")


def test_a_cut_sweep_goes_on_and_repeats_nothing(lag_dir: Path, tmp_path: Path) -> None:
    """Two rows are gone, one is another one: the first are made anew, the latter is believed."""
    write_system(tmp_path, "0.1")
    options = ("--fmu-dir", lag_dir, "--runs", "5", "--vary", "plant.tau=uniform(1,2)")
    rows = sweep_rows(tmp_path, *options)[1]
    store = tmp_path / "out/store"
    for number in (2, 4):
        (store / f"run-{number:06d}.parquet").unlink()
    kept = {**parquet.read_table(store / "run-000003.parquet").to_pylist()[0], "verdict": "kept"}
    parquet.write_table(pyarrow.Table.from_pylist([kept]), store / "run-000003.parquet")
    again = sweep_rows(tmp_path, *options, "--resume")[1]
    assert [r["verdict"] for r in again] == ["not judged"] * 2 + ["kept"] + ["not judged"] * 2
    assert [r["plant.tau"] for r in again] == [r["plant.tau"] for r in rows]


@pytest.mark.parametrize(("options", "changed"), [
    (("--seed", "9"), "seed"), (("--runs", "6"), "runs"), (("--fmu-dir", "other"), "files"),
])  # fmt: skip
def test_a_store_of_another_sweep_is_refused(
    lag_dir: Path, tmp_path: Path, options: tuple[str, str], changed: str
) -> None:
    write_system(tmp_path, "0.01")
    (tmp_path / "other").mkdir()
    given = ("sweep", tmp_path / "s.toml", "--out", tmp_path / "out", "--fmu-dir", lag_dir,
             "--runs", "2", "--vary", "plant.tau=uniform(1,2)")  # fmt: skip
    assert harness(*given, folder=tmp_path).returncode == 0
    done = harness(*given, "--resume", *options, folder=tmp_path)
    assert done.returncode == 2
    assert f"is of another sweep: {changed} changed; choose another --out" in done.stderr


def test_a_run_that_kills_its_process_is_recorded_and_the_others_go_on() -> None:
    rows = list(parallel([Job(k, {}) for k in range(1, 6)], _fatal, 2))
    assert sorted((r["run"], r["verdict"]) for r in rows) == [
        (1, "fine"), (2, "fine"), (3, LOST), (4, "fine"), (5, "fine"),
    ]  # fmt: skip


def _fatal(job: Job) -> dict[str, object]:
    if job.number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"run": job.number, "verdict": "fine"}


def _children(pid: int) -> set[int]:
    """Return the processes that a process started, and theirs."""
    files = Path(f"/proc/{pid}/task").glob("*/children")
    own = {int(child) for file in files for child in file.read_text().split()}
    return own.union(*map(_children, own))


def _alive(pids: set[int]) -> set[int]:
    """Return those that still run; a process that ended but was not waited for does not."""
    stats = {pid: Path(f"/proc/{pid}/stat") for pid in pids}
    return {pid for pid, stat in stats.items()
            if stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"}  # fmt: skip


def test_a_process_of_a_sweep_computes_in_one_thread_unless_the_user_chose(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv(THREADS, raising=False)
    (one,) = parallel([Job(1, {})], computing.threads, 1)
    assert THREADS not in os.environ
    monkeypatch.setenv(THREADS, "2")
    (two,) = parallel([Job(1, {})], computing.threads, 1)
    assert (one["threads"], two["threads"]) == (0, 1)


def test_workers_of_a_killed_sweep_end(lag_dir: Path, tmp_path: Path) -> None:
    """One is in the middle of a run of 1000 s, the other idle; nothing of either is left."""
    system = write_system(tmp_path, "1000.0")
    command = [*HARNESS, "sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "-v",
               "--runs", "2", "--vary", "plant.failAt=choice(0.01,2000.0)", "--jobs", "2",
               "--set", "plant.delay=0.001"]  # fmt: skip
    with subprocess.Popen(command, env=environment(tmp_path), stdout=subprocess.PIPE,
                          text=True) as process:  # fmt: skip
        process.stdout.readline()  # the run that fails at 0.01 s
        workers = _children(process.pid)
        process.kill()
    assert len(workers) >= 3  # two workers and what multiprocessing adds
    until = time.monotonic() + ENDS
    while _alive(workers) and time.monotonic() < until:
        time.sleep(0.05)
    assert _alive(workers) == set()
    assert list((tmp_path / "tmp").iterdir()) == []
    assert [f.name for f in (tmp_path / "out").glob("run-*")] == ["run-0001"]  # with a row


def _waits(pid: int) -> bool:
    """Return whether a process waits for a lock of another one."""
    return any("->" in line and f" {pid} " in line
               for line in Path("/proc/locks").read_text().splitlines())  # fmt: skip


def test_what_a_killed_sweep_left_of_a_run_goes_once_no_process_writes_it(
    lag_dir: Path, tmp_path: Path
) -> None:
    """A run without a row is made anew; what else lies in its folder, and others', stays."""
    write_system(tmp_path, "0.1")
    options = ("--fmu-dir", lag_dir, "--runs", "2", "--vary", "plant.tau=uniform(1,2)")
    sweep_rows(tmp_path, *options, "--keep")
    out = tmp_path / "out"
    (out / "store/run-000002.parquet").unlink()
    (out / "run-0002/results.part.csv").write_text("time")
    (out / "run-9").mkdir()
    command = [*HARNESS, "sweep", tmp_path / "s.toml", "--out", out, *options, "--resume"]
    store = os.open(out / "store", os.O_RDONLY)
    fcntl.flock(store, fcntl.LOCK_SH)  # as a worker of the killed sweep that is still there
    with subprocess.Popen(command, env=environment(tmp_path)) as process:
        until = time.monotonic() + ENDS
        while process.poll() is None and not _waits(process.pid) and time.monotonic() < until:
            time.sleep(0.01)
        assert (out / "run-0002/run.json").is_file()
        os.close(store)
    assert process.returncode == 0
    assert sorted(f.name for f in out.glob("run-*")) == ["run-0001", "run-9"]
    assert len(list((out / "store").iterdir())) == 2


def test_two_sweeps_at_once_in_one_folder_are_refused(lag_dir: Path, tmp_path: Path) -> None:
    write_system(tmp_path, "0.01")
    (tmp_path / "out").mkdir()
    other = os.open(tmp_path / "out", os.O_RDONLY)
    fcntl.flock(other, fcntl.LOCK_EX)
    done = harness("sweep", tmp_path / "s.toml", "--fmu-dir", lag_dir, "--out", tmp_path / "out",
                   "--vary", "plant.tau=uniform(1,2)", folder=tmp_path)  # fmt: skip
    os.close(other)
    assert done.returncode == 2
    assert done.stderr.endswith("another sweep is at work there; choose another folder\n")


def test_sweep_judges_every_run_and_goes_on_after_a_failure(lag_dir: Path, tmp_path: Path) -> None:
    system = write_system(tmp_path)
    words = ["sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "--runs", "6",
             "--vary", "plant.failAt=uniform(0.5,1.5)"]  # fmt: skip
    done = harness(*words, folder=tmp_path)
    assert done.returncode == 1, done.stderr
    with (tmp_path / "out/sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    verdicts = [row["verdict"] for row in rows]
    assert verdicts == ["exit 4" if float(r["plant.failAt"]) < 1 else "not judged" for r in rows]
    failed = verdicts.count("exit 4")
    assert 0 < failed < 6
    assert f"verdict: fail, {failed} of 6 runs miss a limit" in done.stdout
    kept = list((tmp_path / "out").glob("run-*"))
    assert len(kept) == failed  # those that failed, to look at


def test_unknown_parameter_ends_the_sweep_with_2(lag_dir: Path, tmp_path: Path) -> None:
    done = harness("sweep", write_system(tmp_path), "--fmu-dir", lag_dir, "--vary",
                   "plant.tua=uniform(1,2)", folder=tmp_path)  # fmt: skip
    assert done.returncode == 2
    assert "Did you mean 'tau'?" in done.stderr


def _hear_ctrl_c() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_keeps_the_runs_so_far(lag_dir: Path, tmp_path: Path, jobs: str) -> None:
    system = write_system(tmp_path)
    command = [*HARNESS, "sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out",
               "--runs", "5000", "-v", "--vary", "plant.tau=uniform(1,2)",
               "--jobs", jobs]  # fmt: skip
    # Tests that a shell started in the background have SIGINT ignored, and would pass that on.
    with subprocess.Popen(command, env=environment(tmp_path), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True,
                          preexec_fn=_hear_ctrl_c) as process:  # fmt: skip
        process.stdout.readline()
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=STOPS)
    assert process.returncode == 130
    with (tmp_path / "out/sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert 1 <= len(rows) < 1000
    assert said.endswith(f"dct-harness: interrupted: {len(rows)} of 5000 runs are kept in "
                         f"{tmp_path / 'out'}, --resume makes the others\n")  # fmt: skip
    assert list((tmp_path / "tmp").iterdir()) == []


def test_a_second_ctrl_c_ends_runs_whose_fmu_does_not_return(tmp_path: Path, hostile: Path) -> None:
    """The first waits for the FMU until --call-timeout, 60 s."""
    system = write_system(tmp_path)
    command = [*HARNESS, "sweep", system, "--fmu-dir", hostile, "--runs", "8",
               "--out", tmp_path / "out", "-v", "--vary", f"plant.mode=choice(0,{HANG})",
               "--jobs", "2"]  # fmt: skip
    with subprocess.Popen(command, env=environment(tmp_path), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, preexec_fn=_hear_ctrl_c) as process:  # fmt: skip
        process.stdout.readline()
        workers = _children(process.pid)
        until = time.monotonic() + ENDS
        while process.poll() is None and time.monotonic() < until:
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        in_time = process.poll()
        process.kill()
    while _alive(workers) and time.monotonic() < until:
        time.sleep(0.05)
    assert in_time in (130, -signal.SIGINT)  # the last one may come when Python itself has ended
    assert _alive(workers) == set()


@pytest.mark.parametrize("engine", ["fmpy", "native"])
def test_an_fmu_that_does_not_return_ends_its_run_after_the_time_of_a_call(
    tmp_path: Path, hostile: Path, engine: str
) -> None:
    system, out = write_system(tmp_path), tmp_path / "out"
    words = ("sweep", system, "--fmu-dir", hostile, "--engine", engine, "--out", out,
             "--vary", f"plant.mode=choice({HANG})")  # fmt: skip
    done = harness(*words, "--call-timeout", "1", folder=tmp_path)
    assert done.returncode == 1, done.stderr
    with (out / "sweep.csv").open() as file:
        (hung,) = csv.DictReader(file)
    assert hung["verdict"] == "exit 5"
    assert hung["error"].endswith(" 1 s (--call-timeout)")
    again = harness(*words, "--call-timeout", "2", "--resume", folder=tmp_path)  # the same sweep
    assert again.returncode == 1, again.stderr


def test_sweep_as_json_is_the_spread_of_its_csv(lag_dir: Path, tmp_path: Path) -> None:
    limit = '[[kpis]]\nkpi = "shift.jerkPeak"\nsignal = "vehicle.acceleration"\nmax = 1\n'
    system = write_system(tmp_path)
    system.write_text(system.read_text() + limit)
    done = harness("sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", "--runs", "3",
                   "--vary", "plant.tau=uniform(1,2)", "--json", folder=tmp_path)  # fmt: skip
    told = json.loads(done.stdout)
    assert (told["runs"], told["missed"], told["verdict"]) == (3, 3, "fail")
    assert done.returncode == 1
    assert done.stderr == ""
