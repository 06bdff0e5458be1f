"""Results as CSV, Parquet and MF4: exact, with units, whole or not there; JUnit XML."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import asammdf
import numpy as np
import pytest
from dct_harness import formats, results
from dct_harness.errors import ConfigError
from dct_harness.verbs import junit
from harness_fixture.lag_fmu import (
    LAG,
    environment,
    harness,
    run,
    run_command,
    write_fmu,
    write_system,
)
from pyarrow import parquet

SUFFIXES = tuple(formats.SUFFIXES)
EXTREMES = (0.1, -0.0, 5e-324, 1.7976931348623157e308, 1 / 3, -1e-17)
UNITS = {"time": "s", "plant.clutch1.torque": "N.m", "observer.clutch1.muF": "N/m"}
MANY_STEPS = "200.0"  # s of simulated time; several seconds of work


def table() -> formats.Table:
    """Return six rows with the ends of double precision."""
    values = np.array(EXTREMES)
    rows = np.column_stack([np.arange(6) * 0.001, values, values[::-1], np.ones(6)])
    return formats.Table([*UNITS, "plant.gain[1,2]"], rows, UNITS)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_reads_back_exactly_and_keeps_units(tmp_path: Path, suffix: str) -> None:
    written, path = table(), tmp_path / f"t{suffix}"
    formats.write(path, written)
    back = formats.read(path)
    assert back.names == written.names
    assert back.rows.tobytes() == written.rows.tobytes()
    assert back.units == ({} if suffix == ".csv" else UNITS)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])  # MF4 records when it was written
def test_the_same_table_gives_the_same_bytes(tmp_path: Path, suffix: str) -> None:
    for name in "ab":
        formats.write(tmp_path / f"{name}{suffix}", table())
    a, b = (tmp_path / f"{name}{suffix}" for name in "ab")
    assert a.read_bytes() == b.read_bytes()


def test_other_readers_find_the_units(tmp_path: Path) -> None:
    for suffix in (".parquet", ".mf4"):
        formats.write(tmp_path / f"t{suffix}", table())
    field = parquet.read_schema(tmp_path / "t.parquet").field("plant.clutch1.torque")
    assert (str(field.type), field.metadata[b"unit"]) == ("double", b"N.m")
    with asammdf.MDF(tmp_path / "t.mf4") as mdf:
        channel = mdf.get("plant.clutch1.torque")
    assert (channel.unit, channel.samples.tolist()) == ("N.m", list(EXTREMES))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_write_that_breaks_leaves_the_file_before(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t{suffix}"
    formats.write(path, table())
    before = path.read_bytes()
    broken = formats.Table(["time", "a"], np.array([["no", "number"]]))
    with pytest.raises((ValueError, TypeError, AttributeError, RuntimeError)):
        formats.write(path, formats.Table([*broken.names, "b", "\ud800"], broken.rows))
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize(("suffix", "package"), [(".parquet", "pyarrow"), (".mf4", "asammdf")])
def test_missing_package_is_told_before_the_run(
    monkeypatch: pytest.MonkeyPatch, suffix: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ConfigError, match=rf"pip install dct-harness\[{suffix[1:]}\]"):
        formats.require(Path(f"results{suffix}"))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_damaged_file_is_a_sentence(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"t{suffix}"
    path.write_bytes(b"time,a\n0,1\n1,")
    with pytest.raises(ConfigError, match=path.name):
        formats.read(path)


def test_unknown_suffix_is_told_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match=r"Did you mean '.parquet'"):
        formats.require(Path("x.parket"))


def with_units(folder: Path, library: Path) -> Path:
    """Write the lag with an input and an output in newton metres into a folder of its own."""
    (folder / "fmus").mkdir()
    real = '<Real unit="N.m"'
    told = tuple(v.replace("<Real", real, 1) if k < 2 else v for k, v in enumerate(LAG))
    write_fmu(folder / "fmus/Lag.fmu", library, told)
    return folder / "fmus"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_run_has_units_in_every_format(tmp_path: Path, lag_library: Path, suffix: str) -> None:
    fmus, system = with_units(tmp_path, lag_library), write_system(tmp_path)
    assert run(system, fmus, "-q").returncode == 0
    done = run(system, fmus, "-q", "--format", suffix[1:])
    assert (done.returncode, done.stderr) == (0, "")
    out = tmp_path / "out"
    assert [p.name for p in out.glob("results.*")] == [f"results{suffix}"]
    loaded = results.load(out)
    told = results.units(loaded.run)
    assert told == {"time": "s", "scenario.u": "N.m", "plant.x": "N.m"}
    assert loaded["plant.x"][-1] == pytest.approx(2 * (1 - np.exp(-1)), rel=1e-3)
    if suffix != ".csv":
        assert formats.read(out / f"results{suffix}").units == told


def test_two_results_in_a_directory_are_refused(tmp_path: Path) -> None:
    for suffix in (".csv", ".parquet"):
        formats.write(tmp_path / f"results{suffix}", table())
    with pytest.raises(ConfigError, match=r"results\.csv, results\.parquet; keep the one"):
        results.load(tmp_path)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_its_rows_and_reports(
    lag_dir: Path, tmp_path: Path, number: int
) -> None:
    system, out = write_system(tmp_path, stop=MANY_STEPS), tmp_path / "out"
    command = run_command(system, lag_dir, "--format", "parquet", "--report")
    with subprocess.Popen(command, env=environment(tmp_path), stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as process:  # fmt: skip
        process.stderr.readline()  # a tenth is done
        process.send_signal(number)
        said, complained = process.communicate()
    assert process.returncode == 130, complained
    loaded = results.load(out)
    assert loaded.run["status"] == "partial"
    assert 20_000 <= len(loaded.time) == loaded.run["samples"] < 200_001
    assert "Partial run" in (out / "report/index.html").read_text(encoding="utf-8")
    assert f"report: {out / 'report/index.html'}\n" in said
    assert list((tmp_path / "tmp").iterdir()) == []


def test_limits_become_junit_cases(lag_dir: Path, tmp_path: Path) -> None:
    system, file = write_system(tmp_path), tmp_path / "ci/limits.xml"
    limit = 'kpi = "shift.jerkPeak"\nsignal = "vehicle.acceleration"\nmax = 10\n'
    system.write_text(system.read_text() + f"[[kpis]]\n{limit}")
    assert run(system, lag_dir, "-q", "--junit", file).returncode == 1
    suite = ElementTree.parse(file).getroot()[0]
    assert (suite.get("name"), suite.get("tests"), suite.get("failures")) == ("lag", "2", "1")
    assert [len(case) for case in suite] == [0, 1]
    assert suite[1][0].get("message").endswith("limit <= 10 m/s³")


def told(file: Path) -> tuple[str | None, str | None, str | None, list[tuple[str, str | None]]]:
    """Return counts of tests, failures and errors, and what is said of the cases."""
    root = ElementTree.parse(file).getroot()
    said = [(e.tag, e.get("message")) for case in root[0] for e in case]
    return root.get("tests"), root.get("failures"), root.get("errors"), said


def test_a_run_that_fails_is_an_error_of_junit_and_no_missed_limit(
    lag_dir: Path, tmp_path: Path
) -> None:
    file = tmp_path / "x.xml"
    done = run(write_system(tmp_path), lag_dir, "-q", "--set", "plant.failAt=0.5", "--junit", file)
    assert done.returncode == 4
    record = json.loads((tmp_path / "out/run.json").read_text())
    assert told(file) == ("1", "0", "1", [("error", record["error"])])


@pytest.mark.parametrize("words", [
    ("run", "s.toml"), ("sweep", "s.toml", "--vary", "plant.tau=uniform(1,2)"),
    ("compare", "one.csv", "other.csv"),
])  # fmt: skip
def test_what_prevents_a_check_replaces_the_junit_file_of_an_earlier_job(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    file = tmp_path / "x.xml"
    junit.write(file, "earlier", [junit.Case("limits", "kept")])
    done = harness(*words, "--junit", file, folder=tmp_path)
    assert done.returncode == 2
    (tests, failures, errors, [(kind, message)]) = told(file)
    assert (tests, failures, errors, kind) == ("1", "0", "1", "error")
    assert done.stderr == f"dct-harness: {message}\n"


def test_runs_of_a_sweep_become_junit_cases(lag_dir: Path, tmp_path: Path) -> None:
    system, file = write_system(tmp_path), tmp_path / "x.xml"
    limit = 'kpi = "shift.jerkPeak"\nsignal = "vehicle.acceleration"\nmax = 10\n'
    system.write_text(system.read_text() + f"[[kpis]]\n{limit}")
    vary = ("--sampling", "grid", "--vary", "plant.failAt=choice(0.5,2.0)")
    done = harness("sweep", system, "--fmu-dir", lag_dir, "--out", tmp_path / "out", *vary,
                   "--junit", file, folder=tmp_path)  # fmt: skip
    assert done.returncode == 1, done.stderr
    tests, failures, errors, said = told(file)
    assert (tests, failures, errors) == ("2", "1", "1")
    kinds, messages = zip(*said, strict=True)
    assert kinds == ("error", "failure")
    names = [case.get("name") for case in ElementTree.parse(file).getroot()[0]]
    assert names == [f"run {k}: plant.failAt = {x:g}" for k, x in ((1, 0.5), (2, 2.0))]
    assert messages[0].startswith("plant: fmi2DoStep at t = 0.5")
    assert messages[1].startswith(f"misses a limit: dct-harness run {system}")


def test_junit_takes_any_text(tmp_path: Path) -> None:
    junit.write(tmp_path / "x.xml", "<a>\x00", [junit.Case("g", 'n"', "\x1b[31m & <b>")])
    suite = ElementTree.parse(tmp_path / "x.xml").getroot()[0]
    assert (suite.get("name"), suite[0][0].text) == ("<a>?", "?[31m & <b>")


def test_format_that_is_none_exits_2(tmp_path: Path) -> None:
    done = harness("run", "x.toml", "--format", "xls", folder=tmp_path)
    assert done.returncode == 2
