"""Sign check: short manoeuvres whose direction every plant of a vehicle shares.

What the same manoeuvres show twice has to agree: slip and two speeds, a gear and two speeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

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
APART = 0.1  # relative: twist and damper move speeds by less, units and gears by more

LEAST = 0.05  # in SI units: below it nothing has moved
Signals = dict[str, np.ndarray]
Inputs = dict[str, float]


@dataclass(frozen=True)
class Sign:
    """A signal that must be above `least` at the end of a manoeuvre, in its SI unit."""

    text: str
    signal: str
    value: Callable[[Signals, str], float]
    least: float = LEAST


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


def signs(make: Callable[[], Mapped], known: dict[str, Any]) -> list[Finding]:
    """Run the manoeuvres on fresh instances from `make`; returns a line for each sign.

    `known`: what is known of the vehicle beside the parameters of the FMU, by our names, in SI.
    """
    plant = make()
    vehicle = {**plant.shared({}), **known}
    found = _judge(OPEN, _run(plant, {}))
    base: Signals = {}
    for clutch in (1, 2):
        base = _run(make(), _closing(clutch))
        found += _judge(_driven(clutch), base)
        found += _agreements(clutch, base, vehicle)
    for name, value in RESISTANCES.items():
        more = _run(make(), {**_closing(2), name: value})
        slower = {n: base[n] - more[n] for n in base}
        if f".{name}" in more:
            sign = Sign(f"positive {name} slows the vehicle", "wheel.speed", _end)
            found += _judge([sign], slower)
    return found


def _agreements(clutch: int, signals: Signals, vehicle: dict[str, Any]) -> list[Finding]:
    """Compare the speeds with each other and with the vehicle's parameters, where they are told."""
    c, s = f"clutch{clutch}", f"shaft{clutch}"
    speed, wheel = _end(signals, f"{c}.speed"), _end(signals, "wheel.speed")
    if not (speed > LEAST and wheel > LEAST):
        return []  # a wrong sign, told already
    found = []
    if f"{c}.slip" in signals:
        engine, sum_ = _end(signals, "engine.speed"), speed + _end(signals, f"{c}.slip")
        text = f"engine speed is that of {c} and its slip"
        found.append(_agreement(text, "engine.speed", engine, sum_, f"their units, {c}.slip"))
    gear = f"{s}.finalDriveRatio", f"{s}.gearRatio[1]"
    if all(name in vehicle for name in gear):
        text = f"{c} turns as fast as gear and wheel say"
        told = wheel * vehicle[gear[0]] * vehicle[gear[1]]
        found.append(
            _agreement(text, f"{c}.speed", speed, told, f"its unit, wheel.speed, ratios of {s}")
        )
    if clutch == 1 and "vehicle.speed" in signals and "wheel.radius" in vehicle:
        told = wheel * vehicle["wheel.radius"]
        text = "vehicle is as fast as its wheels"
        found.append(_agreement(text, "vehicle.speed", _end(signals, "vehicle.speed"), told,
                                "its unit, wheel.speed, wheel.radius"))  # fmt: skip
    return found


def _agreement(text: str, signal: str, value: float, told: float, about: str) -> Finding:
    """Return the line of a value that others tell, too."""
    unit = plant_contract().unit(signal).name
    wrong = not abs(value - told) <= APART * abs(told)
    verdict = (
        f"{value:.3g} {unit}, not {told:.3g}: check {about}"
        if wrong
        else f"ok ({value:.3g} {unit})"
    )
    return Finding(text, signal, verdict, wrong)


def _closing(clutch: int) -> Inputs:
    return {f"clutch{clutch}.{what}": value for what, value in CLOSED.items()}


def _judge(wanted: list[Sign], signals: Signals) -> list[Finding]:
    found = []
    for sign in wanted:
        if sign.signal in signals:
            value = sign.value(signals, sign.signal)
            wrong = not value > sign.least
            text = "ok" if not wrong else _remedy(value, sign.least)
            unit = plant_contract().unit(sign.signal).name
            found.append(Finding(sign.text, sign.signal, f"{text} ({value:.3g} {unit})", wrong))
    return found


def _remedy(value: float, least: float) -> str:
    if value < -least:
        return "wrong sign: try factor = -1"
    return "no effect to speak of: check unit, factor, offset, and those of the inputs"


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
