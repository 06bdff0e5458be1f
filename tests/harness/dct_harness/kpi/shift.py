"""Shift quality: jerk, vibration dose, friction energy, lock-up times."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterator

import numpy as np

from ..results import Results
from . import registry
from .filters import low_pass, weight_d
from .rows import Row, rms
from .scopes import CLUTCHES, Phase, Samples, clutch_state, phase_masks, states

ACCELERATION, SPEED = "plant.vehicle.acceleration", "plant.vehicle.speed"


def reads(known: Collection[str]) -> Iterator[str]:
    """Yield which of the known signals `rows` may read."""
    yield from states(known)
    yield from _motion(known)
    for clutch in CLUTCHES:
        power = _power(known, clutch)
        yield from power
        if power and _energy(clutch) in known:
            yield _energy(clutch)


def rows(results: Results, phases: list[Phase] | None) -> Iterator[Row]:
    """Yield the shift-quality KPIs that the plant's outputs allow."""
    scopes = phase_masks(results.time, phases or [])
    filtered = jerk(results)
    if filtered is not None:
        for scope, mask in scopes.items():
            peak = float(np.abs(filtered[mask]).max())
            yield Row(registry.JERK_PEAK, "vehicle.acceleration", scope, peak)
            yield Row(registry.JERK_RMS, "vehicle.acceleration", scope, rms(filtered[mask]))
    yield from _doses(results, scopes)
    for clutch in CLUTCHES:
        yield from _friction(results, clutch, scopes)
        yield from _lock_ups(results, clutch)


def jerk(results: Results) -> np.ndarray | None:
    """Return the filtered jerk [m/s³], shape (n,); None without acceleration or speed."""
    values = acceleration(results)
    if values is None:
        return None
    return np.gradient(low_pass(values, results.step, registry.JERK_CUTOFF), results.time)


def acceleration(results: Results) -> np.ndarray | None:
    """Return the vehicle's acceleration [m/s²], shape (n,); from its speed if need be."""
    if len(results.time) < 3:
        return None
    for name in _motion(results):
        values = results[name]
        return values if name == ACCELERATION else np.gradient(values, results.time)
    return None


def _motion(known: Container[str]) -> tuple[str, ...]:
    """Return the one signal that the acceleration is made of, if there is one."""
    return next(((name,) for name in (ACCELERATION, SPEED) if name in known), ())


def _doses(results: Results, scopes: dict[str, Samples]) -> Iterator[Row]:
    """Yield the vibration dose value per scope."""
    values = acceleration(results)
    if values is None:
        return
    dose = results.step * np.square(np.square(weight_d(values, results.step)))
    for scope, mask in scopes.items():
        yield Row(registry.DOSE, "vehicle.acceleration", scope, float(dose[mask].sum() ** 0.25))


def friction_power(results: Results, clutch: str) -> np.ndarray | None:
    """Return the friction power of a clutch [W], shape (n,), or None if it cannot be known."""
    parts = [results[name] for name in _power(results, clutch)]
    if not parts:
        return None
    power, *slip = parts
    if slip:
        return power * (slip[0] if len(slip) == 1 else slip[0] - slip[1])
    return power


def _power(known: Container[str], clutch: str) -> tuple[str, ...]:
    """Return what a friction power is made of: itself, or torque and slip, or torque and speeds."""
    direct, torque, slip, speed = (
        f"plant.{clutch}.{name}" for name in ("frictionPower", "torque", "slip", "speed")
    )
    ways = ((direct,), (torque, slip), (torque, "plant.damper.speed", speed))
    return next((way for way in ways if all(name in known for name in way)), ())


def _energy(clutch: str) -> str:
    return f"plant.{clutch}.frictionEnergy"


def _friction(results: Results, clutch: str, scopes: dict[str, Samples]) -> Iterator[Row]:
    power = friction_power(results, clutch)
    if power is None or len(power) < 2:
        return
    energy = _spent(results, clutch, power)
    for scope, mask in scopes.items():
        first, last = np.arange(len(power))[mask][[0, -1]]
        last = min(last + 1, len(energy) - 1)  # phases share their boundary sample
        spent = float(energy[last] - energy[first])
        yield Row(registry.FRICTION_ENERGY, clutch, scope, spent)
        yield Row(registry.FRICTION_PEAK, clutch, scope, float(power[mask].max()))


def _spent(results: Results, clutch: str, power: np.ndarray) -> np.ndarray:
    """Return the friction energy so far [J], shape (n,): told by the plant, else of its power."""
    if _energy(clutch) in results:
        return results[_energy(clutch)]
    pieces = np.diff(results.time) * (power[1:] + power[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(pieces)])


def _lock_ups(results: Results, clutch: str) -> Iterator[Row]:
    state = clutch_state(results, clutch)
    if state is None:
        return
    locked = np.flatnonzero((state[:-1] == 2) & (state[1:] == 3)) + 1
    for count, k in enumerate(locked, 1):
        yield Row(registry.LOCK_UP, clutch, f"lock-up {count}", float(results.time[k]))
