"""DctObserver recognises the encoder behind a speed: logged, saved, never where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from closed_loop_runs import FMUS
from fmu_instance import Instance

STEP = 1e-3
TICK = 2 * math.pi / 1024
COUNTED = "engine.speed is counted by an encoder of 1024 ticks per revolution"


@pytest.fixture
def observer():
    """An observer of an engine that idles at 90 rad/s, logged."""
    with Instance(FMUS / "DctObserver.fmu") as observer:
        observer.slave.setDebugLogging(True, ["logEvents"])
        observer.set("engine.speed", 90.0)
        observer.set("observer.method", 4)
        observer.start()
        yield observer


def follow(observer: Instance, first: int, speeds: np.ndarray) -> list[dict]:
    """Give one speed of the engine a step, from step `first` on; return the outputs."""
    rows = []
    for k, speed in enumerate(speeds, first):
        observer.set("engine.speed", float(speed))
        observer.step(k * STEP, STEP)
        rows.append(observer.outputs())
    return rows


def counted(steps: int) -> np.ndarray:
    """Return the speeds [rad/s] that an encoder gives of 90 rad/s."""
    return np.diff(np.floor(90.0 * STEP * np.arange(steps + 1) / TICK)) * TICK / STEP


def texts(observer: Instance) -> list[str]:
    return [message.message for message in observer.log]


def test_the_log_tells_which_encoder_was_recognised_and_that_it_was_none(observer):
    follow(observer, 0, counted(200))
    assert sum(COUNTED in text for text in texts(observer)) == 1
    assert any("engine.encoderTicks" in text for text in texts(observer))
    follow(observer, 200, np.array([90.123]))
    assert "not counted by an encoder of 1024 ticks after all" in texts(observer)[-1]


@pytest.mark.parametrize("at", [10, 100])
def test_what_was_recognised_is_saved_with_the_state(observer, at):
    speeds = counted(300)
    follow(observer, 0, speeds[:at])
    saved = observer.saved()
    first = follow(observer, at, speeds[at:])
    observer.restore(saved)
    assert follow(observer, at, speeds[at:]) == first


def test_it_starts_anew_with_the_run(observer):
    first = follow(observer, 0, counted(200))
    observer.slave.reset()
    observer.set("engine.speed", 90.0)
    observer.set("observer.method", 4)
    observer.start()
    assert follow(observer, 0, counted(200)) == first
    assert sum(COUNTED in text for text in texts(observer)) == 2


UNIT = {"as it is": 0.0, "in rpm": 2 * math.pi / 60, "in 4 rpm": 8 * math.pi / 60, "in rad/s": 1.0}


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("unit", UNIT)
def test_speeds_that_are_not_counted_are_taken_as_they_are(observer, seed, unit):
    """Smooth, and with the noise of a sensor that is finer than its unit."""
    random, time = np.random.default_rng(seed), STEP * np.arange(2000)
    speeds = 90.0 + 20.0 * np.sin(3.0 * time + random.random())
    speeds[1000:] += min(0.1, UNIT[unit] / 40 or 0.1) * random.standard_normal(1000)
    follow(observer, 0, np.round(speeds / UNIT[unit]) * UNIT[unit] if UNIT[unit] else speeds)
    assert not any("encoder" in text for text in texts(observer))
