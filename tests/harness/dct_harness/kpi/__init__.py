"""KPIs of a run: estimation errors, torque tracking, shift quality, and their limits.

KPIS.md beside this file lists each with formula, unit and source. A KPI whose signals a run
does not have is left out, so a supplier's plant without clutch states still gets the rest.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import asdict
from typing import Any

from ..results import Results
from . import estimation, handover, limits, shift, timing, tracking
from .registry import KPIS, Kpi
from .scopes import Phase, load_phases
from .table import format_table
from .tracking import compare_feedback

__all__ = [
    "KPIS", "Kpi", "Phase", "compare_feedback", "compute", "format_table", "load_phases", "reads",
]  # fmt: skip
WHOLE = (estimation, timing, tracking, shift)  # what has KPIs of the scenario as a whole
PARTS = (handover,)  # and what has none


def compute(results: Results, run: dict[str, Any], whole: bool = False) -> dict[str, Any]:
    """Compute all KPIs of one run.

    Parameters
    ----------
    results
        Signals in SI units, shape (n,) each.
    run
        Content of `run.json`.
    whole
        Of the scenario as a whole, as far as no limit is on a part of it: a third of the work.

    Returns
    -------
    dict
        `phases` (name, start, end [s]); `rows` (kpi, signal, estimate, scope, value, unit), scope
        being `scenario`, `phase/<name>`, `state/<name>` or the number of a lock-up or shift;
        `limits` (as rows, with relation, limit, pass); `verdict`.
    """
    whole = whole and limits.on_whole(run)
    phases = None if whole else load_phases(results, run)
    modules = WHOLE if whole else (*WHOLE, *PARTS)
    rows = [row.as_dict() for module in modules for row in module.rows(results, phases)]
    judged = limits.judge(run, rows)
    return {
        "phases": [asdict(phase) for phase in phases or ()], "rows": rows, "limits": judged,
        "verdict": limits.verdict(run, judged),
    }  # fmt: skip


def reads(known: Collection[str], run: dict[str, Any]) -> set[str]:
    """Return the signals that KPIs of the scenario as a whole are of, and those that limits need.

    `known`: names of all signals of a run; `run` as for `compute`.
    """
    modules = WHOLE if limits.on_whole(run) else (*WHOLE, *PARTS)
    return {name for module in modules for name in module.reads(known)}
