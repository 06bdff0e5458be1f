"""Figures as data for report.js: panels with traces, state shading, phases, events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from ..kpi import tracking
from ..kpi.scopes import CLUTCHES
from .downsample import m4, pack
from .friction import coefficients, position_of
from .runs import Pair, View

RPM = 60 / (2 * np.pi)  # rad/s to rpm
MM = 1e3  # m to mm
KILO = 1e-3  # N/m to kN/m
LABEL = {"clutch1": "clutch 1", "clutch2": "clutch 2"}
TORQUE_TITLES = {
    "clutch1.torque": "T<sub>c1</sub> clutch 1 [N·m]",
    "clutch2.torque": "T<sub>c2</sub> clutch 2 [N·m]",
    "driveShaft.torque": "T<sub>o</sub> drive shaft [N·m]",
}
PANEL_HEIGHT = 168  # px; three panels, legend and phase names fit a 768 px screen

Json = dict[str, Any]


def escape(text: str) -> str:
    """Return text that plotly.js, which reads a little HTML, shows as it is."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def trace(view: View, values: np.ndarray, role: str, name: str) -> Json:
    """Return one line, down-sampled; `role` chooses colour and dash in report.js."""
    index = m4(values)
    return {"role": role, "name": escape(name), "x": pack(view.results.time[index]),
            "y": pack(values[index])}  # fmt: skip


def signal_lines(view: View, *wanted: tuple[str, str, str, float]) -> list[Json]:
    """Return lines for those of (signal, role, name, factor) that the run has."""
    found = []
    for signal, role, name, factor in wanted:
        if signal in view.results:
            found.append(trace(view, view.results[signal] * factor, role, name))
            found += _before(view, signal, role, name, partial(np.multiply, factor))
    return found


def _before(
    view: View, signal: str, role: str, name: str, shape: Callable[[np.ndarray], np.ndarray]
) -> list[Json]:
    """Return the line of the earlier run, if there is one and it differs."""
    earlier = view.earlier
    if earlier is None or signal not in earlier.results:
        return []
    values, now = earlier.results[signal], view.results[signal]
    if values.shape == now.shape and (values == now).all():
        return []
    return [{**trace(earlier, shape(values), role, f"{name}, earlier"), "before": True}]


def panelled(key: str, view: View, panels: list[Json], caption: str, aria: str) -> Json | None:
    """Return a figure of panels above one another; None without a line."""
    panels = [p for p in panels if p["traces"]]
    if not panels:
        return None
    phases = [{**p, "name": escape(p["name"])} for p in view.kpis["phases"]]
    weight = sum(p.get("weight", 1.0) for p in panels)
    return {
        "id": f"{key}-{view.slug}", "panels": panels, "phases": phases, "caption": caption,
        "range": reach([view]), "aria": aria, "columns": 1,
        "height": round(PANEL_HEIGHT * weight + 110),
    }  # fmt: skip


def reach(views: list[View]) -> list[float]:
    """Return the first and last time [s] of runs shown together."""
    times = [view.results.time for view in views]
    return [float(min(t[0] for t in times)), float(max(t[-1] for t in times))]


def _marks(view: View, clutch: str, values: np.ndarray) -> list[Json]:
    """Return event markers on a line: a symbol per kind of change, the sentence on hover."""
    changes = view.changes(clutch)
    if not changes:
        return []
    index = [k for k, _ in changes]
    return [{
        "role": "event", "name": "clutch event", "x": view.results.time[index].tolist(),
        "y": values[index].tolist(), "text": [escape(text) for _, text in changes],
        "to": [text.rpartition(" ")[2] for _, text in changes],
    }]  # fmt: skip


def state_shades(view: View, clutch: str) -> list[Json]:
    """Return the states of a clutch as full-height bands."""
    return [{**span, "y0": 0, "y1": 1} for span in view.spans(clutch)]


def driveline(view: View) -> Json | None:
    """Return Fig. 9: actuator positions, driveline speeds, clutch states."""
    positions = []
    for clutch in CLUTCHES:
        if found := position_of(view.results, clutch):
            positions += signal_lines(view, (found, clutch, LABEL[clutch], MM))
    speeds = []
    for part in ("engine", *CLUTCHES, "wheel"):
        ends = (f"plant.{part}.speed", f"scenario.{part}.speed")  # the latter: of a measured drive
        known = next((end for end in ends if end in view.results), ends[0])
        speeds += signal_lines(view, (known, part, LABEL.get(part, part), RPM))
    panels: list[Json] = [
        {"title": "position [mm]", "traces": positions},
        {"title": "speed [rpm]", "traces": speeds, "weight": 1.4},
        _ribbons(view),
    ]
    caption = "Actuator positions, driveline speeds and clutch states"
    return panelled("driveline", view, panels, caption, f"{caption} of {view.title}")


