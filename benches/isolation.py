"""What a step costs more in a process of its own, beside the least that two processes can do.

The floor is a byte to another Python process and one back: what the operating system takes to wake
one process, then the other. All share one core: on two, waking takes 5 or 30 us by chance.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from dct_harness.fmu.fmu import Fmu
from dct_harness.fmu.isolated import Isolated, Limits
from gate import Gate

STEP = 1e-3  # s
BLOCKS, COUNT = 400, 5  # blocks of steps; the best of each is one that nobody disturbed
ECHO = "import os\nwhile byte := os.read(0, 1):\n    os.write(1, byte)"

Act = Callable[[int], None]


def isolation(fmu: Path) -> list[Gate]:
    """Judge the isolated step of an FMU."""
    direct, isolated, bare = times(fmu) * 1e6
    return [
        Gate("step in a process of its own, extra", isolated - direct, 40.0, "us",
             beside=f"{isolated:.3g} - {direct:.3g} us; a byte there and back {bare:.3g} us"),
    ]  # fmt: skip


def times(fmu: Path) -> np.ndarray:
    """Return direct step, isolated step and a byte there and back [s], in turn in one run."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})  # of the processes that are started here, too
    made = [started(Fmu("plant", fmu)), started(Isolated("plant", fmu, Limits()))]
    echo = subprocess.Popen(
        [sys.executable, "-c", ECHO], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    try:
        acts = [*(step(fmu) for fmu in made), there_and_back(echo)]
        return np.min([[block(act, k * COUNT) for act in acts] for k in range(BLOCKS)], axis=0)
    finally:
        for one in made:
            one.close()
        echo.communicate()
        os.sched_setaffinity(0, cores)


def started(fmu: Fmu) -> Fmu:
    """Return the FMU, ready to step."""
    fmu.initialize(1e3, {})
    inputs = np.array([float(v.start or 0) for v in fmu.inputs])
    fmu.bind(inputs, np.zeros(len(fmu.outputs)))
    fmu.exit_initialization()
    return fmu


def step(fmu: Fmu) -> Act:
    """Return its k-th step."""
    return lambda k: fmu.step(k * STEP, STEP)


def there_and_back(echo: subprocess.Popen) -> Act:
    """Return the exchange of a byte."""
    assert echo.stdin
    assert echo.stdout
    to, back = echo.stdin.fileno(), echo.stdout.fileno()

    def exchange(_: int) -> None:
        os.write(to, b"S")
        os.read(back, 1)

    return exchange


def block(act: Act, first: int) -> float:
    """Return the time of one act [s], averaged over a block."""
    begin = time.perf_counter()
    for k in range(first, first + COUNT):
        act(k)
    return (time.perf_counter() - begin) / COUNT
