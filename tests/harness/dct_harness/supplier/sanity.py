"""Sign check: short manoeuvres whose direction every plant of a vehicle shares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..contract import plant as plant_contract
from .against import Finding
from .mapped import Mapped

STEP = 1e-3  # s
DURATION = 2.5  # s
CLOSING = 0.6  # s, until a clutch is closed
TORQUE = 60.0  # N.m, of the engine
CLOSED = {"position": 0.008, "pressure": 1.2e6}  # m, Pa
RESISTANCES = {"brake.torque": 300.0, "road.grade": 0.08}  # N.m, rad
IDLE = 90.0  # rad/s

Signals = dict[str, np.ndarray]
Inputs = dict[str, float]


@dataclass(frozen=True)
class Sign:
    """A signal that must be above `least` at the end of a manoeuvre, in its SI unit."""

    text: str
    signal: str
    value: Callable[[Signals, str], float]
    least: float = 0.05


def _end(signals: Signals, name: str) -> float:
    """Return the mean over the last fifth."""
    values = signals[name]
    return float(np.mean(values[-len(values) // 5 :]))


def _gain(signals: Signals, name: str) -> float:
    return _end(signals, name) - float(signals[name][0])


def _peak(signals: Signals, name: str) -> float:
    """Return the value that is farthest from 0 while the clutch closes."""
    values = signals[name][: round(CLOSING / STEP)]
    return float(values[np.argmax(np.abs(values))])


OPEN = [Sign("positive engine torque accelerates the engine", "engine.speed", _gain)]


def _driven(clutch: int) -> list[Sign]:
    c = f"clutch{clutch}"
    return [
        Sign(f"closed {c} transmits", f"{c}.torque", _end, 1.0),
        Sign(f"closed {c} turns its shaft forward", f"{c}.speed", _end),
        Sign(f"slip of {c} is engine minus gearbox", f"{c}.slip", _peak),
        Sign(f"closed {c} drives the shaft to the wheels", "driveShaft.torque", _end),
        Sign(f"closed {c} turns the wheels forward", "wheel.speed", _end),
        Sign(f"closed {c} moves the vehicle forward", "vehicle.speed", _end),
        Sign(f"closed {c} accelerates the vehicle", "vehicle.acceleration", _end),
    ]


def signs(make: Callable[[], Mapped]) -> list[Finding]:
    """Run the manoeuvres on fresh instances from `make`; returns a line for each sign."""
    found = _judge(OPEN, _run(make(), {}))
    base: Signals = {}
    for clutch in (1, 2):
        base = _run(make(), _closing(clutch))
        found += _judge(_driven(clutch), base)
    for name, value in RESISTANCES.items():
        more = _run(make(), {**_closing(2), name: value})
        slower = {n: base[n] - more[n] for n in base}
        if f".{name}" in more:
            sign = Sign(f"positive {name} slows the vehicle", "wheel.speed", _end)
            found += _judge([sign], slower)
    return found


def _closing(clutch: int) -> Inputs:
    return {f"clutch{clutch}.{what}": value for what, value in CLOSED.items()}


def _judge(wanted: list[Sign], signals: Signals) -> list[Finding]:
    found = []
    for sign in wanted:
        if sign.signal in signals:
            value = sign.value(signals, sign.signal)
            wrong = not value > sign.least
            text = "ok" if not wrong else "wrong sign or no effect: try factor = -1"
            unit = plant_contract().unit(sign.signal).name
            found.append(Finding(sign.text, sign.signal, f"{text} ({value:.3g} {unit})", wrong))
    return found


def _run(plant: Mapped, held: Inputs) -> Signals:
    """Return the outputs over time, and `.name` for each input that the plant has."""
    try:
        names = [v.name for v in plant.inputs]
        start = {"engine.speed_start": IDLE} if plant.sets("engine.speed_start") else {}
        plant.initialize(DURATION, start)
        inputs, outputs = np.zeros(len(names)), np.zeros(len(plant.outputs))
        plant.bind(inputs, outputs)
        final = {"engine.torque": TORQUE, "shaft1.gear": 1.0, "shaft2.gear": 2.0, **held}
        goal = np.array([final.get(n, 0.0) for n in names])
        ramps = np.array([n.startswith("clutch") for n in names])
        inputs[:] = np.where(ramps, 0.0, goal)
        plant.set_inputs()
        plant.exit_initialization()
        plant.get_outputs()
        rows = [outputs.copy()]
        for k in range(round(DURATION / STEP)):
            inputs[ramps] = goal[ramps] * min(1.0, k * STEP / CLOSING)
            plant.step(k * STEP, STEP)
            rows.append(outputs.copy())
    finally:
        plant.close()
    table = np.array(rows)
    signals = {v.name: table[:, k] for k, v in enumerate(plant.outputs)}
    return signals | {f".{n}": np.zeros(1) for n in names}
