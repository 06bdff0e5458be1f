"""Limits on KPIs (limits.csv beside this file) and the verdict of a run."""

from __future__ import annotations

import csv
from importlib import resources
from typing import Any

from . import registry
from .scopes import SCENARIO

RELATIONS = {"<=": lambda value, limit: value <= limit, ">=": lambda value, limit: value >= limit}


def judge(run: dict[str, Any], rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return each limit that holds for this system and step with the value it meets.

    A limit on a KPI that only a pair of runs has (feedback on and off) is judged when `rows`
    holds that KPI. A value that is missing or undefined does not pass.
    """
    name = run.get("system", {}).get("name")
    return [
        _judged(limit, rows)
        for limit in _table()
        if limit["system"] == name
        and float(limit["step"]) == run.get("step")
        and (limit["kpi"] == registry.FEEDBACK_RATIO.key) == _paired(rows)
    ]


def _paired(rows: list[dict[str, Any]]) -> bool:
    return any(row["kpi"] == registry.FEEDBACK_RATIO.key for row in rows)


def _table() -> list[dict[str, str]]:
    text = resources.files(__package__).joinpath("limits.csv").read_text("utf-8")
    return list(csv.DictReader(text.splitlines()))


def _judged(limit: dict[str, str], rows: list[dict[str, Any]]) -> dict[str, Any]:
    same = [
        r["value"] for r in rows
        if r["scope"] == SCENARIO and all(r[k] == limit[k] for k in ("kpi", "signal", "estimate"))
    ]  # fmt: skip
    value = same[0] if same else None
    bound = float(limit["limit"])
    return {
        "kpi": limit["kpi"], "signal": limit["signal"], "estimate": limit["estimate"],
        "relation": limit["relation"], "limit": bound, "condition": limit["condition"],
        "value": value, "unit": registry.BY_KEY[limit["kpi"]].unit,
        "pass": value is not None and RELATIONS[limit["relation"]](value, bound),
    }  # fmt: skip


def verdict(run: dict[str, Any], judged: list[dict[str, Any]]) -> str:
    """Return `pass`, `fail`, or `not judged` where no limit is set; a partial run fails."""
    if run.get("status") == "partial":
        return "fail"
    if not judged:
        return "not judged"
    return "pass" if all(limit["pass"] for limit in judged) else "fail"
