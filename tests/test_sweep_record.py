"""What a run of a sweep records: only what its row needs, with the same row to the last bit."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import cosim_native
import numpy as np
import pytest
from dct_harness import kpi, results
from dct_harness.fmu.archive import DESCRIPTION
from dct_harness.fmu.ports import OURS
from dct_harness.master import wiring
from dct_harness.master.native import NativeRun
from dct_harness.master.wiring import wire
from dct_harness.results import Results
from dct_harness.sweep.cases import Job
from dct_harness.sweep.runs import COURSES, Prepared, Setup
from dct_harness.verbs import run as run_verb
from harness_fixture.lag_fmu import write_fmu, write_system

LOOPS = "examples/closed_loop"
ANTRIEB = ("--plant", "{fmus}/Antrieb.fmu", "--map", "examples/supplier_plant/antrieb.toml")
ON_A_SHIFT = """[[kpis]]
kpi = "shift.duration"
signal = "clutch1 → clutch2"
scope = "shift 1"
max = 9
"""
RUNS = 60  # of random signals
CLUTCH_WORDS = ("torque", "state", "slip", "speed", "frictionPower", "frictionEnergy")
CLUTCH = [f"plant.{c}.{n}" for c in ("clutch1", "clutch2") for n in CLUTCH_WORDS]
OTHERS = [
    "plant.engine.speed", "plant.damper.speed", "plant.vehicle.speed", "plant.vehicle.acceleration",
    "plant.driveShaft.torque", "plant.wheel.speed", "scenario.clutch1.torqueRequest",
    "scenario.clutch2.torqueRequest", "scenario.engine.torque", "observer.clutch1.torque",
    "observer.driveShaft.torque", "observer.mapBased.clutch1.torque", "kalman.driveShaft.torque",
    "observer.clutch1.friction",
]  # fmt: skip


class Seen(NativeRun):
    """A native run that tells how many signals it has and how many it records."""

    counts: ClassVar[list[tuple[int, int]]] = []

    def _loop(self, progress: Any) -> None:
        try:
            super()._loop(progress)
        finally:
            self.counts.append((len(self.names), len(self.kept)))


@pytest.fixture
def counts(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, int]]:
    """Signals and recorded signals of each run, as they end."""
    monkeypatch.setitem(run_verb.ENGINES, "native", Seen)
    monkeypatch.setattr(Seen, "counts", [])
    return Seen.counts


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """Folder with the C plant and the lag as if built here, which need no process apart."""
    folder = tmp_path_factory.mktemp("own")
    command = [sys.executable, "examples/supplier_plant/build.py", folder, "antrieb"]
    subprocess.run(command, check=True, capture_output=True)
    write_fmu(folder / "Lag.fmu", lag_library)
    for path in folder.glob("*.fmu"):
        _claim(path)
    return folder


def _claim(path: Path) -> None:
    """Let the description of an FMU say that this project built it."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    text = re.sub(r'\s*generationTool="[^"]*"', "", members[DESCRIPTION].decode())
    head = "<fmiModelDescription "
    members[DESCRIPTION] = text.replace(head, f'{head}generationTool="{OURS}" ').encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)


def prepared(folder: Path, system: str | Path, *words: str | Path, **more: Any) -> Prepared:
    """Return who makes runs of a sweep of one system."""
    common = ("run", Path(system), "--engine", "native", *words)
    return Prepared(Setup(common, folder, **more))


