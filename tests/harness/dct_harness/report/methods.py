"""Several observers beside one plant: the paper's Figs. 10 to 13 with a line per method."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kpi import side_by_side
from ..kpi.estimation import MAP, OBSERVER, TORQUES, estimates
from ..kpi.scopes import CLUTCHES
from ..kpi.table import UNDEFINED, shown
from . import figures, friction
from .cells import HTML_SYMBOL
from .runs import View

Json = dict[str, Any]
ROLES = {"lyapunov": "method2", "energy": "method3", "kalman": "method4", "calibrating": "method5"}
FROZEN = "adaptation.enabled"  # parameter; false: the estimate keeps the nominal friction
NAMES = {MAP: "map-based", "nonAdaptive": "non-adaptive"}


def several(view: View) -> bool:
    """Return whether a run has more observers than one."""
    return bool(side_by_side.others(view.kpis))


def label(view: View, estimate: str) -> str:
    """Return what people call an estimate; the observer goes by its method."""
    if estimate == OBSERVER:
        return view.method or OBSERVER
    return NAMES.get(estimate, estimate)


def _role(view: View, estimate: str) -> str:
    """Return colour and dash of a line: those known by name, the others in turn."""
    known = {OBSERVER: "observer", MAP: "map"} | ROLES
    if not adapts(view, estimate):
        return "frozen"
    others = [e for e in side_by_side.others(view.kpis) if e not in known]
    return known.get(estimate) or f"method{2 + others.index(estimate) % len(ROLES)}"


def adapts(view: View, estimate: str) -> bool:
    """Return whether an observer learns the friction."""
    given = view.run.get("parameters", {}).get(estimate, {}).get(FROZEN, {})
    return bool(given.get("value", True))


def table(view: View) -> Json:
    """Return the errors of every estimate over the scenario, the best of each column marked."""
    lines = side_by_side.lines(view.kpis)
    best = [_best(column) for column in zip(*lines.values(), strict=True)]
    return {
        "torques": [HTML_SYMBOL[TORQUES[t]] for t in side_by_side.torques(view.kpis)],
        "columns": list(side_by_side.FIGURES),
        "rows": [
            {"name": label(view, e), "cells": [
                {"text": UNDEFINED if r is None else shown(r), "best": r is not None and r is least}
                for r, least in zip(rows, best, strict=True)]}
            for e, rows in lines.items()
        ],
    }  # fmt: skip


def _best(column: tuple[Json | None, ...]) -> Json | None:
    """Return the row with the least value; none for latencies, where 0 may be luck."""
    known = [row for row in column if row is not None and row["value"] is not None]
    if not known or known[0]["kpi"] == side_by_side.FIGURES["late [s]"]:
        return None
    return min(known, key=lambda row: row["value"])


def drawn(view: View) -> list[Json]:
    """Return the figures: torques, errors of those that adapt, friction coefficients."""
    made = (_torques(view), _errors(view), _friction(view))
    return [figure for figure in made if figure is not None]


def _torques(view: View) -> Json | None:
    known = estimates(view.results)
    order = [MAP, *sorted((e for e in known if e != MAP), key=lambda e: adapts(view, e))]
    panels = []
    for torque, title in figures.TORQUE_TITLES.items():
        wanted = [(f"plant.{torque}", "truth", view.truth, 1.0)]
        wanted += [(known[e] + torque, _role(view, e), label(view, e), 1.0)
                   for e in order if e in known]  # fmt: skip
        panels.append(_panel(view, title, torque, figures.signal_lines(view, *wanted)))
    frozen = any(e != MAP and not adapts(view, e) for e in known)
    kept = "map-based, non-adaptive" if frozen else "map-based"
    caption = f"Torques: true, {kept} and five methods"
    return figures.panelled("torques", view, panels, _counted(view, caption), _of(view, caption))


def _counted(view: View, caption: str) -> str:
    """Return a caption with the number of methods that this run has."""
    count = len([e for e in estimates(view.results) if e != MAP and adapts(view, e)])
    words = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
    return caption.replace("five", words.get(count, str(count)))


def _of(view: View, caption: str) -> str:
    return f"{_counted(view, caption)}; {view.title}"


def _panel(view: View, title: str, torque: str, lines: list[Json]) -> Json:
    clutch = torque.partition(".")[0]
    return {"title": title, "traces": lines, "shades": figures.state_shades(view, clutch)}


def _errors(view: View) -> Json | None:
    known = {e: p for e, p in estimates(view.results).items() if e != MAP and adapts(view, e)}
    panels = []
    for torque, title in figures.TORQUE_TITLES.items():
        truth = f"plant.{torque}"
        if truth not in view.results:
            continue
        lines = [
            figures.trace(view, view.results[p + torque] - view.results[truth], _role(view, e),
                          label(view, e))
            for e, p in known.items() if p + torque in view.results
        ]  # fmt: skip
        symbol = title.partition(" ")[0]
        panels.append(_panel(view, f"error of {symbol} [N·m]", torque, lines))
    caption = "Error of the estimates: estimated less true torque, five methods"
    return figures.panelled("errors", view, panels, _counted(view, caption), _of(view, caption))


def _friction(view: View) -> Json | None:
    panels = []
    for clutch in CLUTCHES:
        known = friction.coefficients(view.results, clutch)
        lines = [figures.trace(view, known[r] * figures.KILO, r, n)
                 for r, n in (("truth", "true torque / (r N θ)"), ("map", "nominal μₙ·f"))
                 if r in known]  # fmt: skip
        lines += list(_coefficients(view, clutch, known))
        title = f"μ·f {figures.LABEL[clutch]} [kN/m]"
        panels.append(_panel(view, title, f"{clutch}.muF", lines))
    caption = "Friction coefficient times force per stroke, μ·f, five methods"
    return figures.panelled("friction", view, panels, _counted(view, caption), _of(view, caption))


def _coefficients(view: View, clutch: str, known: dict[str, np.ndarray]) -> list[Json]:
    """Return a line per method, blank where the clutch is not pressed."""
    pressed = np.isfinite(known["observer"]) if "observer" in known else True
    found = []
    for estimate, prefix in estimates(view.results).items():
        signal = f"{prefix}{clutch}.muF"
        if estimate != MAP and adapts(view, estimate) and signal in view.results:
            values = np.where(pressed, view.results[signal], np.nan) * figures.KILO
            found.append(figures.trace(view, values, _role(view, estimate), label(view, estimate)))
    return found
