"""KPIs as an aligned table for a terminal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import limits, registry, side_by_side
from .estimation import ESTIMATES, OBSERVER, TORQUES

UNDEFINED = "–"
ERROR_KEYS = {kpi.key for kpi in registry.ERRORS}


def number(value: float | None, digits: int) -> str:
    """Return `value` with `digits` significant digits, without an exponent."""
    if value is None:
        return UNDEFINED
    if value == 0:
        return "0"
    return f"{value:.{max(0, digits - 1 - _exponent(value, digits))}f}"


def _exponent(value: float, digits: int) -> int:
    """Return the decimal exponent after rounding to `digits` (9.996 rounds up to 10.0)."""
    return int(f"{value:.{digits - 1}e}".partition("e")[2])


def shown(row: dict[str, Any]) -> str:
    """Return the formatted value of a row of `kpis.json`, without its unit."""
    kpi, value = registry.BY_KEY[row["kpi"]], row["value"]
    if value is not None and 0 < abs(value) < kpi.least:
        return f"<{kpi.least:g}"
    if value is not None and value > kpi.most:
        return f">{kpi.most:g}"
    return number(value, kpi.digits)


def estimation_cells(kpis: dict[str, Any]) -> list[list[str]]:
    """Return torque, scope, then RMSE, max, % of both estimates, and their ratio, per scope."""
    values = {(r["signal"], r["scope"], r["kpi"], r["estimate"]): shown(r) for r in kpis["rows"]}
    places = dict.fromkeys((s, c) for s, c, k, _ in values if k == registry.RMSE.key)
    columns = [(k.key, e) for e in ESTIMATES
               for k in (registry.RMSE, registry.MAX_ABS, registry.PERCENT)]  # fmt: skip
    columns.append((registry.RATIO.key, ""))
    return [
        [TORQUES[signal], scope, *(values.get((signal, scope, *c), UNDEFINED) for c in columns)]
        for signal, scope in places
    ]


def other_cells(kpis: dict[str, Any]) -> list[list[str]]:
    """Return KPI title, signal, scope, value, unit of all that is in no table of errors."""
    return [
        [registry.BY_KEY[r["kpi"]].title, r["signal"], r["scope"], shown(r), r["unit"]]
        for r in kpis["rows"] if r["kpi"] not in ERROR_KEYS and r["estimate"] in ("", OBSERVER)
    ]  # fmt: skip


def method_cells(kpis: dict[str, Any]) -> list[list[str]]:
    """Return each estimate with its errors over the scenario; empty for a single observer."""
    if not side_by_side.others(kpis):
        return []
    return [
        [estimate, *(UNDEFINED if row is None else shown(row) for row in rows)]
        for estimate, rows in side_by_side.lines(kpis).items()
    ]


def _method_head(kpis: dict[str, Any]) -> list[str]:
    names = [TORQUES[torque] for torque in side_by_side.torques(kpis)]
    return ["estimate", *(f"{name} {f}" for name in names for f in side_by_side.FIGURES)]


def limit_cells(judged: list[dict[str, Any]]) -> list[list[str]]:
    """Return KPI title, signal, scope, value, limit, verdict of each limit."""
    return [
        [registry.BY_KEY[j["kpi"]].title, of(j), j["scope"], _with_unit(shown(j), j),
         _with_unit(f"{j['relation']} {j['limit']:g}", j), "pass" if j["pass"] else "FAIL"]
        for j in judged
    ]  # fmt: skip


def of(row: dict[str, Any]) -> str:
    """Return the signal of a row, and whose estimate of it where that is told."""
    return " ".join(filter(None, (row["signal"], row["estimate"])))


def _with_unit(text: str, row: dict[str, Any]) -> str:
    return text if row["unit"] == "1" else f"{text} {row['unit']}"


ESTIMATION_HEAD = [
    "torque", "scope", "obs RMSE", "obs max", "obs %", "map RMSE", "map max", "map %", "map/obs"
]  # fmt: skip
ESTIMATION_TOLD = ("errors of the observer (obs) and of the map-based estimate (map): "
                   "RMSE, max [N·m], % of the RMS torque")  # fmt: skip
UNDEFINED_TOLD = ("–: not defined in this run, as where a torque is 0 or an event does not happen; "
                  "such a limit is missed")  # fmt: skip
OTHER_HEAD = ["KPI", "signal", "scope", "value", "unit"]
LIMIT_HEAD = ["limit on", "signal", "scope", "value", "limit", "verdict"]


def format_table(kpis: dict[str, Any]) -> str:
    """Return all KPIs of `compute` as aligned text: estimates [N·m, %], the rest, the limits."""
    estimates = aligned(ESTIMATION_HEAD, estimation_cells(kpis), lambda k: k > 1)
    parts = [
        f"{ESTIMATION_TOLD}\n{estimates}" if estimates else "",
        aligned(_method_head(kpis), method_cells(kpis), lambda k: k > 0),
        aligned(OTHER_HEAD, other_cells(kpis), lambda k: k == 3),
        aligned(LIMIT_HEAD, limit_cells(kpis["limits"]), lambda k: k in (3, 4)),
        UNDEFINED_TOLD if any(j["value"] is None for j in kpis["limits"]) else "",
        "\n".join(limits.of_nothing(kpis["limits"], kpis["rows"])),
        f"verdict: {kpis['verdict']}",
    ]
    return "\n\n".join(part for part in parts if part)


def aligned(head: list[str], rows: list[list[str]], right: Callable[[int], bool]) -> str:
    """Return a table for a terminal; `right` says which columns are numbers."""
    if not rows:
        return ""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]

    def line(cells: list[str]) -> str:
        pairs = enumerate(zip(cells, widths, strict=True))
        return "  ".join(c.rjust(w) if right(k) else c.ljust(w) for k, (c, w) in pairs).rstrip()

    return "\n".join([line(head), line(["-" * w for w in widths]), *map(line, rows)])
