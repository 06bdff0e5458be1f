"""Cells of the page's tables: KPIs as matrix and list, limits, parameters, identities."""

from __future__ import annotations

from typing import Any

from ..kpi import registry
from ..kpi.estimation import TORQUES
from ..kpi.table import ERROR_KEYS, ESTIMATION_HEAD, UNDEFINED, estimation_cells, number, of, shown
from .runs import View

Json = dict[str, Any]
HTML_SYMBOL = {"T_c1": "T<sub>c1</sub>", "T_c2": "T<sub>c2</sub>", "T_o": "T<sub>o</sub>"}
MATRIX = (
    ("RMSE", registry.RMSE.key, "observer"), ("max", registry.MAX_ABS.key, "observer"),
    ("%", registry.PERCENT.key, "observer"), ("map %", registry.PERCENT.key, "mapBased"),
    ("map/obs", registry.RATIO.key, ""),
)  # fmt: skip


def matrix(view: View) -> Json | None:
    """Return the estimation KPIs: a row per scope, five columns per torque."""
    rows = [r for r in view.kpis["rows"] if r["kpi"] in ERROR_KEYS]
    if not rows:
        return None
    values: dict[tuple[str, ...], Json] = {
        (r["scope"], r["signal"], r["kpi"], r["estimate"]): r for r in rows
    }
    for place, row in values.items():
        if row["kpi"] == registry.RATIO.key and _is_idle(values, *place[:2]):
            values[place] = row | {"value": None}
    torques = [t for t in TORQUES if any(r["signal"] == t for r in rows)]
    order = {"scenario": 0, "phase": 1, "state": 2}
    scopes = sorted(dict.fromkeys(r["scope"] for r in rows), key=lambda s: order[group(s)])
    table = [
        {"scope": scope_label(scope), "group": group(scope), "cells": [
            _cell(values.get((scope, torque, key, estimate)))
            for torque in torques for _, key, estimate in MATRIX]}
        for scope in scopes
    ]  # fmt: skip
    return {"torques": [HTML_SYMBOL[TORQUES[t]] for t in torques],
            "columns": [head for head, _, _ in MATRIX], "rows": table}  # fmt: skip


def _is_idle(values: dict[tuple[str, ...], Json], scope: str, torque: str) -> bool:
    """Whether both errors of a torque are below what is shown, as those of an open clutch."""
    key, least = registry.RMSE.key, registry.RMSE.least
    errors = [row["value"] for estimate in ("observer", "mapBased")
              if (row := values.get((scope, torque, key, estimate)))]  # fmt: skip
    return all(error is not None and error < least for error in errors)


def full(view: View) -> Json:
    """Return head and rows of all estimation KPIs, the map's RMSE and maximum included."""
    rows = estimation_cells(view.kpis)
    return {"head": ESTIMATION_HEAD, "rows": [
        [HTML_SYMBOL[torque], scope_label(scope), *cells] for torque, scope, *cells in rows
    ]}  # fmt: skip


def _cell(row: Json | None) -> Json:
    """Return text and whether the observer does worse than the map here."""
    if row is None:
        return {"text": UNDEFINED, "worse": False}
    worse = row["kpi"] == registry.RATIO.key and row["value"] is not None and row["value"] < 1
    return {"text": shown(row), "worse": worse}


def group(scope: str) -> str:
    """Return `scenario`, `phase` or `state`."""
    return scope.partition("/")[0]


def scope_label(scope: str) -> str:
    """Return what people call a scope."""
    return "whole scenario" if scope == "scenario" else scope.partition("/")[2] or scope


def other_rows(view: View) -> list[Json]:
    """Return timing, tracking and shift-quality KPIs with their phases side by side."""
    found: dict[tuple[str, str], Json] = {}
    for row in view.kpis["rows"]:
        if row["kpi"] in ERROR_KEYS:
            continue
        kpi = registry.BY_KEY[row["kpi"]]
        line = found.setdefault(
            (row["kpi"], row["signal"]),
            {"title": kpi.title, "signal": row["signal"], "unit": kpi.unit, "values": []},
        )
        line["values"].append((scope_label(row["scope"]), shown(row)))
    return list(found.values())


def limit_rows(judged: list[tuple[View, Json]]) -> list[Json]:
    """Return every limit with the run it judges."""
    return [
        {"run": view.title, "slug": view.slug, "title": registry.BY_KEY[j["kpi"]].title,
         "signal": of(j), "value": shown(j),
         "unit": "" if j["unit"] == "1" else j["unit"],
         "bound": f"{'≤' if j['relation'] == '<=' else '≥'} {j['limit']:g}",
         "scope": scope_label(j["scope"]), "pass": j["pass"]}
        for view, j in judged
    ]  # fmt: skip


def headline(view: View) -> list[Json]:
    """Return per torque the observer's and the map's error and their ratio, as texts."""
    rows = [r for r in view.kpis["rows"] if r["scope"] == "scenario"]
    values = {(r["signal"], r["kpi"], r["estimate"]): r for r in rows}
    percent, ratio = registry.PERCENT.key, registry.RATIO.key
    return [
        {"observer": _told(values.get((torque, percent, "observer")), " %"),
         "map": _told(values.get((torque, percent, "mapBased")), " %"),
         "ratio": _told(values.get((torque, ratio, "")), " ×", 2)}
        for torque in TORQUES
    ]  # fmt: skip


def _told(row: Json | None, unit: str, digits: int | None = None) -> str:
    if row is None or row["value"] is None:
        return UNDEFINED
    return (shown(row) if digits is None else number(row["value"], digits)) + unit


def tracking(view: View) -> str | None:
    """Return the tracking error of both clutches while slipping [N·m]; None without requests."""
    row = next((r for r in view.kpis["rows"] if r["kpi"] == registry.TRACKING.key
                and (r["signal"], r["scope"]) == ("clutches", "scenario")), None)  # fmt: skip
    return None if row is None else shown(row)


def parameters(views: list[View]) -> list[Json]:
    """Return the parameters that a system file or the command line set, a column per run."""
    sets = [
        {f"{c}.{n}": v for c, part in view.run.get("system", {}).get("components", {}).items()
         for n, v in part.get("parameters", {}).items()}
        for view in views
    ]  # fmt: skip
    names = sorted({name for values in sets for name in values})
    return [{"name": n, "values": [_literal(values.get(n)) for values in sets]} for n in names]


def effective(views: list[View]) -> list[Json]:
    """Return every parameter of every FMU with its unit; one value where all runs agree."""
    runs = [
        {f"{c}.{n}": p for c, part in view.run.get("parameters", {}).items()
         for n, p in part.items()}
        for view in views
    ]  # fmt: skip
    found = []
    for name in dict.fromkeys(name for run in runs for name in run):
        values = [_literal(run[name].get("item", run[name]["value"])) if name in run else UNDEFINED
                  for run in runs]  # fmt: skip
        unit = next(run[name]["unit"] for run in runs if name in run)
        same = len(set(values)) == 1
        found.append({"name": name, "unit": unit, "values": values[:1] if same else values})
    return found


def _literal(value: Any) -> str:
    if value is None:
        return UNDEFINED
    return str(value).lower() if isinstance(value, bool) else str(value)


def identities(views: list[View]) -> list[Json]:
    """Return each FMU once, with the runs and components it served."""
    found: dict[tuple[str, str], Json] = {}
    for view in views:
        for component, fmu in view.run.get("fmus", {}).items():
            key = (component, fmu.get("sha256", ""))
            found.setdefault(key, {"component": component, **fmu, "runs": []})
            found[key]["runs"].append(view.title)
    return list(found.values())