@pytest.mark.parametrize(("system", "words", "globs"), [
    (f"{LOOPS}/torque_tracking_case1.toml", ("--stop", "8"), ()),
    (f"{LOOPS}/methods_case1.toml", ("--stop", "6"), ("*.driveShaft.torque", "scenario.*")),
    (f"{LOOPS}/launch_wet6.toml", ("--step", "0.01"), ("plant.*",)),
    (f"{LOOPS}/hot_clutch.toml", ("--step", "0.01", "--interpolate"), ()),
    ("examples/study/loop.toml", ("--stop", "5"), ("kalman.clutch1.torque",)),
    (f"{LOOPS}/paper_case1.toml", ("--stop", "8", *ANTRIEB), ("plant.vehicle.speed",)),
    (f"{LOOPS}/paper_case1.toml", ("--stop", "8", *ANTRIEB, "--isolate", "all"), ()),
])  # fmt: skip
def test_the_row_is_that_of_a_run_that_records_everything(
    tmp_path: Path, own: Path, repo_root: Path, counts: list[tuple[int, int]],
    monkeypatch: pytest.MonkeyPatch, system: str, words: tuple[str, ...], globs: tuple[str, ...],
) -> None:  # fmt: skip
    monkeypatch.chdir(repo_root)
    given = [word.format(fmus=own) for word in words]
    told = prepared(tmp_path, system, *given, signals=globs)
    (few, none), (all_, nothing) = (told.attempt(Job(1, {}), whole) for whole in (False, True))
    assert (none, nothing) == (None, None), few
    assert json.dumps(few) == json.dumps(all_)
    assert COURSES in few or not globs
    (signals, recorded), (same, everything) = counts
    assert recorded < signals == same == everything
    assert recorded < signals / 2 or globs


