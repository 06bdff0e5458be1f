"""Errors of all torque estimates of a run against the plant's truth.

Beside the component `observer` and its map-based estimate, every other component that tells the
torques counts by its own name: several methods side by side at one plant.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from ..results import Results
from . import registry
from .rows import Row, rms
from .scopes import Phase, masks

TORQUES = {"clutch1.torque": "T_c1", "clutch2.torque": "T_c2", "driveShaft.torque": "T_o"}
OBSERVER, MAP = "observer", "mapBased"
ESTIMATES = {OBSERVER: "observer.", MAP: "observer.mapBased."}
PLANT = "plant"


def estimates(results: Results) -> dict[str, str]:
    """Return estimate -> prefix of its signals: observer, map, then other components by name."""
    found = {name: prefix for name, prefix in ESTIMATES.items() if _tells(results, prefix)}
    parts = dict.fromkeys(name.partition(".")[0] for name in results.signals)
    others = (c for c in parts if c not in (PLANT, OBSERVER) and _tells(results, f"{c}."))
    return found | {c: f"{c}." for c in others}


def _tells(results: Results, prefix: str) -> bool:
    return any(prefix + torque in results for torque in TORQUES)


def reads(known: Collection[str]) -> Iterator[str]:
    """Yield which of the known signals `rows` may read."""
    for name in known:
        if name.removeprefix(ESTIMATES[MAP]) in TORQUES or name.partition(".")[2] in TORQUES:
            yield name


def rows(results: Results, phases: list[Phase] | None) -> Iterator[Row]:
    """Yield the estimation KPIs of every torque, estimate and scope that the run has."""
    known = estimates(results)
    for torque in TORQUES:
        if f"plant.{torque}" not in results:
            continue
        found = {e: results[p + torque] for e, p in known.items() if p + torque in results}
        truth = results[f"plant.{torque}"]
        whole, errors = rms(truth), {e: values - truth for e, values in found.items()}
        for scope, mask in masks(results, torque, phases).items():
            inside = {e: error[mask] for e, error in errors.items()}
            yield from _scope(whole, inside, torque, scope)


def _scope(whole: float, found: dict[str, np.ndarray], torque: str, scope: str) -> Iterator[Row]:
    """Yield the errors within a scope; `whole`: RMS of the torque over the scenario."""
    errors = {}
    for estimate, difference in found.items():
        errors[estimate] = rms(difference)
        percent = 100 * errors[estimate] / whole if whole > 0 else None
        yield Row(registry.RMSE, torque, scope, errors[estimate], estimate)
        yield Row(registry.MAX_ABS, torque, scope, float(np.abs(difference).max()), estimate)
        yield Row(registry.PERCENT, torque, scope, percent, estimate)
    for estimate, error in errors.items():
        if estimate != MAP and MAP in errors:
            name = "" if estimate == OBSERVER else estimate
            ratio = errors[MAP] / error if error else None
            yield Row(registry.RATIO, torque, scope, ratio, name)
