"""The harness on a C fixture FMU: closed form, short last step, failures, what ends a run."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import termios
from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from dct_harness.errors import instant
from dct_harness.master import wiring
from harness_fixture.lag_fmu import (
    LIMIT,
    environment,
    run,
    run_command,
    run_out_of_time,
    write_system,
)

ROUNDING = 1e-12  # a thousand exact steps, each rounded once
NATIVE = ("--engine", "native")  # the lag runs in a process of its own
engines = pytest.mark.parametrize("engine", [(), NATIVE, (*NATIVE, "--isolate", "none")])


def exact(time: np.ndarray) -> np.ndarray:
    """Return the answer of the lag to u = 2, shape of `time` [s]."""
    return 2 * (1 - np.exp(-time))


@pytest.mark.parametrize(("t", "said"), [  # as src/master/error.rs has them
    (0.0, "0"), (-1e-12, "0"), (0.491, "0.491"), (9.411999999999999, "9.412"), (30.0, "30"),
    (1.5e-5, "0.000015"), (12345678.25, "12345678.25"), (1e16, "10000000000000000"),
])  # fmt: skip
def test_times_show_no_rounding_of_their_sums(t: float, said: str) -> None:
    assert instant(t) == said


@pytest.mark.parametrize(("option", "said"), [
    ("plant.failAt=0.5", "plant: fmi2DoStep at t = 0.5"), ("plant.nanAt=0.5", "plant.x is nan"),
])  # fmt: skip
def test_failure_exits_4_and_keeps_the_rows(
    lag_dir: Path, tmp_path: Path, option: str, said: str
) -> None:
    done = run(write_system(tmp_path), lag_dir, "--set", option)
    assert done.returncode == 4, done.stderr
    assert said in done.stderr
    kept = results.load(tmp_path / "out")
    assert kept.run["status"] == "partial"
    assert len(kept.time) == kept.run["samples"] == 501
    assert np.max(np.abs(kept["plant.x"] - exact(kept.time))) < ROUNDING


def test_messages_are_shown_when_the_run_fails(lag_dir: Path, tmp_path: Path) -> None:
    done = run(write_system(tmp_path), lag_dir, "-v", "--set", "plant.failAt=0.5")
    assert "0.5 s plant [logStatusError] told to\n" in done.stderr


def test_kpis_of_an_earlier_run_do_not_outlive_a_failed_one(lag_dir: Path, tmp_path: Path) -> None:
    system, kpis = write_system(tmp_path), tmp_path / "out/kpis.json"
    assert run(system, lag_dir).returncode == 0
    assert kpis.is_file()
    assert run(system, lag_dir, "--set", "plant.failAt=0.5").returncode == 4
    assert not kpis.exists()


@engines
def test_slow_run_ends_at_its_time_limit_with_code_5(
    lag_dir: Path, tmp_path: Path, engine: tuple[str, ...]
) -> None:
    options = ("--set", "plant.delay=0.1")
    done = run_out_of_time(write_system(tmp_path), lag_dir, *options, *engine)
    assert done.returncode == 5, done.stderr
    assert f"not finished after {LIMIT} s (--timeout)" in done.stderr
    kept = results.load(tmp_path / "out")
    assert 1 < len(kept.time) < 1000
    assert f"stopped at t = {instant(kept.time[-1])} s: not finished" in done.stderr
    assert np.max(np.abs(kept["plant.x"] - exact(kept.time))) < ROUNDING


@engines
def test_fmu_that_never_returns_ends_with_code_5(
    lag_dir: Path, tmp_path: Path, engine: tuple[str, ...]
) -> None:
    options = ("--set", "plant.delay=1000.0")
    done = run_out_of_time(write_system(tmp_path), lag_dir, *options, *engine)
    assert done.returncode == 5, done.stderr
    assert "an FMU does not return" in done.stderr
    kept = results.load(tmp_path / "out")
    assert (len(kept.time), kept.run["status"]) == (1, "partial")


@engines
def test_interrupt_keeps_the_rows_and_ends_without_traceback(
    lag_dir: Path, tmp_path: Path, engine: tuple[str, ...]
) -> None:
    command = run_command(write_system(tmp_path), lag_dir, "--set", "plant.delay=0.02", *engine)
    with subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, env=environment(tmp_path)
    ) as process:
        first = process.stderr.readline()
        process.send_signal(signal.SIGINT)
        rest = process.stderr.read()
    assert re.fullmatch(r" [1-9]0 %  step \d{3} of 1000, \d+ s left\n", first), first
    assert process.returncode == 130
    assert "interrupted by Ctrl-C" in rest
    assert "Traceback" not in rest
    assert list((tmp_path / "tmp").iterdir()) == []
    kept = results.load(tmp_path / "out")
    assert kept.run["status"] == "partial"
    assert "interrupted" in kept.run["error"]
    assert 100 < len(kept.time) < 1000
    assert np.max(np.abs(kept["plant.x"] - exact(kept.time))) < ROUNDING


def test_bar_on_a_terminal_is_gone_before_the_error(lag_dir: Path, tmp_path: Path) -> None:
    options = ("--set", "plant.delay=0.002", "--set", "plant.failAt=0.9")
    master_end, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    command = run_command(write_system(tmp_path), lag_dir, *options)
    with subprocess.Popen(command, stderr=terminal, env=environment(tmp_path)) as process:
        os.close(terminal)
        assert process.wait() == 4
    shown = os.read(master_end, 1 << 16).decode()
    os.close(master_end)
    assert "step/s" in shown
    assert re.search(r"\r +\rdct-harness: plant: fmi2DoStep", shown), shown


def test_last_step_is_shortened_and_times_do_not_accumulate() -> None:
    assert wiring.communication_points(0.1, 0.35).tolist() == [0.0, 0.1, 0.2, 0.1 * 3, 0.35]
    assert len(wiring.communication_points(0.001, 30.0)) == 30001
