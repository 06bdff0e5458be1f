"""Channels of a measurement file: CSV with units in its header, Parquet, MF4, or a result."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .. import formats, results
from ..errors import ConfigError, instant, not_utf8
from ..formats import mf4_file
from ..units import HEADER, find, to_si

DELIMITERS = (",", ";", "\t")
TIMES = ("time", "t", "zeit", "timestamp", "timestamps")


@dataclass(frozen=True)
class Channel:
    """Samples of one quantity: `time` [s] and `values`, shape (n,); `held` between samples."""

    name: str
    time: np.ndarray
    values: np.ndarray
    unit: str = ""
    held: bool = False


def read(path: Path) -> list[Channel]:
    """Read every channel of a result directory or a file.

    Raises
    ------
    ConfigError
        The file cannot be read, or a channel's time does not increase.
    """
    if path.is_dir():
        found = _of_results(results.load(path))
    elif path.suffix.lower() == ".csv":
        found = _of_csv(path)
    elif path.suffix.lower() == ".mf4":
        found = _of_mf4(path)
    else:
        found = _of_table(formats.read(path))
    for channel in found:
        _check_time(path, channel)
    return found


def in_si(channels: list[Channel]) -> tuple[list[Channel], list[str]]:
    """Return channels in SI units, and the names of those whose unit is not known: as they were."""
    strange = [channel.name for channel in channels if find(channel.unit) is None]
    return [c if c.name in strange else _in_si(c) for c in channels], strange


def _in_si(channel: Channel) -> Channel:
    unit, factor, offset = to_si(channel.unit)
    if not channel.unit or (factor, offset) == (1.0, 0.0):
        return channel  # to the last bit, -0.0 too
    return replace(channel, values=channel.values * factor + offset, unit=unit)


def _check_time(path: Path, channel: Channel) -> None:
    backward = np.flatnonzero(~(np.diff(channel.time) > 0))
    if backward.size:
        k = int(backward[0])
        raise ConfigError(
            f"{path}: time of '{channel.name}' goes from {instant(channel.time[k])} to "
            f"{instant(channel.time[k + 1])} s; it must increase"
        )


def _of_results(run: results.Results) -> list[Channel]:
    told = run.run.get("signals", {})
    return [
        Channel(n, run.time, v, told.get(n, {}).get("unit", ""),
                told.get(n, {}).get("type", "Real") != "Real")
        for n, v in run.signals.items() if n != "time"
    ]  # fmt: skip


def _of_mf4(path: Path) -> list[Channel]:
    return [
        Channel(s.name, s.timestamps, s.samples.astype(float), s.unit or "",
                s.samples.dtype.kind in "iub")
        for s in mf4_file.channels(path)
    ]  # fmt: skip


def _of_table(table: formats.Table) -> list[Channel]:
    time = table.rows[:, 0]
    pairs = enumerate(table.names[1:], 1)
    return [Channel(n, time, table.rows[:, k], table.units.get(n, "")) for k, n in pairs]


def _of_csv(path: Path) -> list[Channel]:
    """Read a CSV of any usual delimiter; a header cell may be `name [unit]`.

    Empty cells are samples that this channel does not have.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: cannot read it: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(not_utf8(path)) from error
    head = text.partition("\n")[0]
    delimiter = max(DELIMITERS, key=head.count)
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if row]
    if len(rows) < 2:
        raise ConfigError(f"{path}: needs a header and at least one row")
    names = [_split(cell) for cell in rows[0]]
    if names[0][0].lower() not in TIMES:
        raise ConfigError(f"{path}: the first column must be the time, not '{names[0][0]}'")
    decimal_comma = delimiter != ","
    columns: list[list[float]] = [[] for _ in names]
    for line, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            hint = "; decimals are written with a point" if delimiter == "," else ""
            said = f"{path}: row {line} has {len(row)} cells, the header {len(names)}"
            raise ConfigError(said + hint if len(row) > len(names) else said)
        for column, (name, _), cell in zip(columns, names, row, strict=True):
            column.append(_number(path, line, name, cell, decimal_comma))
    time, *values = (np.array(column) for column in columns)
    time = time * _seconds(path, names[0][1])
    return [_present(n, u, time, v) for (n, u), v in zip(names[1:], values, strict=True)]


def _seconds(path: Path, unit: str) -> float:
    """Return how long the unit of the time column is [s]; none means seconds."""
    known = find(unit or "s")
    if known is None or known.exponents != (("s", 1),):
        raise ConfigError(f"{path}: the time is in '{unit}'; it must be in s or ms")
    return known.factor


def _split(cell: str) -> tuple[str, str]:
    """Return name and unit of a header cell."""
    cell = cell.strip()
    match = HEADER.match(cell)
    return (match["name"], match["unit"].strip()) if match else (cell, "")


def _number(path: Path, line: int, name: str, cell: str, decimal_comma: bool) -> float:
    text = cell.strip().replace(",", ".") if decimal_comma else cell.strip()
    if not text:
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise ConfigError(f"{path}: row {line}: '{name}' is '{cell}', not a number") from None


def _present(name: str, unit: str, time: np.ndarray, values: np.ndarray) -> Channel:
    has = ~np.isnan(values)
    return Channel(name, time[has], values[has], unit)
