"""How late an estimate is, and how long it takes to settle after an event."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from ..results import Results
from . import registry
from .estimation import MAP, TORQUES, estimates
from .estimation import reads as torques_of
from .filters import power_of_two
from .rows import Row, rms
from .scopes import (
    CLUTCHES,
    SCENARIO,
    STATES,
    Phase,
    Samples,
    before,
    clutch_state,
    masks,
    states,
)

PIECE = 1024  # samples at least of which a spectrum is made
ROUNDING = 64.0  # eps log2(n) times this is far above what a spectrum of n samples errs by


def reads(known: Collection[str]) -> Iterator[str]:
    """Yield which of the known signals `rows` may read."""
    yield from torques_of(known)
    yield from states(known)


def rows(results: Results, phases: list[Phase] | None) -> Iterator[Row]:
    """Yield latency per scope and settling time per event of every torque the observer tells."""
    moments = events(results)
    observers = {e: p for e, p in estimates(results).items() if e != MAP}
    for torque in TORQUES:
        if f"plant.{torque}" not in results:
            continue
        truth = Truth(results[f"plant.{torque}"])
        scopes = masks(results, torque, phases)
        for name, prefix in observers.items():
            if prefix + torque in results:
                told = Told(torque, name, results[prefix + torque])
                yield from _latencies(results.step, truth, told, scopes)
                yield from _settling(results.time, truth, told, moments)


class Truth:
    """A torque as it is: `values` of shape (n,), and their root mean square."""

    def __init__(self, values: np.ndarray) -> None:
        self.values, self.rms = values, rms(values)


@dataclass(frozen=True)
class Told:
    """What an observer says of a torque, shape (n,)."""

    torque: str
    by: str
    values: np.ndarray


def _latencies(step: float, truth: Truth, told: Told, scopes: dict[str, Samples]) -> Iterator[Row]:
    for scope, mask in scopes.items():
        late = latency(truth, told.values, mask, step)
        yield Row(registry.LATENCY, told.torque, scope, late, told.by)


def latency(truth: Truth, estimate: np.ndarray, mask: Samples, step: float) -> float | None:
    """Return the shift [s] that makes the estimate fit best; None where nothing can be told.

    The mean square of T̂(t + τ) − T(t) is taken at every whole step and its minimum refined by a
    parabola. It is undefined where T is nearly constant, or the minimum is at the longest shift.
    """
    values = truth.values
    if len(values) < 3 or not np.std(values[mask]) > registry.LATENCY_VARIES * truth.rms:
        return None
    longest = round(registry.LATENCY_LONGEST / step)
    index = before(mask, len(values) - longest)
    there = values[index]
    if not len(there):
        return None

    def cost(shift: int) -> float:
        return float(np.mean(np.square(estimate[shift:][index] - there)))

    near = nearest(values, estimate, index, longest)
    best = int(near[np.argmin([cost(k) for k in near.tolist()])])
    if best == longest:
        return None
    return step * (best + _vertex(*map(cost, range(best - 1, best + 2)))) if best else 0.0


def nearest(truth: np.ndarray, estimate: np.ndarray, index: Samples, longest: int) -> np.ndarray:
    """Return the shifts τ up to `longest` among which the one of least cost must be, in order.

    The cost is Σ (T̂(k + τ) − T(k))² = Σ T̂² − 2 Σ T̂ T + Σ T², sums over the samples k of `index`.
    Σ T̂ T follows for all shifts at once by spectra, Σ T̂² from one shift to the next by what enters
    and leaves. Rounding moves no cost by more than `doubt`, so no shift whose cost lies more than
    twice that above the least is it.
    """
    weighted, squares = np.zeros(len(truth)), np.square(estimate)
    weighted[index] = truth[index]
    change, stretches = np.zeros(longest), _stretches(index)
    for start, end in stretches:
        change += squares[end : end + longest] - squares[start : start + longest]
    costs = np.concatenate([[0.0], np.cumsum(change)]) - 2.0 * _products(
        weighted, estimate, longest
    )
    size = _norm(weighted) * (2.0 * _norm(estimate) + _norm(weighted))
    added = (longest + len(stretches)) * float(np.sum(squares))
    doubt = np.finfo(float).eps * (ROUNDING * len(truth).bit_length() * size + 2.0 * added)
    return np.flatnonzero(~(costs > costs.min() + 2 * doubt))


def _products(weights: np.ndarray, values: np.ndarray, longest: int) -> np.ndarray:
    """Return Σ weights(k) values(k + τ) for τ up to `longest`, shape (longest + 1,).

    By spectra of pieces, each with the values that a shift may bring beside it: together they take
    two thirds of the time of a spectrum of all.
    """
    size = power_of_two(max(PIECE, 8 * longest))
    fresh = size - longest
    count = -(-len(weights) // fresh)
    pieces, beside = np.zeros(count * fresh), np.zeros(count * fresh + longest)
    pieces[: len(weights)], beside[: len(values)] = weights, values
    moved = np.lib.stride_tricks.sliding_window_view(beside, size)[::fresh]
    spectra = np.conj(np.fft.rfft(pieces.reshape(count, fresh), size)) * np.fft.rfft(moved)
    found: np.ndarray = np.fft.irfft(spectra.sum(axis=0), size)[: longest + 1]
    return found


def _stretches(index: Samples) -> list[tuple[int, int]]:
    """Return the first sample of each stretch without a gap, and the one after its last."""
    if isinstance(index, slice):
        return [(index.start, index.stop)]
    parts = np.split(index, np.flatnonzero(np.diff(index) > 1) + 1)
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _norm(values: np.ndarray) -> float:
    """Return the Euclidean norm without BLAS, whose threads would wait for each other."""
    return float(np.sqrt(np.sum(np.square(values))))


def _vertex(left: float, middle: float, right: float) -> float:
    """Return where the parabola through three equidistant points has its minimum."""
    bend = left - 2 * middle + right
    return 0.5 * (left - right) / bend if bend > 0 else 0.0


def events(results: Results) -> list[tuple[int, str]]:
    """Return sample and name of each change of a clutch state, in order."""
    found = []
    for clutch in CLUTCHES:
        state = clutch_state(results, clutch)
        if state is not None:
            changes = np.flatnonzero(np.diff(state)) + 1
            found += [(int(k), f"{clutch} {STATES.get(int(state[k]), '?')}") for k in changes]
    return sorted(found)


def _settling(
    time: np.ndarray, truth: Truth, told: Told, moments: list[tuple[int, str]]
) -> Iterator[Row]:
    """Yield the settling time after each event, and the longest of them."""
    settled = Settled(time, np.abs(told.values - truth.values) <= registry.SETTLED * truth.rms)
    found: list[float | None] = []
    for count, (k, name) in enumerate(moments, 1):
        if time[-1] - time[k] >= registry.DWELL:
            found.append(settled.after(k))
            scope = f"event/{count} {name}"
            yield Row(registry.SETTLING, told.torque, scope, found[-1], told.by)
    if found:
        known = [value for value in found if value is not None]
        longest = max(known) if len(known) == len(found) else None
        yield Row(registry.SETTLING, told.torque, SCENARIO, longest, told.by)


class Settled:
    """When an estimate is near the truth and stays so for the dwell time."""

    def __init__(self, time: np.ndarray, inside: np.ndarray) -> None:
        """`inside`: whether it is near, shape (n,)."""
        self._time = time
        leaves = np.concatenate([np.flatnonzero(~inside), [len(time)]])
        starts = np.concatenate([[0], leaves[:-1] + 1])
        there = leaves > starts
        self._starts, self._lasts = starts[there], leaves[there] - 1  # of stretches inside
        long = time[self._lasts] - time[self._starts] >= registry.DWELL
        self._long = self._starts[long]

    def after(self, k: int) -> float | None:
        """Return the time [s] from sample `k` until it first holds; None if it never does."""
        part = int(np.searchsorted(self._lasts, k))
        around = part < len(self._lasts) and self._starts[part] <= k
        if around and self._time[self._lasts[part]] - self._time[k] >= registry.DWELL:
            return 0.0
        later = int(np.searchsorted(self._long, k))
        if later == len(self._long):
            return None
        return float(self._time[self._long[later]] - self._time[k])
