"""What an observer learns of its own errors, with the standard deviation it gives."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..kpi import side_by_side
from ..kpi.estimation import OBSERVER
from . import figures
from .downsample import m4, pack
from .runs import View

Json = dict[str, Any]
# Signal behind `calibration.`, what people call it, its unit, shown number per SI unit.
LEARNT = (
    ("torqueScale", "engine torque, scale α", "%", 100.0),
    ("torqueBias", "engine torque, bias β", "N·m", 1.0),
    ("inertiaError", "engine-side inertia δ", "%", 100.0),
    ("wheelSpeedBias", "wheel speed, bias w", "rad/s", 1.0),
    ("stiffnessError", "drive-shaft stiffness κ", "%", 100.0),
    ("dampingError", "drive-shaft damping γ", "%", 100.0),
    ("gearboxInertiaError", "gearbox inertia λ", "%", 100.0),
    ("vehicleInertiaError", "vehicle inertia ν", "%", 100.0),
    ("vehicleMass", "vehicle mass M<sub>v</sub>", "kg", 1.0),
)
# Parameters whose sum, plant's over observer's, less 1 is what there is to be learnt.
INJECTED = {
    "inertiaError": ("engine.inertia", "damper.inertia"),
    "stiffnessError": ("driveShaft.stiffness",),
    "dampingError": ("driveShaft.damping",),
}
TORQUE = "scenario.engine.torque"  # what the plant takes


def drawn(view: View) -> list[Json]:
    """Return a figure per observer that learns something."""
    found = []
    for component in (OBSERVER, *side_by_side.others(view.kpis)):
        panels = [p for row in LEARNT if (p := _panel(view, component, *row)) is not None]
        if panels:
            found.append(_figure(view, component, panels))
    return found


def _panel(
    view: View, component: str, key: str, title: str, unit: str, factor: float
) -> Json | None:
    """Return one quantity with its band; None for an anchor, which is not learnt."""
    names = [f"{component}.calibration.{key}{end}" for end in ("", "Deviation")]
    if any(name not in view.results for name in names):
        return None
    value, deviation = (view.results[name] * factor for name in names)
    if not deviation.any():
        return None
    traces = _band(view, value, deviation)
    given = injected(view, component, key)
    if given is not None:
        level = np.full(len(value), given * factor)
        traces.append(figures.trace(view, level, "truth", "what there is to learn"))
    traces.append(figures.trace(view, value, "observer", "learnt"))
    first, last = deviation[np.flatnonzero(deviation)[0]], deviation[-1]
    digits = decimals(last)
    end = round(value[-1], digits) + 0.0  # no −0
    found = f"{end:.{digits}f} ± {last:.{digits}f} {unit}".replace("-", "−")
    heading = f"{title}: {found} at the end, ± {first:.{decimals(first)}f} at first"
    return {"title": f"{title.rpartition(' ')[2]} [{unit}]", "heading": heading, "traces": traces}


def decimals(deviation: float) -> int:
    """Return the decimals that show two digits of a standard deviation."""
    return max(0, 1 - math.floor(math.log10(deviation))) if deviation > 0 else 0


def _band(view: View, value: np.ndarray, deviation: np.ndarray) -> list[Json]:
    """Return the lines of value ± deviation, the second filled down to the first."""
    made = []
    for side in (-1, 1):
        edge = value + side * deviation
        index = m4(edge)
        made.append({"role": "band", "name": "± one standard deviation", "fill": side > 0,
                     "x": pack(view.results.time[index]), "y": pack(edge[index])})  # fmt: skip
    return made


def injected(view: View, component: str, key: str) -> float | None:
    """Return the error that an observer's parameters or measurements have; None if unknown."""
    if key in ("torqueScale", "torqueBias"):
        return _misread(view, component, key)
    told = view.run.get("parameters", {})
    try:
        true, believed = (
            sum(told[who][name]["value"] for name in INJECTED[key]) for who in ("plant", component)
        )
    except KeyError:
        return None
    return true / believed - 1 if believed else None


def _misread(view: View, component: str, key: str) -> float | None:
    """Return what undoes the factor and offset of the connection that feeds the engine torque."""
    for entry in view.run.get("system", {}).get("connections", []):
        if entry["to"] == f"{component}.engine.torque" and entry["from"] == TORQUE:
            factor, offset = entry.get("factor", 1.0), entry.get("offset", 0.0)
            return 1 / factor - 1 if key == "torqueScale" else -offset / factor
    return None


def _figure(view: View, component: str, panels: list[Json]) -> Json:
    who = "" if component == OBSERVER else f", {component}"
    caption = f"What the observer learns of its own errors{who}"
    rows = -(-len(panels) // 2)
    return {
        "id": f"calibration-{component}-{view.slug}", "panels": panels, "columns": 2,
        "phases": [], "caption": caption, "aria": f"{caption}; {view.title}",
        "range": figures.reach([view]), "height": 190 * rows + 110,
    }  # fmt: skip
