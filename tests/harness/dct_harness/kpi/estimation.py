"""Errors of the observer's and the map-based torque estimates against the plant's truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..results import Results
from . import registry
from .rows import Row, rms
from .scopes import Phase, phase_masks, state_masks

TORQUES = {"clutch1.torque": "T_c1", "clutch2.torque": "T_c2", "driveShaft.torque": "T_o"}
ESTIMATES = {"observer": "observer.", "mapBased": "observer.mapBased."}


def rows(results: Results, phases: list[Phase]) -> Iterator[Row]:
    """Yield the estimation KPIs of every torque, estimate and scope that the run has."""
    for torque in TORQUES:
        if f"plant.{torque}" not in results:
            continue
        scopes = phase_masks(results.time, phases) | state_masks(results, torque)
        for scope, mask in scopes.items():
            yield from _scope(results, torque, scope, mask)


def _scope(results: Results, torque: str, scope: str, mask: np.ndarray) -> Iterator[Row]:
    truth = results[f"plant.{torque}"]
    whole = rms(truth)
    errors = {}
    for estimate, prefix in ESTIMATES.items():
        if prefix + torque not in results:
            continue
        error = (results[prefix + torque] - truth)[mask]
        errors[estimate] = rms(error)
        percent = 100 * errors[estimate] / whole if whole > 0 else None
        yield Row(registry.RMSE, torque, scope, errors[estimate], estimate)
        yield Row(registry.MAX_ABS, torque, scope, float(np.abs(error).max()), estimate)
        yield Row(registry.PERCENT, torque, scope, percent, estimate)
    if len(errors) == len(ESTIMATES):
        better = errors["observer"]
        yield Row(registry.RATIO, torque, scope, errors["mapBased"] / better if better else None)
