"""What happens within a shift: torque and inertia phase, torque hole, engine flare."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from ..results import Results
from . import registry
from .filters import low_pass
from .rows import Row
from .scopes import CLUTCHES, Phase, clutch_state, states

BEGUN, DONE = 0.05, 0.95  # of the way between the two synchronous speeds
SHAFT = "plant.driveShaft.torque"


@dataclass(frozen=True)
class Shift:
    """Samples from the last drive on one clutch to the first on the other."""

    first: int
    last: int
    off: str
    on: str

    @property
    def label(self) -> str:
        """Which clutch gives to which."""
        return f"{self.off} → {self.on}"

    @property
    def samples(self) -> slice:
        """All samples of the shift, both ends in."""
        return slice(self.first, self.last + 1)


def shifts(results: Results) -> list[Shift]:
    """Return every change of the clutch that drives, one being engaged and the other open."""
    states = [clutch_state(results, clutch) for clutch in CLUTCHES]
    if any(state is None for state in states):
        return []
    first, second = states
    driving = np.where((first == 3) & (second == 1), 1, 0)
    driving = np.where((second == 3) & (first == 1), 2, driving)
    steady = np.flatnonzero(driving)
    change = np.flatnonzero(np.diff(driving[steady]))
    return [
        Shift(int(steady[k]), int(steady[k + 1]), CLUTCHES[driving[steady[k]] - 1],
              CLUTCHES[driving[steady[k + 1]] - 1])
        for k in change
    ]  # fmt: skip


def reads(known: Collection[str]) -> Iterator[str]:
    """Yield which of the known signals `rows` may read."""
    yield from states(known)
    yield from (name for name in (SHAFT, *_slips(CLUTCHES), *_speeds()) if name in known)


def _slips(clutches: tuple[str, ...]) -> list[str]:
    return [f"plant.{clutch}.slip" for clutch in clutches]


def _speeds() -> list[str]:
    """Return the names of the engine's speed and of both synchronous ones."""
    return ["plant.engine.speed", *(f"plant.{clutch}.speed" for clutch in CLUTCHES)]


def rows(results: Results, phases: list[Phase] | None) -> Iterator[Row]:
    """Yield the KPIs of every shift; phases of the scenario play no part."""
    del phases
    for count, shift in enumerate(shifts(results), 1):
        scope = f"shift {count}"
        duration = float(results.time[shift.last] - results.time[shift.first])
        yield Row(registry.SHIFT_DURATION, shift.label, scope, duration)
        inertia = inertia_phase(results, shift)
        if inertia is not None:
            yield Row(registry.TORQUE_PHASE, shift.label, scope, duration - inertia)
            yield Row(registry.INERTIA_PHASE, shift.label, scope, inertia)
        hole = torque_hole(results, shift)
        if hole is not None:
            yield Row(registry.TORQUE_HOLE, shift.label, scope, hole)
        flare = engine_flare(results, shift)
        if flare is not None:
            yield Row(registry.FLARE, shift.label, scope, flare)


def inertia_phase(results: Results, shift: Shift) -> float | None:
    """Return how long the engine side is between the two synchronous speeds [s].

    Its way is slip_off / (slip_off − slip_on): 0 on the off-going, 1 on the on-coming gear.
    """
    names = _slips((shift.off, shift.on))
    if any(name not in results for name in names):
        return None
    off, on = (results[name][shift.samples] for name in names)
    apart = off - on
    way = np.divide(off, apart, out=np.zeros_like(off), where=apart != 0)
    arrived = np.flatnonzero(way >= DONE)
    end = int(arrived[0]) if len(arrived) else len(way) - 1
    waiting = np.flatnonzero(way[: end + 1] <= BEGUN)
    start = int(waiting[-1]) if len(waiting) else 0
    time = results.time[shift.samples]
    return float(time[end] - time[start])


def torque_hole(results: Results, shift: Shift) -> float | None:
    """Return how far the drive-shaft torque falls short of the line from before to after [N·m]."""
    if SHAFT not in results:
        return None
    torque = low_pass(results[SHAFT], results.step, registry.JERK_CUTOFF)[shift.samples]
    time = results.time[shift.samples]
    line = np.interp(time, time[[0, -1]], torque[[0, -1]])
    sense = 1.0 if line.mean() >= 0 else -1.0
    return float(np.max(sense * (line - torque)))


def engine_flare(results: Results, shift: Shift) -> float | None:
    """Return how far the engine runs above both synchronous speeds [rad/s]."""
    names = _speeds()
    if any(name not in results for name in names):
        return None
    engine, *synchronous = (results[name][shift.samples] for name in names)
    return max(0.0, float(np.max(engine - np.maximum(*synchronous))))
