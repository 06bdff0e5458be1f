"""Friction over the position as an observer learnt it, what it believed at first, and the truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kpi.estimation import OBSERVER
from ..kpi.side_by_side import others
from ..ssp.calibration import CLUTCHES, MAP, NOMINAL, POINTS, force_map, places
from .downsample import pack
from .runs import View

Json = dict[str, Any]
MM = 1e3  # m to mm
FINE = 161  # positions of a line


def drawn(view: View) -> list[Json]:
    """Return a figure per observer that learns friction over the position."""
    found = []
    for component in (OBSERVER, *others(view.kpis)):
        panels = [p for c in CLUTCHES if (p := _panel(view, component, c)) is not None]
        if panels:
            found.append(_figure(view, component, panels))
    return found


def _panel(view: View, component: str, clutch: str) -> Json | None:
    """Return the friction of one clutch over its stroke; None where none was learnt."""
    head = f"{component}.{clutch}.{MAP}"
    known = view.run.get("parameters", {}).get(component, {})
    if f"{head}[1]" not in view.results or f"{clutch}.map.force[1]" not in known:
        return None
    mu, deviation = (
        np.array([view.results[f"{head}{end}[{k}]"][-1] for k in range(1, POINTS + 1)])
        for end in ("", "Deviation")
    )
    if not deviation.any():
        return None
    points = places(*force_map(known, clutch))
    fine = np.linspace(points[0], points[-1], FINE)
    learnt, band = (np.interp(fine, points, values) for values in (mu, deviation))
    traces = [_line(fine, learnt + side * band, "band", "± one standard deviation", fill=side > 0)
              for side in (-1, 1)]  # fmt: skip
    believed = np.full(FINE, known[f"{clutch}.{NOMINAL}"]["value"])
    traces.append(_line(fine, believed, "map", "believed at first"))
    true = _true(view, component, clutch, fine)
    if true is not None:
        traces.append(_line(fine, true, "truth", "what there is to learn"))
    traces.append(_line(fine, learnt, "observer", "learnt"))
    best = int(np.argmin(deviation))
    heading = (f"clutch {clutch[-1]}: {mu[best]:.3f} ± {deviation[best]:.3f} "
               f"at {points[best] * MM:.1f} mm")  # fmt: skip
    return {"title": "μ [1]", "heading": heading, "traces": traces}


def _true(view: View, component: str, clutch: str, theta: np.ndarray) -> np.ndarray | None:
    """Return the friction that makes the plant's torque of the observer's map, shape (n,)."""
    told = view.run["parameters"]
    try:
        plant, known = told["plant"], told[component]
        friction = plant[f"{clutch}.kineticFriction"]["value"]
        if plant[f"{clutch}.pistonArea"]["value"] > 0:
            return np.full(len(theta), friction)
        radius = (plant, known)
        arm = [p[f"{clutch}.effectiveRadius"]["value"] for p in radius]
        force = [np.interp(theta, *force_map(p, clutch)) for p in radius]
    except KeyError:
        return None
    carries = force[1] > 0
    ratio = np.divide(force[0] * arm[0], force[1] * arm[1], where=carries,
                      out=np.full(len(theta), np.nan))  # fmt: skip
    return friction * ratio


def _line(theta: np.ndarray, values: np.ndarray, role: str, name: str, **more: bool) -> Json:
    return {"role": role, "name": name, "x": pack(theta * MM), "y": pack(values), **more}


def _figure(view: View, component: str, panels: list[Json]) -> Json:
    who = "" if component == OBSERVER else f", {component}"
    caption = f"Friction over the position of each clutch at the end{who}"
    known = view.run["parameters"][component]
    ends = np.array([places(*force_map(known, clutch))[[0, -1]] for clutch in CLUTCHES]) * MM
    return {
        "id": f"frictionmap-{component}-{view.slug}", "panels": panels, "columns": 2,
        "phases": [], "caption": caption, "aria": f"{caption}; {view.title}", "height": 330,
        "range": [float(ends.min()), float(ends.max())], "across": "position [mm]",
    }  # fmt: skip
