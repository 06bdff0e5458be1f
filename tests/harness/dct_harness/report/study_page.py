"""Page of a study: where each estimate breaks, what that depends on, and the worst runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..kpi.table import number
from . import study_figures
from .study_data import Json, Series, Shown, StudyData, pairs
from .study_numbers import crossing, sensitivity, summary

WORST = 3  # runs per KPI and series
BAND_RUNS = 400  # whose courses the bands are made of, at most
TEMPLATE = "study.html.j2"


def context(folder: Path, title: str = "") -> Json:
    """Return all that the template shows of a study's folder."""
    data = StudyData.read(folder)
    sections = [_section(data, shown) for shown in data.shown]
    drawn = [f for section in sections for f in section["figures"]]
    courses = study_figures.courses(data, BAND_RUNS)
    return {
        "title": title or data.plan["title"], "plan": data.plan, "data": data,
        "sections": sections, "courses": courses, "figures": [*drawn, *courses],
        "failed": data.failed, "number": number, "level": level,
        "factors": [_factor(f) for f in data.factors], "axes": data.plan["axes"],
    }  # fmt: skip


def _section(data: StudyData, shown: Shown) -> Json:
    """Return a KPI with its tables and figures."""
    made = [study_figures.curves(data, shown)] if data.factors else []
    made += [study_figures.heats(data, shown, pair) for pair in pairs(data.plan)]
    known = [(s, found) for s in shown.series if (found := sensitivity(data, s)) is not None]
    if known:
        made.append(study_figures.sensitivities(data, shown, known))
    return {
        "shown": shown, "figures": made,
        "summary": [summary(shown, s) for s in shown.series],
        "breaks": [_breaks(data, shown, s) for s in shown.series] if shown.limit else [],
        "worst": [case for s in shown.series for case in _worst(data, shown, s)],
    }  # fmt: skip


def _breaks(data: StudyData, shown: Shown, series: Series) -> Json:
    """Return where the median of a series passes the limit, per factor."""
    cells = []
    for factor in data.factors:
        cells.append(crossing(shown, data.column(factor["name"])[series.rows], series.values))
    return {"label": series.label, "cells": cells}


def _worst(data: StudyData, shown: Shown, series: Series) -> list[Json]:
    """Return the worst runs of a series with their factors and the command that repeats them."""
    found = []
    for k in shown.worst_first(series.values)[:WORST]:
        row = data.rows[int(series.rows[k])]
        found.append({"label": series.label, "run": row["run"], "value": float(series.values[k]),
                      "factors": [level(f, row.get(f["name"])) for f in data.factors],
                      "command": row.get("command", "")})  # fmt: skip
    return found


def level(factor: Json, value: float | None) -> str:
    """Return the value of a factor in a run; whole numbers, as seeds, with all their digits."""
    if factor.get("whole") and value is not None:
        return f"{value:.0f}"
    return number(value, 3)


def _factor(factor: Json) -> Json:
    """Return a factor as the page describes it."""
    inside: Any = ", ".join(f"{x:g}" for x in factor["given"])
    return {**factor, "drawn": f"{factor['kind']}({inside})"}
