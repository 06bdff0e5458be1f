"""How late an estimate is, and how long it takes to settle after an event."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from ..results import Results
from . import registry
from .estimation import MAP, TORQUES, estimates
from .estimation import reads as torques_of
from .rows import Row, rms
from .scopes import CLUTCHES, SCENARIO, STATES, Phase, clutch_state, masks, states

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
        truth = results[f"plant.{torque}"]
        scopes = masks(results, torque, phases)
        for name, prefix in observers.items():
            if prefix + torque in results:
                told = Told(torque, name, results[prefix + torque])
                yield from _latencies(results.step, truth, told, scopes)
                yield from _settling(results.time, truth, told, moments)


@dataclass(frozen=True)
class Told:
    """What an observer says of a torque, shape (n,)."""

    torque: str
    by: str
    values: np.ndarray


def _latencies(
    step: float, truth: np.ndarray, told: Told, scopes: dict[str, np.ndarray]
) -> Iterator[Row]:
    for scope, mask in scopes.items():
        late = latency(truth, told.values, mask, step)
        yield Row(registry.LATENCY, told.torque, scope, late, told.by)


def latency(truth: np.ndarray, estimate: np.ndarray, mask: np.ndarray, step: float) -> float | None:
    """Return the shift [s] that makes the estimate fit best; None where nothing can be told.

    The mean square of T̂(t + τ) − T(t) is taken at every whole step and its minimum refined by a
    parabola. It is undefined where T is nearly constant, or the minimum is at the longest shift.
    """
    whole = rms(truth)
    if len(truth) < 3 or not np.std(truth[mask]) > registry.LATENCY_VARIES * whole:
        return None
    longest = round(registry.LATENCY_LONGEST / step)
    index = np.flatnonzero(mask)
    index = index[index < len(truth) - longest]
    if not len(index):
        return None
    there = truth[index]

    def cost(shift: int) -> float:
        return float(np.mean(np.square(estimate[index + shift] - there)))

    near = nearest(truth, estimate, index, longest)
    best = int(near[np.argmin([cost(k) for k in near.tolist()])])
    if best == longest:
        return None
    return step * (best + _vertex(*map(cost, range(best - 1, best + 2)))) if best else 0.0


def nearest(truth: np.ndarray, estimate: np.ndarray, index: np.ndarray, longest: int) -> np.ndarray:
    """Return the shifts up to `longest` among which the one of least cost must be, in order.

    By spectra all costs follow at once: Σ (T̂(k + τ) − T(k))² = Σ T̂² − 2 Σ T̂ T + Σ T², sums over
    the samples k of `index`. Rounding moves none by more than `doubt`, so no shift whose cost lies
    more than twice that above the least is it.
    """
    count = 1 << (len(truth) - 1).bit_length()
    inside = np.zeros(len(truth))
    inside[index] = 1.0
    weighted, squares = inside * truth, estimate**2
    parts = [(inside, squares), (-2.0 * weighted, estimate)]
    spectra = (np.conj(np.fft.rfft(a, count)) * np.fft.rfft(b, count) for a, b in parts)
    costs = np.fft.irfft(sum(spectra), count)[: longest + 1]
    size = sum(_norm(a) * _norm(b) for a, b in parts) + float(np.sum(weighted * truth))
    doubt = ROUNDING * np.finfo(float).eps * count.bit_length() * size
    return np.flatnonzero(~(costs > costs.min() + 2 * doubt))


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
    time: np.ndarray, truth: np.ndarray, told: Told, moments: list[tuple[int, str]]
) -> Iterator[Row]:
    """Yield the settling time after each event, and the longest of them."""
    inside = np.abs(told.values - truth) <= registry.SETTLED * rms(truth)
    found: list[float | None] = []
    for count, (k, name) in enumerate(moments, 1):
        if time[-1] - time[k] >= registry.DWELL:
            found.append(settling(time[k:], inside[k:]))
            scope = f"event/{count} {name}"
            yield Row(registry.SETTLING, told.torque, scope, found[-1], told.by)
    if found:
        known = [value for value in found if value is not None]
        longest = max(known) if len(known) == len(found) else None
        yield Row(registry.SETTLING, told.torque, SCENARIO, longest, told.by)


def settling(time: np.ndarray, inside: np.ndarray) -> float | None:
    """Return the time [s] until `inside` first holds for the dwell time; None if it never does."""
    leaves = np.concatenate([np.flatnonzero(~inside), [len(time)]])
    starts = np.concatenate([[0], leaves[:-1] + 1])
    ends = np.maximum(leaves - 1, 0)
    dwells = (leaves > starts) & (time[ends] - time[np.minimum(starts, ends)] >= registry.DWELL)
    if not dwells.any():
        return None
    return float(time[starts[np.argmax(dwells)]] - time[0])
