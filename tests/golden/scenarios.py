"""Scenario knots as inputs of the plant: held per communication step, or continuous."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

COLUMNS = ("engine.torque", "clutch1.position", "clutch2.position", "road.grade", "brake.torque")


@dataclass(frozen=True)
class Scenario:
    """Knots, linear between and constant outside; `values` has one column per `COLUMNS`, SI."""

    times: np.ndarray
    values: np.ndarray

    @classmethod
    def from_signals(cls, signals):
        """Join signals with knots of their own, each a list of (t [s], value)."""
        tables = [np.array(signals.get(name, [(0, 0)]), dtype=float) for name in COLUMNS]
        times = np.unique(np.concatenate([t[:, 0] for t in tables]))
        values = [np.interp(times, t[:, 0], t[:, 1]) for t in tables]
        return cls(times, np.round(np.column_stack(values), 15))

    @classmethod
    def read(cls, path):
        """Read a `<case>.scenario.csv`."""
        data = np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
        missing = np.zeros((len(data), 1 + len(COLUMNS) - data.shape[1]))
        return cls(data[:, 0], np.hstack([data[:, 1:], missing]))

    def write(self, path):
        """Write a `<case>.scenario.csv`, column `time` first, a brake that is not used left out."""
        count = len(COLUMNS) - (not self.brakes)
        with Path(path).open("w", newline="") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(("time", *COLUMNS[:count]))
            for t, row in zip(self.times, self.values, strict=True):
                out.writerow([repr(float(x)) for x in (t, *row[:count])])

    @property
    def brakes(self):
        """Whether the brake is used."""
        return bool(self.values[:, 4].any())

    def at(self, time):
        """Inputs at `time`, shape (..., 5)."""
        columns = [np.interp(time, self.times, column) for column in self.values.T]
        return np.stack(columns, axis=-1)

    def kinks(self, params, stop):
        """Times inside (0, stop) where an input or a normal force bends, sorted."""
        found = set(self.times)
        for i in range(2):
            position = self.values[:, 1 + i]
            for level in np.array(params.maps_mm[i][0]) * 1e-3:
                found |= set(_crossings(self.times, position, level))
        return sorted(float(t) for t in found if 0 < t < stop)


def _crossings(times, values, level):
    for t0, t1, a, b in zip(times[:-1], times[1:], values[:-1], values[1:], strict=True):
        if (a - level) * (b - level) < 0:
            yield t0 + (t1 - t0) * (level - a) / (b - a)


@dataclass(frozen=True)
class Piece:
    """A smooth stretch: start [s], duration [s], input sample time (None: continuous), row?."""

    start: float
    duration: float
    sample: float | None
    end: float
    row: bool


def held_pieces(stop, h, row_every, longest):
    """Communication steps of `h`, the last one shortened, each cut to pieces <= `longest`."""
    steps = int(np.floor(stop / h * (1 + 1e-12) + 1e-9))
    edges = [k * h for k in range(steps + 1)]
    if stop - edges[-1] > 1e-12:
        edges.append(stop)
    per_row = max(1, round(row_every / h))
    for k, (t0, t1) in enumerate(pairwise(edges)):
        length = h if k < steps else t1 - t0
        parts = int(np.ceil(length / longest * (1 - 1e-9)))
        row = (k + 1) % per_row == 0 or k + 2 == len(edges)
        for j in range(parts):
            last = j + 1 == parts
            end = t1 if last else t0 + (j + 1) * length / parts
            yield Piece(t0 + j * length / parts, length / parts, t0, end, row and last)


def continuous_pieces(stop, grid, row_every, longest, kinks):
    """Pieces of `grid` (<= `longest`), cut also at the `kinks` of the inputs."""
    parts = max(1, int(np.ceil(grid / longest * (1 - 1e-9))))
    count, step = round(stop / grid) * parts, grid / parts
    per_row = round(row_every / step)
    for k in range(count):
        t0, t1 = k * step, (k + 1) * step
        inner = [t for t in kinks if t0 + 1e-9 < t < t1 - 1e-9]
        cuts = [t0, *inner, t1]
        for a, b in pairwise(cuts):
            row = b == t1 and (k + 1) % per_row == 0
            yield Piece(a, b - a if inner else step, None, b, row)
