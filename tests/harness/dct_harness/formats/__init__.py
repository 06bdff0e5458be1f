"""Tables of signals as files: CSV, Parquet and MF4, chosen by the file's suffix.

A file is written beside its name and renamed when it is complete, so it is whole or not there.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

import numpy as np

from ..errors import ConfigError, did_you_mean
from . import csv_file, mf4_file, parquet_file

SUFFIXES: dict[str, ModuleType] = {
    ".csv": csv_file, ".parquet": parquet_file, ".mf4": mf4_file,
}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """Signals on one time axis.

    `names` starts with `time` [s]; `rows` has shape (samples, len(names)); `units` holds the unit
    of each signal that has one.
    """

    names: list[str]
    rows: np.ndarray
    units: dict[str, str] = field(default_factory=dict)


def _format(path: Path) -> ModuleType:
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ConfigError(
            f"{path}: '{suffix}' is none of {', '.join(SUFFIXES)}.{did_you_mean(suffix, SUFFIXES)}"
        )
    return SUFFIXES[suffix]


def require(path: Path) -> None:
    """Check that a file of this suffix can be written here, before work starts.

    Raises
    ------
    ConfigError
        The suffix is unknown, or its package is not installed.
    """
    _format(path).require()


def write(path: Path, table: Table) -> None:
    """Write a table; CSV cells read back exactly, Parquet and MF4 hold double precision.

    Raises
    ------
    ConfigError
        The suffix is unknown, or the package that writes it is not installed.
    """
    chosen = _format(path)
    part = path.with_name(f"{path.stem}.part{path.suffix}")
    try:
        chosen.write(part, table.names, table.rows, table.units)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def read(path: Path) -> Table:
    """Read a table.

    Raises
    ------
    ConfigError
        The suffix is unknown, the file damaged, or the package that reads it not installed.
    """
    chosen = _format(path)
    if not path.is_file():
        raise ConfigError(f"{path}: there is no such file")
    names, rows, units = chosen.read(path)
    if not names or names[0] != "time":
        raise ConfigError(f"{path}: the first column must be 'time'")
    return Table(names, rows, units)
