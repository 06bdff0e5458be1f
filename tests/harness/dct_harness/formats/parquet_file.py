"""Parquet by pyarrow: double columns; the unit of each is metadata `unit` of its field."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np

from ..errors import ConfigError

UNIT = b"unit"


def require() -> None:
    """Refuse to start work that could not be written.

    Raises
    ------
    ConfigError
        The package is not installed.
    """
    _pyarrow()


def _pyarrow() -> tuple[ModuleType, ModuleType]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise ConfigError("Parquet needs `pip install dct-harness[parquet]`") from error
    return pyarrow, parquet


def write(path: Path, names: list[str], rows: np.ndarray, units: dict[str, str]) -> None:
    """Write a table with units."""
    arrow, parquet = _pyarrow()
    fields = [
        arrow.field(n, arrow.float64(), nullable=False, metadata={UNIT: units.get(n, "").encode()})
        for n in names
    ]
    columns = [arrow.array(column) for column in np.ascontiguousarray(rows.T)]
    parquet.write_table(arrow.Table.from_arrays(columns, schema=arrow.schema(fields)), path)


def read(path: Path) -> tuple[list[str], np.ndarray, dict[str, str]]:
    """Return names, rows and units; columns that hold no numbers are an error."""
    arrow, parquet = _pyarrow()
    try:
        table = parquet.read_table(path)
        columns = [column.to_numpy().astype(float) for column in table.columns]
    except (arrow.ArrowException, ValueError, TypeError) as error:
        raise ConfigError(f"{path}: {error}") from error
    units = {
        f.name: f.metadata[UNIT].decode() for f in table.schema if UNIT in (f.metadata or {})
    }  # fmt: skip
    rows = np.column_stack(columns) if columns else np.zeros((0, 0))
    return table.schema.names, rows, {name: unit for name, unit in units.items() if unit}
