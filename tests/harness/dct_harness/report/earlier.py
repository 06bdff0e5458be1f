"""An earlier run beside a newer one: which KPIs, signals, parameters and FMUs changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..compare import Tolerances, compare
from ..errors import ConfigError, did_you_mean, instant
from ..kpi import registry
from ..kpi.table import UNDEFINED, shown
from ..kpi.typography import figure, pair, unit
from .runs import View, load

Json = dict[str, Any]
SIGNALS = 12  # the signals that changed most
CHANGE = 2  # digits of a change


def beside(views: list[View], run_dirs: Sequence[str | Path]) -> list[View]:
    """Return the views, each with the earlier run of the same system and feedback.

    Raises
    ------
    ConfigError
        An earlier run belongs to none of the views. Two single runs belong together always.
    """
    before = load(run_dirs)
    if len(views) == len(before) == 1:
        return [replace(views[0], earlier=before[0])]
    known = {(view.name, view.feedback) for view in views}
    for earlier in before:
        if (earlier.name, earlier.feedback) not in known:
            hint = did_you_mean(earlier.name, [view.name for view in views])
            raise ConfigError(f"--compare-to: no run of system '{earlier.name}' is shown.{hint}")
    by_name = {(earlier.name, earlier.feedback): earlier for earlier in before}
    return [replace(v, earlier=by_name.get((v.name, v.feedback))) for v in views]


def changes(view: View) -> Json | None:
    """Return what differs from the earlier run: `kpis`, `signals`, `facts`; None without one."""
    if view.earlier is None:
        return None
    outcomes = compare(view.earlier.results, view.results, Tolerances())
    differing = sorted((o for o in outcomes if not o.passed), key=lambda o: -(o.nrmse or 0))
    return {
        "view": view, "kpis": _kpis(view.earlier, view), "differing": len(differing),
        "signals": [_signal(o) for o in differing[:SIGNALS]], "compared": len(outcomes),
        "facts": _facts(view.earlier.run, view.run),
    }  # fmt: skip


def _key(row: Json) -> tuple[str, str, str, str]:
    return row["kpi"], row["signal"], row["estimate"], row["scope"]


def _kpis(before: View, now: View) -> list[Json]:
    """Return the KPIs over the whole scenario whose shown values differ."""
    old = {_key(row): row for row in before.kpis["rows"]}
    found = []
    for row in now.kpis["rows"]:
        if row["scope"].startswith(("phase/", "state/", "event/")) or _key(row) not in old:
            continue
        was = old[_key(row)]
        if shown(was) != shown(row):
            kpi = registry.BY_KEY[row["kpi"]]
            signal = " ".join(part for part in (row["signal"], row["estimate"]) if part)
            found.append({"title": kpi.title, "signal": signal, "scope": row["scope"],
                          "was": shown(was), "now": shown(row), "unit": kpi.unit,
                          "change": _percent(was["value"], row["value"])})  # fmt: skip
    return found


def _percent(was: float | None, now: float | None) -> str:
    if not was or now is None:
        return UNDEFINED
    change = figure(100 * (now - was) / abs(was), CHANGE)
    return f"{'' if change.startswith('−') else '+'}{change} %"


def _signal(outcome: Any) -> Json:
    was, now = pair(outcome.reference, outcome.value)
    return {"name": outcome.name, "unit": unit(outcome.unit), "was": was, "now": now,
            "at": UNDEFINED if outcome.time is None else instant(outcome.time),
            "nrmse": figure(outcome.nrmse, CHANGE),
            "reason": "" if outcome.time is not None else outcome.reason}  # fmt: skip


def _facts(before: Json, now: Json) -> list[Json]:
    """Return parameters, FMUs and versions that differ."""
    old, new = _flat(before), _flat(now)
    names = sorted(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
    return [{"name": n, "was": old.get(n, UNDEFINED), "now": new.get(n, UNDEFINED)} for n in names]


def _flat(run: Json) -> dict[str, str]:
    """Return what defines a run, one line each."""
    found = {f"{c}.{n}": str(p.get("item", p["value"]))
             for c, part in run.get("parameters", {}).items() for n, p in part.items()}  # fmt: skip
    for component, fmu in run.get("fmus", {}).items():
        found |= {f"{component}: {key}": str(fmu[key]) for key in ("guid", "sha256") if key in fmu}
    found |= {key: str(run[key]) for key in ("step", "stop", "status") if key in run}
    return found | {n: str(text) for n, text in run.get("environment", {}).items()}
