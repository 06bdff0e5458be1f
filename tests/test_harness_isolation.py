"""FMUs that misbehave: each ends in a clear error and exit code, with the rows until then."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from dct_harness.fmu.isolated import Isolated, Limits
from dct_harness.fmu.remote import Remote
from harness_fixture.lag_fmu import run, write_system

(CRASH, HANG, EXIT, FORK, FLOOD, CHDIR, PRINT, MEMORY, DAEMON, ABORT, GARBAGE, CLOSE, IGNORE_TERM,
 HANG_AT_END, REFUSE) = range(1, 16)  # fmt: skip
AT = "plant: fmi2DoStep at t = 0.1 s"
ENDS = 60.0  # s after which a process that was told to end has ended, on a busy machine too


def _rows(folder: Path) -> int:
    """Return how many rows are kept; each is the lag's closed form."""
    kept = results.load(folder / "out")
    assert np.max(np.abs(kept["plant.x"] - 2 * (1 - np.exp(-kept.time)))) < 1e-12
    return len(kept.time)


@pytest.mark.parametrize(("mode", "code", "said"), [
    (CRASH, 4, f"{AT}: the FMU crashed (SIGSEGV), its process had "),
    (HANG, 5, f"{AT} did not return within 1 s (--call-timeout)"),
    (EXIT, 4, f"{AT}: the FMU ended its process (exit code 7)"),
    (FORK, 4, f"{AT}: the FMU started a process of its own"),
    (DAEMON, 4, f"{AT}: the FMU started a process of its own"),
    (MEMORY, 4, f"{AT}: the FMU crashed (SIGABRT), its process had "),
    (ABORT, 4, "it printed: assertion failed: gear > 0"),
    (CLOSE, 4, f"{AT}: the FMU crashed (SIGKILL)"),
    (IGNORE_TERM, 5, "did not return within 1 s"),
])  # fmt: skip
def test_misbehaviour_ends_the_run_and_keeps_the_rows(
    tmp_path: Path, hostile: Path, mode: int, code: int, said: str
) -> None:
    limits = (*(("--call-timeout", "1") if code == 5 else ()), "--memory", "512")
    done = run(write_system(tmp_path), hostile, "--set", f"plant.mode={mode}", *limits)
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert _rows(tmp_path) == 101
    assert not _left(tmp_path)


@pytest.mark.parametrize("engine", ["fmpy", "native"])
@pytest.mark.parametrize(("options", "said"), [
    ((), f"{AT} returned fmi2Error; its log is off: --fmu-log lets it say why"),
    (("--fmu-log",), "\n  logStatusError: no gear 9\n"),
])  # fmt: skip
def test_an_fmu_of_others_says_why_it_refuses_when_it_is_asked_to(
    tmp_path: Path, hostile: Path, engine: str, options: tuple[str, ...], said: str
) -> None:
    """Also after a flood of 20,000 messages of what it does."""
    words = ("--set", f"plant.mode={REFUSE}", "--engine", engine, *options)
    done = run(write_system(tmp_path), hostile, *words)
    assert done.returncode == 4
    assert said in done.stderr
    assert len(results.load(tmp_path / "out").run["log"]) <= 1002


def _left(folder: Path) -> list[str]:
    """Return the processes that still have a library loaded that a run unpacked, and keep it."""
    until = time.monotonic() + ENDS
    while (found := _loaded(folder / "tmp")) and time.monotonic() < until:
        time.sleep(0.01)
    return found


def _loaded(folder: Path) -> list[str]:
    """Return the processes with a file of a folder in their memory, be the file gone or not."""
    found = []
    for maps in Path("/proc").glob("[0-9]*/maps"):
        try:
            if f"{folder}/" in maps.read_text():
                found.append(maps.parent.name)
        except OSError:
            continue
    return found


KEEPS = "import ctypes, sys; ctypes.CDLL(sys.argv[1]); print(flush=True); sys.stdin.read()"


def test_a_process_that_keeps_a_library_is_seen_also_when_its_file_is_gone(
    tmp_path: Path, lag_library: Path
) -> None:
    (tmp_path / "tmp").mkdir()
    library = shutil.copy(lag_library, tmp_path / "tmp")
    with subprocess.Popen([sys.executable, "-c", KEEPS, library], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE) as process:  # fmt: skip
        process.stdout.readline()
        Path(library).unlink()
        assert _loaded(tmp_path / "tmp") == [str(process.pid)]
        assert _loaded(tmp_path / "other") == []
    assert not _left(tmp_path)


