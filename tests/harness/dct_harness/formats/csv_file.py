"""CSV: a header of names, then numbers that read back exactly. It has no place for units."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import numpy as np

from ..errors import ConfigError


def require() -> None:
    """Do nothing: CSV needs no package."""


def write(path: Path, names: list[str], rows: np.ndarray, units: dict[str, str]) -> None:
    """Write a table; `units` are left to `run.json` beside a result file."""
    del units
    lines = [_heading(names)]
    lines += [",".join(map(repr, row)) for row in rows.tolist()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _heading(names: list[str]) -> str:
    """Return a line of names; FMI names of matrices, `a[1,2]`, stand in quotes."""
    line = StringIO()
    csv.writer(line, lineterminator="").writerow(names)
    return line.getvalue()


def read(path: Path) -> tuple[list[str], np.ndarray, dict[str, str]]:
    """Return names, rows and no units; an incomplete row is an error that names its line."""
    with path.open(encoding="utf-8-sig") as file:
        try:
            names = next(csv.reader([file.readline()]), [""])
            rows = np.loadtxt(file, delimiter=",", comments=None, ndmin=2)
        except (ValueError, csv.Error) as error:
            raise ConfigError(f"{path}: {error}") from error
    if rows.size and rows.shape[1] != len(names):
        raise ConfigError(f"{path}: {rows.shape[1]} columns of numbers, {len(names)} names")
    return names, rows.reshape(-1, len(names)), {}