def test_runs_are_not_taken_for_earlier_ones(
    tmp_path: Path, own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What stays from run to run is wired anew for other inputs, scenarios and options."""
    made: list[Any] = []
    monkeypatch.setattr(wiring, "wire", lambda *of: made.append(wire(*of)) or made[-1])
    other = tmp_path / "other.csv"
    other.write_text("time,u\n0,2\n1,7\n")
    of = (tmp_path, write_system(tmp_path), "--fmu-dir", own)
    jobs = [
        Job(1, {}, (), ("plant.tau=0.5",)), Job(1, {}, (), ("plant.tau=0.9",)),
        Job(1, {}, (), ("plant.tau=0.5", "plant.u=1.5")), Job(1, {}, ("--scenario", other)),
        Job(1, {}, ("--stop", "0.4")), Job(1, {}, (), ("plant.tau=0.5",)),
    ]  # fmt: skip
    whole = prepared(*of, signals=("*",))
    rows = [json.dumps(whole.attempt(job)[0]) for job in jobs]
    assert len(made) == 5  # the second run is like the first one
    assert rows == [json.dumps(prepared(*of, signals=("*",)).attempt(job)[0]) for job in jobs]
    assert len(set(rows)) == 5
    assert rows[0] == rows[-1]


def test_limits_on_a_part_are_judged_alike(
    tmp_path: Path, repo_root: Path, counts: list[tuple[int, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(repo_root)
    text = (repo_root / LOOPS / "paper_case1.toml").read_text().partition("[[kpis]]")[0]
    for word in ("scenarios/", "parameters/"):
        text = text.replace(f'"{word}', f'"{repo_root / LOOPS / word}/')
    (tmp_path / "s.toml").write_text(text + ON_A_SHIFT)
    told = prepared(tmp_path, tmp_path / "s.toml", "--stop", "12")
    few, all_ = (told.attempt(Job(1, {}), whole)[0] for whole in (False, True))
    assert json.dumps(few) == json.dumps(all_)
    assert few["verdict"] == "pass"
    assert counts[0][1] < counts[0][0]


def random_runs() -> Iterator[tuple[dict[str, np.ndarray], dict[str, Any]]]:
    """Yield runs that have any of the signals that KPIs may be of, and what their limits are on."""
    limit = {"kpi": "shift.duration", "signal": "clutch1 → clutch2", "max": 1}
    time = np.arange(400) * 0.01
    for seed in range(RUNS):
        draw = np.random.default_rng(seed)
        share = draw.uniform(0.3, 1.0)
        names = [n for n in (*CLUTCH, *OTHERS) if draw.random() < share]
        signals = {n: draw.normal(size=400).cumsum() for n in names}
        for name in names:
            if name.endswith("state"):
                signals[name] = np.repeat(draw.integers(1, 4, size=20), 20).astype(float)
        scoped = {**limit, "scope": "shift 1"} if seed % 2 else limit
        yield {"time": time, **signals}, {"system": {"kpis": [scoped]}}


def test_kpis_read_what_they_say_they_read() -> None:
    found, unread = 0, 0
    for signals, run in random_runs():
        read = kpi.reads(signals.keys() - {"time"}, run)
        unkept = frozenset(signals) - read - {"time"}
        kept = {name: values for name, values in signals.items() if name not in unkept}
        whole = kpi.compute(Results(signals, run), run, whole=True)
        assert kpi.compute(Results(kept, run, None, unkept), run, whole=True) == whole
        found, unread = found + len(whole["rows"]), unread + len(unkept)
    assert found > RUNS
    assert unread > RUNS


def test_a_signal_that_was_not_recorded_is_no_missing_one() -> None:
    run = Results({"time": np.zeros(1)}, {}, None, frozenset({"plant.x"}))
    assert "plant.x" in run
    with pytest.raises(KeyError, match=r"'plant\.x' was not recorded in this run"):
        run["plant.x"]


@pytest.mark.parametrize("retries", [0, 1, 2])
def test_a_run_that_fails_is_made_again_and_keeps_all_signals(
    tmp_path: Path, own: Path, counts: list[tuple[int, int]], retries: int
) -> None:
    words = ("--fmu-dir", own, "--set", "plant.failAt=0.25")
    told = prepared(tmp_path, write_system(tmp_path), *words, retries=retries)
    row = told.run_one(Job(1, {}))
    assert row["verdict"] == "exit 4"
    assert counts == [(2, 0), *[(2, 2)] * max(1, retries)]
    kept = results.load(tmp_path / "run-0001")
    assert list(kept.signals) == ["time", "scenario.u", "plant.x"]
    assert (len(kept.time), kept.run["status"], kept.run["error"]) == (251, "partial", row["error"])


def test_a_run_of_a_foreign_fmu_that_fails_keeps_all_signals_too(
    tmp_path: Path, lag_dir: Path, counts: list[tuple[int, int]]
) -> None:
    words = ("--fmu-dir", lag_dir, "--set", "plant.failAt=0.25")
    told = prepared(tmp_path, write_system(tmp_path), *words)
    assert told.run_one(Job(1, {}))["verdict"] == "exit 4"
    assert counts == [(2, 0), (2, 2)]
    assert list(results.load(tmp_path / "run-0001").signals) == ["time", "scenario.u", "plant.x"]


def test_an_output_that_no_row_needs_and_is_no_number_fails_the_run(
    tmp_path: Path, own: Path, counts: list[tuple[int, int]]
) -> None:
    words = ("--fmu-dir", own, "--set", "plant.nanAt=0.3")
    row = prepared(tmp_path, write_system(tmp_path), *words).run_one(Job(1, {}))
    assert (row["verdict"], counts) == ("exit 4", [(2, 0), (2, 2)])
    assert row["error"] == "plant.x is NaN at t = 0.301 s: no finite number"
    assert len(results.load(tmp_path / "run-0001").time) == 301


@pytest.mark.parametrize(("bad", "seen"), [(0.2, 256), (0.95, 1000)])
def test_outputs_that_nobody_reads_are_looked_at_now_and_then(
    lag_dir: Path, bad: float, seen: int
) -> None:
    part = {"name": "plant", "fmu": str(lag_dir / "Lag.fmu"), "start": [["nanAt", bad]],
            "inputs": [{"name": "u", "source": "scenario.u"}]}  # fmt: skip
    plan = {"components": [part], "script": ["u"], "record": ["scenario.u"]}
    times, script = 1e-3 * np.arange(1001), np.full((1001, 1), 2.0)
    ((names, rows, error, _),) = cosim_native.run([json.dumps(plan)], times, script)
    assert (names, len(rows)) == (["scenario.u"], seen + 1)
    assert error == ("run", f"plant.x is NaN at t = {seen / 1000:g} s: no finite number")
