"""What a step of an FMU costs more in a process of its own, measured against a direct call."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from dct_harness.fmu import Fmu
from dct_harness.isolated import Isolated, Limits

BLOCKS, COUNT = 400, 5  # blocks of steps; the best of each is one that nobody disturbed
DEARER = 40e-6  # s per step


def _started(fmu: Fmu) -> Fmu:
    fmu.initialize(1e3, {})
    inputs = np.array([float(v.start or 0) for v in fmu.inputs])
    fmu.bind(inputs, np.zeros(len(fmu.outputs)))
    fmu.exit_initialization()
    return fmu


def _block(fmu: Fmu, first: int) -> float:
    """Return the time of a step [s], averaged over a block."""
    started = time.perf_counter()
    for k in range(first, first + COUNT):
        fmu.step(k * 1e-3, 1e-3)
    return (time.perf_counter() - started) / COUNT


def extra(path: Path) -> float:
    """Return isolated minus direct [s per step], from blocks of both in turn."""
    made: list[Fmu] = []
    try:
        made += [_started(Fmu("plant", path))]
        made += [_started(Isolated("plant", path, Limits()))]
        times = [[_block(fmu, k * COUNT) for fmu in made] for k in range(BLOCKS)]
    finally:
        for fmu in made:
            fmu.close()
    direct, isolated = np.min(times, axis=0)
    return float(isolated - direct)
