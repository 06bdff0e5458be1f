"""Scenario CSV: first column `time` [s], then one column per signal (SI units)."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from ..errors import ConfigError, instant, not_utf8, unreadable
from ..units import HEADER

LAST = 4  # scenarios that stay read: of a process that makes many runs
INSTANT = 1e-9  # s; times that differ by less are one


@dataclass(frozen=True)
class Scenario:
    """Signals over time: `time` has shape (n,), each signal too; nobody may write to them."""

    time: np.ndarray
    signals: dict[str, np.ndarray]
    path: Path

    def sample(self, name: str, times: np.ndarray, hold: bool) -> np.ndarray:
        """Return a signal at `times` [s]: linear between rows, or held (discrete inputs).

        Before the first and after the last row the end values hold.
        """
        values = self.signals[name]
        if not hold:
            return np.interp(times, self.time, values)
        row = np.searchsorted(self.time, times, side="right") - 1
        return values[np.clip(row, 0, len(values) - 1)]

    def beyond(self, stop: float) -> list[tuple[float, str]]:
        """Return when a run from 0 to `stop` [s] leaves the rows, and what that means.

        A scenario of one row holds its values, and so does one without signals.
        """
        if len(self.time) < 2 or not self.signals:
            return []
        first, last = self.time[[0, -1]].tolist()
        early = f"begins at t = {instant(first)} s: its first values hold until then"
        late = f"ends at t = {instant(last)} s: its last values hold from then on"
        found = [(0.0, early)] if first > INSTANT else []
        found += [(last, late)] if stop > last + INSTANT else []
        return [(t, f"scenario {self.path.name} {text}") for t, text in found]


def load(path: Path | None) -> Scenario:
    """Read a scenario; errors name file, line and column."""
    if path is None:
        return Scenario(np.zeros(1), {}, Path("no scenario"))
    try:
        return _parsed(path, path.read_bytes())
    except OSError as error:
        raise ConfigError(unreadable(path, "scenario", error, ".csv")) from error
    except UnicodeDecodeError as error:
        raise ConfigError(not_utf8(path)) from error


@lru_cache(LAST)
def _parsed(path: Path, content: bytes) -> Scenario:
    file = io.StringIO(content.decode("utf-8-sig"), newline="")
    rows = [(k, row) for k, row in enumerate(csv.reader(file), 1) if row]
    if len(rows) < 2:
        raise ConfigError(f"{path}: needs a header and at least one row")
    names = [name.strip() for name in rows[0][1]]
    _check_header(path, names)
    table = np.array([_numbers(path, line, names, row) for line, row in rows[1:]])
    table.flags.writeable = False
    _check_times(path, table[:, 0], [line for line, _ in rows[1:]])
    signals = {name: table[:, k] for k, name in enumerate(names) if k > 0}
    return Scenario(table[:, 0], signals, path)


def _check_header(path: Path, names: list[str]) -> None:
    convert = f"`dct-harness convert {path} scenario.csv`"
    if names[0] != "time":
        said = f"{path}:1: the first column must be 'time' [s], not '{names[0]}'"
        other = any(sign in names[0] for sign in ";\t")
        hint = f"; columns are separated by commas: {convert} does that, decimal commas too"
        raise ConfigError(said + hint if other else said)
    for name in names:
        if stated := HEADER.match(name):
            raise ConfigError(
                f"{path}:1: column '{name}': values are in SI units, and names stand alone: "
                f"{convert} makes them '{stated['name']}'"
            )
        if not name or names.count(name) > 1:
            raise ConfigError(f"{path}:1: column name '{name}' is empty or used twice")


def _numbers(path: Path, line: int, names: list[str], row: list[str]) -> list[float]:
    if len(row) != len(names):
        hint = "; decimals are written with a point" if len(row) > len(names) else ""
        raise ConfigError(f"{path}:{line}: has {len(row)} cells, the header has {len(names)}{hint}")
    return [_number(path, line, name, cell) for name, cell in zip(names, row, strict=True)]


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(f"{path}:{line}: column '{name}': '{cell}' is not a finite number")
    return value


def _check_times(path: Path, time: np.ndarray, lines: list[int]) -> None:
    bad = np.flatnonzero(np.diff(time) <= 0)
    if bad.size:
        before, t = time[bad[0] : bad[0] + 2].tolist()
        line = lines[int(bad[0]) + 1]
        raise ConfigError(f"{path}:{line}: time {t!r} does not increase (before it: {before!r})")
