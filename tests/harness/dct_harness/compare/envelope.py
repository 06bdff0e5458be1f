"""Lower and upper bound of a signal over a sliding window of time."""

from __future__ import annotations

import numpy as np

SLACK = 1e-9  # of the mean step: times that differ by rounding are the same


def bounds(
    time: np.ndarray, values: np.ndarray, at: np.ndarray, tube: float, held: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and largest value within `tube` [s] of each time of `at`.

    `time` and `values` have shape (n,), `at` and both results shape (m,). A held signal keeps
    its value up to the next sample; others are linear between samples.
    """
    slack = SLACK * (time[-1] - time[0]) / max(len(time) - 1, 1)
    if held:
        first, last = (_held(time, t) for t in (at - tube + slack, at + tube + slack))
        return _extreme(values, first, last, np.minimum), _extreme(values, first, last, np.maximum)
    ends = np.interp([at - tube, at + tube], time, values)
    low, high = ends.min(axis=0), ends.max(axis=0)
    if tube > 0:
        first = np.searchsorted(time, at - tube - slack)
        last = np.searchsorted(time, at + tube + slack, side="right") - 1
        some = first <= last
        first, last = np.where(some, first, 0), np.where(some, last, 0)
        low = np.where(some, np.minimum(low, _extreme(values, first, last, np.minimum)), low)
        high = np.where(some, np.maximum(high, _extreme(values, first, last, np.maximum)), high)
    return low, high


def _held(time: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return the index of the last sample at or before each time."""
    return np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 1)


def _extreme(
    values: np.ndarray, first: np.ndarray, last: np.ndarray, choose: np.ufunc
) -> np.ndarray:
    """Return the extreme of `values[first..last]`, both ends in, by a table of powers of two."""
    rows = [values]
    while 2 ** len(rows) <= len(values):
        half = 2 ** (len(rows) - 1)
        rows.append(choose(rows[-1][:-half], rows[-1][half:]))
    level = np.frexp(last - first + 1.0)[1] - 1  # 2^level is the longest that fits
    found = np.empty(len(first))
    for k in np.unique(level):
        mine = level == k
        found[mine] = choose(rows[k][first[mine]], rows[k][last[mine] - 2**k + 1])
    return found
