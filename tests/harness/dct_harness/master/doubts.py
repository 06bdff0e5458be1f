"""What a scenario says that was probably meant in another unit: millimetres, bar, rpm, ms.

Nothing is refused: an FMU takes 3 m of actuator travel. But somebody should be told.
"""

from __future__ import annotations

import math

import numpy as np

from ..contract import plant as plant_contract
from ..errors import instant
from ..system.scenario import Scenario

FAR = 100.0  # units that differ by less may both be meant
USUAL = (0.01, 1000.0)  # in the unit in which tools show a quantity: 0.01 mm, 1000 mm; 0.01 bar
FASTEST = {"rpm": 12000.0}  # of what a car has, where units differ by less than FAR
MILLISECONDS = 500.0  # how often a run would fit into its scenario, were the times in ms; about


def of(script: Scenario, used: list[str], stop: float) -> list[tuple[float, str]]:
    """Return since when [s] something is in doubt, and what.

    `used`: the columns that an FMU reads; `stop`: end of the run [s].
    """
    name = f"scenario {script.path.name}"
    found = [(0.0, f"{name}: {text}") for signal in used if (text := _unit(script, signal))]
    last = float(script.time[-1])
    if last > MILLISECONDS * stop:
        what = f"{name} goes on to t = {instant(last)} s: are its times in ms? They are read as s"
        found.append((stop, what))
    return found


def _unit(script: Scenario, signal: str) -> str | None:
    """Return what is odd about the size of a signal that a plant has, too."""
    contract = plant_contract()
    variable = contract.variables.get(signal)
    if variable is None or not variable.displayUnit:
        return None
    shown = {d.name: d for u in contract.description.unitDefinitions for d in u.displayUnits}
    factor = float(shown[variable.displayUnit].factor)
    size = float(np.abs(script.signals[signal]).max())
    most = FASTEST.get(variable.displayUnit, USUAL[1] if factor >= FAR else math.inf)
    large = size * factor >= most
    small = factor <= 1 / FAR and 0 < size * factor < USUAL[0]
    if not (large or small):
        return None
    unit = contract.unit(signal).name
    return (
        f"{signal} reaches {size:.4g} {unit}, {size * factor:.4g} {variable.displayUnit}: "
        f"is it in {variable.displayUnit}? It is read as {unit}"
    )
