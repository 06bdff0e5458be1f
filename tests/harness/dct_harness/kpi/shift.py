"""Shift quality: jerk, friction energy, lock-up times, shift durations."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..results import Results
from . import registry
from .rows import Row, rms
from .scopes import CLUTCHES, Phase, clutch_state, phase_masks

FILTER_REACH = 4.0  # standard deviations of the Gaussian kept: the tail left is 6e-5


def rows(results: Results, phases: list[Phase]) -> Iterator[Row]:
    """Yield the shift-quality KPIs that the plant's outputs allow."""
    scopes = phase_masks(results.time, phases)
    filtered = jerk(results)
    if filtered is not None:
        for scope, mask in scopes.items():
            peak = float(np.abs(filtered[mask]).max())
            yield Row(registry.JERK_PEAK, "vehicle.acceleration", scope, peak)
            yield Row(registry.JERK_RMS, "vehicle.acceleration", scope, rms(filtered[mask]))
    for clutch in CLUTCHES:
        yield from _friction(results, clutch, scopes)
        yield from _lock_ups(results, clutch)
    yield from _shifts(results)


def jerk(results: Results) -> np.ndarray | None:
    """Return the filtered jerk [m/s³], shape (n,); None without acceleration or speed."""
    time = results.time
    if len(time) < 3:
        return None
    if "plant.vehicle.acceleration" in results:
        acceleration = results["plant.vehicle.acceleration"]
    elif "plant.vehicle.speed" in results:
        acceleration = np.gradient(results["plant.vehicle.speed"], time)
    else:
        return None
    step = float(np.median(np.diff(time)))
    return np.gradient(low_pass(acceleration, step, registry.JERK_CUTOFF), time)


def low_pass(values: np.ndarray, step: float, cutoff: float) -> np.ndarray:
    """Filter with a zero-phase Gaussian, −3 dB at `cutoff` [Hz]; `step` [s]; ends held.

    |H(f)| = exp(−(2π f σ)² / 2) with σ = sqrt(ln 2) / (2π cutoff).
    """
    sigma = math.sqrt(math.log(2)) / (2 * math.pi * cutoff) / step
    reach = min(math.ceil(FILTER_REACH * sigma), len(values))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    padded = np.pad(values, reach, mode="edge")
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def friction_power(results: Results, clutch: str) -> np.ndarray | None:
    """Return the friction power of a clutch [W], shape (n,), or None if it cannot be known."""
    direct, torque, slip = (
        f"plant.{clutch}.{name}" for name in ("frictionPower", "torque", "slip")
    )
    if direct in results:
        return results[direct]
    if torque in results and slip in results:
        return results[torque] * results[slip]
    speeds = ("plant.damper.speed", f"plant.{clutch}.speed")
    if torque in results and all(name in results for name in speeds):
        return results[torque] * (results[speeds[0]] - results[speeds[1]])
    return None


def _friction(results: Results, clutch: str, scopes: dict[str, np.ndarray]) -> Iterator[Row]:
    power = friction_power(results, clutch)
    if power is None or len(power) < 2:
        return
    total = f"plant.{clutch}.frictionEnergy"
    pieces = np.diff(results.time) * (power[1:] + power[:-1]) / 2
    energy = results[total] if total in results else np.concatenate([[0.0], np.cumsum(pieces)])
    for scope, mask in scopes.items():
        first, last = np.flatnonzero(mask)[[0, -1]]
        last = min(last + 1, len(energy) - 1)  # phases share their boundary sample
        spent = float(energy[last] - energy[first])
        yield Row(registry.FRICTION_ENERGY, clutch, scope, spent)
        yield Row(registry.FRICTION_PEAK, clutch, scope, float(power[mask].max()))


def _lock_ups(results: Results, clutch: str) -> Iterator[Row]:
    state = clutch_state(results, clutch)
    if state is None:
        return
    locked = np.flatnonzero((state[:-1] == 2) & (state[1:] == 3)) + 1
    for count, k in enumerate(locked, 1):
        yield Row(registry.LOCK_UP, clutch, f"lock-up {count}", float(results.time[k]))


def _shifts(results: Results) -> Iterator[Row]:
    """Yield the time between two drives on different clutches, one engaged, the other open."""
    states = [clutch_state(results, clutch) for clutch in CLUTCHES]
    if any(state is None for state in states):
        return
    first, second = states
    driving = np.where((first == 3) & (second == 1), 1, 0)
    driving = np.where((second == 3) & (first == 1), 2, driving)
    steady = np.flatnonzero(driving)
    change = np.flatnonzero(np.diff(driving[steady]))
    for count, k in enumerate(change, 1):
        start, end = steady[k], steady[k + 1]
        label = f"clutch{driving[start]} → clutch{driving[end]}"
        duration = float(results.time[end] - results.time[start])
        yield Row(registry.SHIFT_DURATION, label, f"shift {count}", duration)
