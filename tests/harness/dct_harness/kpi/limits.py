"""Limits on KPIs (`[[kpis]]` of the system file) and the verdict of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..errors import did_you_mean
from . import registry
from .scopes import SCENARIO

RELATIONS: dict[str, tuple[str, Callable[[float, float], bool]]] = {
    "max": ("<=", lambda value, limit: value <= limit),
    "min": (">=", lambda value, limit: value >= limit),
}


def judge(run: dict[str, Any], rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return each limit of the system with the value it meets.

    A limit on a KPI that only a pair of runs has (feedback on and off) is judged when `rows`
    holds that KPI. A value that is missing or undefined does not pass.
    """
    return [
        _judged(limit, rows)
        for limit in run.get("system", {}).get("kpis", [])
        if (limit["kpi"] == registry.FEEDBACK_RATIO.key) == _paired(rows)
    ]


def on_whole(run: dict[str, Any]) -> bool:
    """Return whether every limit is on the scenario as a whole."""
    given = run.get("system", {}).get("kpis", [])
    return all(limit.get("scope", SCENARIO) == SCENARIO for limit in given)


def _paired(rows: list[dict[str, Any]]) -> bool:
    return any(row["kpi"] == registry.FEEDBACK_RATIO.key for row in rows)


def _judged(limit: dict[str, Any], rows: list[dict[str, Any]]) -> dict[str, Any]:
    what = {"kpi": limit["kpi"], "signal": limit["signal"], "estimate": limit.get("estimate", ""),
            "scope": limit.get("scope", SCENARIO)}  # fmt: skip
    value = next((r["value"] for r in rows if all(r[k] == what[k] for k in what)), None)
    side = "max" if "max" in limit else "min"
    sign, holds = RELATIONS[side]
    return {
        **what, "relation": sign, "limit": limit[side], "value": value,
        "unit": registry.BY_KEY[limit["kpi"]].unit,
        "pass": value is not None and holds(value, limit[side]),
    }  # fmt: skip


def of_nothing(judged: list[dict[str, Any]], rows: list[dict[str, Any]]) -> list[str]:
    """Return a sentence for each limit on a signal of which this run has no such KPI."""
    told = []
    for limit in judged:
        signals = sorted({r["signal"] for r in rows if r["kpi"] == limit["kpi"]})
        if signals and limit["signal"] not in signals:
            hint = did_you_mean(limit["signal"], signals)
            what = f"{limit['kpi']} is not computed of '{limit['signal']}'"
            told.append(f"{what} here, but of {', '.join(signals)}.{hint}")
    return told


def verdict(run: dict[str, Any], judged: list[dict[str, Any]]) -> str:
    """Return `pass`, `fail`, or `not judged` where no limit is set; a partial run fails."""
    if run.get("status") == "partial":
        return "fail"
    if not judged:
        return "not judged"
    return "pass" if all(limit["pass"] for limit in judged) else "fail"
