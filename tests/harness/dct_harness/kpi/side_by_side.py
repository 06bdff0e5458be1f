"""All estimates of a run side by side: one line per method, the same figures per torque."""

from __future__ import annotations

from typing import Any

from . import registry
from .estimation import ESTIMATES, MAP, OBSERVER, TORQUES
from .scopes import SCENARIO

FIGURES = {
    "%": registry.PERCENT.key, "RMSE": registry.RMSE.key, "max": registry.MAX_ABS.key,
    "late [s]": registry.LATENCY.key,
}  # fmt: skip

Json = dict[str, Any]


def others(kpis: Json) -> list[str]:
    """Return the estimates beside the observer's and the map's; empty in most runs."""
    names = dict.fromkeys(row["estimate"] for row in kpis["rows"])
    return [name for name in names if name and name not in ESTIMATES]


def torques(kpis: Json) -> list[str]:
    """Return the torques that the run has errors of."""
    known = {row["signal"] for row in kpis["rows"] if row["kpi"] == registry.RMSE.key}
    return [torque for torque in TORQUES if torque in known]


def lines(kpis: Json, scope: str = SCENARIO) -> dict[str, list[Json | None]]:
    """Return estimate -> rows of `FIGURES` torque by torque; the map last, it has no latency."""
    values = {
        (r["estimate"], r["signal"], r["kpi"]): r for r in kpis["rows"] if r["scope"] == scope
    }
    order = [e for e in (OBSERVER, *others(kpis), MAP) if any(key[0] == e for key in values)]
    return {e: [values.get((e, t, k)) for t in torques(kpis) for k in FIGURES.values()]
            for e in order}  # fmt: skip
