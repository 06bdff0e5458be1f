"""Fewer points for plotting, without losing a peak (M4: first, minimum, maximum, last)."""

from __future__ import annotations

import base64
import itertools
from typing import Any

import numpy as np

BINS = 900  # one bin per pixel column of a laptop-wide panel


def m4(values: np.ndarray, bins: int = BINS) -> np.ndarray:
    """Return indices, ascending, that keep what a plot of `values`, shape (n,), shows.

    Each of `bins` equal stretches keeps its first, smallest, largest and last sample; where
    values are NaN the gap stays. Flat stretches keep their ends only.
    """
    count = len(values)
    edges = np.linspace(0, count, min(bins, count) + 1).astype(int)
    kept = [_extremes(values, a, b) for a, b in itertools.pairwise(edges)]
    index = np.unique(np.concatenate(kept)) if kept else np.arange(0)
    return index[_bends(values[index])]


def _extremes(values: np.ndarray, a: int, b: int) -> np.ndarray:
    """Return first, minimum, maximum, last of a stretch, and the ends of NaN gaps in it."""
    part = values[a:b]
    missing = np.isnan(part)
    ends = np.flatnonzero(np.diff(missing))
    picks = [0, len(part) - 1, *ends, *(ends + 1)]
    if not missing.all():
        picks += [int(np.nanargmin(part)), int(np.nanargmax(part))]
    return a + np.array(picks)


def _bends(values: np.ndarray) -> np.ndarray:
    """Return a mask of points that are not inside a flat stretch or a NaN gap."""
    keep = np.ones(len(values), dtype=bool)
    if len(values) > 2:
        same = (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
        keep[1:-1] = ~(same[1:] & same[:-1])
    return keep


def pack(values: np.ndarray) -> dict[str, Any]:
    """Return single-precision values as plotly.js reads them from JSON (base64)."""
    raw = np.ascontiguousarray(values, dtype="<f4").tobytes()
    return {"dtype": "f4", "bdata": base64.b64encode(raw).decode("ascii")}
