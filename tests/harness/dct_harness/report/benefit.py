"""What the estimates buy: KPIs of a run with feedback beside those of the run without."""

from __future__ import annotations

from typing import Any

from ..kpi import registry
from ..kpi.table import number, shown
from .cells import scope_label
from .runs import Pair

WHOLE = ("tracking.rms", "shift.jerkPeak", "shift.jerkRms", "shift.vibrationDose",
         "shift.frictionEnergy")  # fmt: skip
PER_SHIFT = ("shift.torqueHole", "shift.engineFlare", "shift.duration")
SIGNALS = {
    "clutches": "both clutches",
    "clutch1": "clutch 1",
    "clutch2": "clutch 2",
    "vehicle.acceleration": "vehicle",
}

Json = dict[str, Any]


def rows(pair: Pair) -> list[Json]:
    """Return title, what of, unit, both values and their ratio, in the order of the KPIs above."""
    with_it, without = (_values(view.kpis) for view in (pair.closed, pair.opened))
    keys = [(kpi, *where) for kpi in (*WHOLE, *PER_SHIFT) for k, *where in with_it if k == kpi]
    return [_row(with_it[key], without[key]) for key in map(tuple, keys) if key in without]


def overview(pairs: list[Pair]) -> Json | None:
    """Return one line per KPI and three cells per pair: with feedback, without, ratio."""
    found = [{(r["title"], r["of"], r["unit"]): r for r in rows(pair)} for pair in pairs]
    lines = [
        {"title": key[0], "of": key[1], "unit": key[2], "cells": [r.get(key) for r in found]}
        for key in dict.fromkeys(key for one in found for key in one)
    ]
    heads = [{"title": p.closed.base, "slug": p.closed.slug} for p in pairs]
    return {"heads": heads, "lines": lines} if lines else None


def _values(kpis: Json) -> dict[tuple[str, str, str], Json]:
    chosen = [r for r in kpis["rows"] if r["kpi"] in WHOLE and r["scope"] == "scenario"]
    chosen += [r for r in kpis["rows"] if r["kpi"] in PER_SHIFT and r["scope"].startswith("shift")]
    return {(r["kpi"], r["signal"], r["scope"]): r for r in chosen if r["value"] is not None}


def _row(closed: Json, opened: Json) -> Json:
    kpi = registry.BY_KEY[closed["kpi"]]
    of = SIGNALS.get(closed["signal"], closed["signal"].replace("clutch", ""))
    if closed["kpi"] in PER_SHIFT:
        of = f"{scope_label(closed['scope'])}, {of}"
    ratio = closed["value"] / opened["value"] if opened["value"] else None
    return {
        "title": kpi.title, "of": of, "unit": kpi.unit, "closed": shown(closed),
        "opened": shown(opened), "ratio": number(ratio, 2) if ratio is not None else "–",
        "worse": closed["value"] > opened["value"],
    }  # fmt: skip
