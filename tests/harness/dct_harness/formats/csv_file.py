"""CSV: a header of names, then numbers that read back exactly. It has no place for units."""

from __future__ import annotations

import csv
import warnings
from io import StringIO
from pathlib import Path

import numpy as np

from ..errors import ConfigError, not_utf8


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
    names: list[str] = []
    with path.open(encoding="utf-8-sig") as file:
        try:
            names = next(csv.reader([file.readline()]), [""])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a table without rows is one
                rows = np.loadtxt(file, delimiter=",", comments=None, ndmin=2)
        except UnicodeDecodeError as error:
            raise ConfigError(not_utf8(path)) from error
        except (ValueError, csv.Error) as error:
            raise ConfigError(f"{path}: {_fault(path, names) or error}") from error
    if not any(names):
        raise ConfigError(f"{path}: needs a header and at least one row")
    if rows.size and rows.shape[1] != len(names):
        raise ConfigError(f"{path}: {rows.shape[1]} columns of numbers, {len(names)} names")
    return names, rows.reshape(-1, len(names)), {}


def _fault(path: Path, names: list[str]) -> str:
    """Return the first row that is not a number for each name; rows count as lines do."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        for line, row in enumerate(csv.reader(file), 1):
            if line == 1 or not row:
                continue
            if len(row) != len(names):
                return f"row {line} has {len(row)} cells, the header {len(names)}"
            for name, cell in zip(names, row, strict=True):
                if not _is_number(cell):
                    return f"row {line}: '{name}' is '{cell}', not a number"
    return ""


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