@pytest.mark.parametrize(("mode", "said"), [
    (FLOOD, "floods its log: further messages are dropped"),
    (CHDIR, "changed its working directory: /"),
])  # fmt: skip
def test_a_nuisance_is_noted_and_the_run_goes_on(
    tmp_path: Path, hostile: Path, mode: int, said: str
) -> None:
    done = run(write_system(tmp_path, "0.15"), hostile, "--set", f"plant.mode={mode}")
    assert done.returncode == 0, done.stderr
    log = results.load(tmp_path / "out").run["log"]
    assert [m["message"] for m in log if m["category"] == "harness"] == [said]
    assert len(log) <= 1001
    assert _rows(tmp_path) == 151


def test_what_an_fmu_prints_stays_out_of_our_output(tmp_path: Path, hostile: Path) -> None:
    options = ("--set", f"plant.mode={PRINT}", "--quiet")
    done = run(write_system(tmp_path, "0.11"), hostile, *options)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert _rows(tmp_path) == 111


def test_junk_in_our_pipe_is_an_error_and_not_a_hang(tmp_path: Path, hostile: Path) -> None:
    done = run(write_system(tmp_path), hostile, "--set", f"plant.mode={GARBAGE}")
    assert done.returncode == 4, done.stderr
    assert "plant: " in done.stderr
    assert "Traceback" not in done.stderr


def test_an_fmu_that_does_not_terminate_does_not_keep_the_result(
    tmp_path: Path, hostile: Path
) -> None:
    options = ("--set", f"plant.mode={HANG_AT_END}", "--call-timeout", "1")
    done = run(write_system(tmp_path, "0.2"), hostile, *options)
    assert done.returncode == 0, done.stderr
    assert _rows(tmp_path) == 201
    assert not _left(tmp_path)


@pytest.mark.parametrize(("option", "value"), [("--call-timeout", "0"), ("--memory", "-1")])
def test_a_limit_that_is_none_is_refused(
    tmp_path: Path, hostile: Path, option: str, value: str
) -> None:
    done = run(write_system(tmp_path), hostile, f"{option}={value}")
    assert done.returncode == 2
    assert "greater than 0" in done.stderr


def test_limits_beyond_all_measure_are_none(tmp_path: Path, hostile: Path) -> None:
    done = run(write_system(tmp_path), hostile, "--call-timeout", "1e300", "--memory", "1e300")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("isolate", ["none", "foreign"])
def test_the_other_process_gives_the_same_bits(tmp_path: Path, hostile: Path, isolate: str) -> None:
    done = run(write_system(tmp_path), hostile, "--isolate", isolate)
    assert done.returncode == 0, done.stderr
    record = results.load(tmp_path / "out").run["parameters"]["plant"]
    assert {n: p["value"] for n, p in record.items()} == {
        "tau": 1.0, "failAt": 1e9, "nanAt": 1e9, "delay": 0.0, "mode": 0,
    }  # fmt: skip
    assert _rows(tmp_path) == 1001


def test_a_step_asks_the_other_process_once(hostile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With inputs and outputs; what that takes is measured by `cargo xtask bench`."""
    asked: list[bytes] = []
    send = Remote.send

    def counted(remote: Remote, letter: bytes, doing: str) -> int:
        asked.append(letter)
        return send(remote, letter, doing)

    monkeypatch.setattr(Remote, "send", counted)
    fmu = Isolated("plant", hostile / "Lag.fmu", Limits())
    try:
        fmu.initialize(1.0, {})
        inputs, outputs = np.ones(len(fmu.inputs)), np.zeros(len(fmu.outputs))
        fmu.bind(inputs, outputs)
        fmu.exit_initialization()
        asked.clear()
        monkeypatch.delattr(Remote, "ask")  # the long way, in JSON
        for k in range(5):
            fmu.step(k * 1e-3, 1e-3)
        assert len(asked) == 5, asked
        assert outputs[0] != 0
    finally:
        monkeypatch.undo()
        fmu.close()
