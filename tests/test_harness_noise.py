"""[noise] of a system file: what others read of an output, while the output stays true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import run, write_system

DEVIATION = 0.5
FOUR_SIGMA = 4.0  # of the sampling error, and the seed is fixed
FOLLOWER = f"""[components.follower]
fmu = "Lag.fmu"
[[connections]]
from = "plant.x"
to = "follower.u"
factor = 2.0
[noise]
seed = 3
"plant.x" = {DEVIATION}
"""


def write(folder: Path, text: str = FOLLOWER) -> Path:
    """Write a lag, and one that follows twice the noisy output of the first."""
    system = write_system(folder)
    system.write_text(system.read_text() + text)
    return system


def signals(system: Path, fmus: Path, *options: str) -> results.Results:
    """Return what a run has recorded."""
    done = run(system, fmus, *options)
    assert done.returncode == 0, done.stderr
    return results.load(system.parent / "out")


def test_noise_is_white_and_the_output_stays_true(lag_dir: Path, tmp_path: Path) -> None:
    system = write(tmp_path)
    found = signals(system, lag_dir)
    clean = signals(system, lag_dir, "--set", "noise.plant.x=0")
    noise = found["scenario.noise.plant.x"]
    assert np.array_equal(found["plant.x"], clean["plant.x"])
    assert "scenario.noise.plant.x" not in clean
    near = FOUR_SIGMA * DEVIATION / len(noise) ** 0.5
    assert noise.mean() == pytest.approx(0, abs=near)
    assert noise.std() == pytest.approx(DEVIATION, rel=0.1)
    assert abs((noise[1:] * noise[:-1]).mean()) < near * DEVIATION


def test_a_reader_gets_the_value_with_its_noise_converted(lag_dir: Path, tmp_path: Path) -> None:
    """A lag of 1 s steps exactly: x' = u - x with u held, so x[k+1] tells u[k]."""
    found = signals(write(tmp_path), lag_dir)
    x, y, noise = (found[n] for n in ("plant.x", "follower.x", "scenario.noise.plant.x"))
    told = (y[1:] - y[:-1] * np.exp(-0.001)) / (1 - np.exp(-0.001))
    assert told == pytest.approx(2 * (x[1:] + noise[:-1]), abs=1e-6)


def test_a_seed_repeats_its_noise_for_both_engines(lag_dir: Path, tmp_path: Path) -> None:
    system = write(tmp_path)
    first, again, native = (signals(system, lag_dir, *more)["follower.x"] for more in
                            ((), (), ("--engine", "native")))  # fmt: skip
    other = signals(system, lag_dir, "--set", "noise.seed=4")["follower.x"]
    assert np.array_equal(first, again)
    assert np.array_equal(first, native)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize(("old", "new", "said"), [
    ('"plant.x" = ', '"plant.y" = ', "s.toml:16:1: noise: 'plant.y' is no real output. Did you"),
    ('"plant.x" = 0.5', '"plant.x" = -1', "-1 is less than the minimum of 0. It is: standard"),
    ("seed = 3", "sead = 3", "s.toml:15:1: noise: 'sead' does not match"),
])  # fmt: skip
def test_noise_that_cannot_be_is_refused(
    lag_dir: Path, tmp_path: Path, old: str, new: str, said: str
) -> None:
    assert old in FOLLOWER
    done = run(write(tmp_path, FOLLOWER.replace(old, new)), lag_dir)
    assert done.returncode == 2
    assert said in done.stderr


@pytest.mark.parametrize(("value", "said"), [
    ("noise.seed=0.5", "seed is a whole number of at least 0"),
    ("noise.plant.x=-1", "plant.x is a standard deviation of at least 0"),
])  # fmt: skip
def test_noise_of_the_command_line_is_checked(
    lag_dir: Path, tmp_path: Path, value: str, said: str
) -> None:
    done = run(write(tmp_path), lag_dir, "--set", value)
    assert done.returncode == 2
    assert said in done.stderr
