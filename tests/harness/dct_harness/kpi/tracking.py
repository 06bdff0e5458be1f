"""How well a clutch torque follows its request while the clutch slips."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from ..results import Results
from . import registry
from .rows import Row, rms
from .scopes import CLUTCHES, SCENARIO, Phase, clutch_state, phase_masks, states

BOTH = "clutches"


def reads(known: Collection[str]) -> Iterator[str]:
    """Yield which of the known signals `rows` may read."""
    yield from states(known)
    yield from (name for clutch in CLUTCHES for name in _ends(clutch) if name in known)


def _ends(clutch: str) -> tuple[str, str]:
    """Return the names of a request and of the torque that is to follow it."""
    return f"scenario.{clutch}.torqueRequest", f"plant.{clutch}.torque"


def error(results: Results, clutch: str) -> np.ndarray | None:
    """Return |T_c| − request [N·m], shape (n,), NaN unless the clutch slips; None if unknown."""
    request, torque = _ends(clutch)
    state = clutch_state(results, clutch)
    if state is None or request not in results or torque not in results:
        return None
    return np.where(state == 2, np.abs(results[torque]) - results[request], np.nan)


def rows(results: Results, phases: list[Phase] | None) -> Iterator[Row]:
    """Yield the tracking error per clutch and of both together, per phase."""
    errors = {c: e for c in CLUTCHES if (e := error(results, c)) is not None}
    if len(errors) > 1:
        errors[BOTH] = np.stack(list(errors.values()), axis=1)
    for signal, values in errors.items():
        for scope, mask in phase_masks(results.time, phases or []).items():
            inside = values[mask]
            inside = inside[np.isfinite(inside)]
            if inside.size:
                yield Row(registry.TRACKING, signal, scope, rms(inside))


def feedback(results: Results) -> bool | None:
    """Return whether a run closed the loop through the estimates; None if it has no control."""
    control = results.run.get("system", {}).get("components", {}).get("control")
    value = (control or {}).get("parameters", {}).get("feedback.enabled")
    return bool(value) if value is not None else None


def compare_feedback(with_it: dict[str, Any], without: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the ratio of tracking errors with and without feedback, per clutch.

    Both arguments are results of `compute`; the ratio is taken over the whole scenario.
    """
    closed, opened = _whole(with_it), _whole(without)
    pairs = [(s, closed[s], opened[s]) for s in closed if opened.get(s)]
    found = [Row(registry.FEEDBACK_RATIO, s, SCENARIO, a / b) for s, a, b in pairs]
    return [row.as_dict() for row in found]


def _whole(kpis: dict[str, Any]) -> dict[str, float]:
    key = registry.TRACKING.key
    chosen = (r for r in kpis["rows"] if r["kpi"] == key and r["scope"] == SCENARIO)
    return {r["signal"]: r["value"] for r in chosen}