def _ribbons(view: View) -> Json:
    """Return a panel with one coloured ribbon per clutch."""
    shades, traces = [], []
    for row, clutch in enumerate(reversed(CLUTCHES)):
        level = np.full(len(view.results.time), row + 0.5)
        traces += _marks(view, clutch, level)
        band = {"y0": row / 2 + 0.06, "y1": row / 2 + 0.44}
        shades += [{**span, **band, "solid": True} for span in view.spans(clutch)]
    ticks = {"vals": [0.5, 1.5], "text": [LABEL[c] for c in reversed(CLUTCHES)], "range": [0, 2]}
    return {"title": "state", "traces": traces, "shades": shades, "ticks": ticks, "weight": 0.45}


def torques(view: View) -> Json | None:
    """Return Fig. 10 or 12: true, map-based and observed torques, one panel each."""
    panels = []
    for torque, title in TORQUE_TITLES.items():
        lines = signal_lines(
            view, (f"plant.{torque}", "truth", view.truth, 1.0),
            (f"observer.mapBased.{torque}", "map", "map-based", 1.0),
            (f"observer.{torque}", "observer", "observer", 1.0),
        )  # fmt: skip
        clutch = torque.partition(".")[0]
        shades = state_shades(view, clutch)
        if f"plant.{torque}" in view.results:
            lines += _marks(view, clutch, view.results[f"plant.{torque}"])
        panels.append({"title": title, "traces": lines, "shades": shades})
    caption = "Torques: true, map-based, observer"
    return panelled("torques", view, panels, caption, f"{caption}; {view.title}")


def friction(view: View) -> Json | None:
    """Return Fig. 11 or 13: adapted, nominal and true friction coefficient per stroke."""
    panels = []
    for clutch in CLUTCHES:
        known = coefficients(view.results, clutch)
        roles = {"truth": "true torque / (r N θ)", "map": "nominal μₙ·f",
                 "observer": "adapted μ·f"}  # fmt: skip
        lines = [trace(view, known[r] * KILO, r, n) for r, n in roles.items() if r in known]
        lines += _friction_before(view, clutch, known)
        shades = state_shades(view, clutch)
        title = f"μ·f {LABEL[clutch]} [kN/m]"
        panels.append({"title": title, "traces": lines, "shades": shades})
    caption = "Friction coefficient times force per stroke, μ·f"
    return panelled("friction", view, panels, caption, f"{caption}; {view.title}")


def _friction_before(view: View, clutch: str, known: dict[str, np.ndarray]) -> list[Json]:
    """Return the adapted coefficient of the earlier run, if it differs."""
    if view.earlier is None:
        return []
    values = coefficients(view.earlier.results, clutch).get("observer")
    now = known.get("observer")
    same = values is not None and now is not None and np.array_equal(values, now, equal_nan=True)
    if values is None or same:
        return []
    made = trace(view.earlier, values * KILO, "observer", "adapted μ·f, earlier")
    return [{**made, "before": True}]


def track(view: View, partner: View | None = None) -> Json | None:
    """Return requested and real clutch torques and the error while slipping."""
    runs = [(view, "closed" if view.feedback else "opened")]
    if partner:
        runs.append((partner, "opened"))
    panels = [panel for clutch in CLUTCHES for panel in _track_panels(clutch, runs)]
    caption = "Requested and real clutch torque; error while the clutch slips"
    return panelled("tracking", view, panels, caption, f"{caption}; {view.title}")


def _track_panels(clutch: str, runs: list[tuple[View, str]]) -> Iterator[Json]:
    view, request = runs[0][0], f"scenario.{clutch}.torqueRequest"
    if request not in view.results:
        return
    names = {"closed": "with feedback", "opened": "without feedback"}
    torque = signal_lines(view, (request, "truth", "request", 1.0))
    errors = []
    for run, role in runs:
        signal = f"plant.{clutch}.torque"
        if signal in run.results:
            torque.append(trace(run, np.abs(run.results[signal]), role, names[role]))
            torque += _before(run, signal, role, names[role], np.abs)
        values = tracking.error(run.results, clutch)
        if values is not None:
            errors.append(trace(run, values, role, names[role]))
    shades = state_shades(view, clutch)
    yield {"title": f"|T<sub>c{clutch[-1]}</sub>| [N·m]", "traces": torque, "shades": shades}
    yield {"title": f"error {LABEL[clutch]} [N·m]", "traces": errors, "shades": shades,
           "weight": 0.8}  # fmt: skip


def energy(views: list[View]) -> Json | None:
    """Return the plant's energy residual, one small panel per run."""
    signal = "plant.energy.residual"
    own = [v for v in views if signal in v.results]
    panels = [
        {"title": "residual [J]", "heading": escape(v.title),
         "traces": signal_lines(v, (signal, "observer", "energy residual", 1.0))}
        for v in own
    ]  # fmt: skip
    if not panels:
        return None
    columns = min(2, len(panels))  # of a narrow page, with names as headings
    rows = -(-len(panels) // columns)
    largest = max(float(np.abs(v.results[signal]).max()) for v in own)
    return {
        "id": "energy", "panels": panels, "phases": [], "columns": columns, "legend": False,
        "caption": "Energy balance of the plant", "aria": "Energy residual of each run",
        "range": reach(own), "height": 170 * rows + 70, "largest": f"{largest:.1e}",
    }  # fmt: skip


def of_pair(pair: Pair) -> Json | None:
    """Return the tracking figure with both runs."""
    return track(pair.closed, pair.opened)
