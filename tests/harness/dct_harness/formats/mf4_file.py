"""ASAM MDF 4 by asammdf: one group of double channels with units on a common time axis."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import ConfigError

VERSION = "4.10"
START = datetime(1970, 1, 1, tzinfo=timezone.utc)  # a simulation has no date


def require() -> None:
    """Refuse to start work that could not be written.

    Raises
    ------
    ConfigError
        The package is not installed.
    """
    _asammdf()


def _asammdf() -> ModuleType:
    try:
        import asammdf
    except ImportError as error:
        raise ConfigError("MF4 needs `pip install dct-harness[mf4]`") from error
    return asammdf


def write(path: Path, names: list[str], rows: np.ndarray, units: dict[str, str]) -> None:
    """Write a table with units."""
    asammdf = _asammdf()
    time, columns = rows[:, 0].copy(), np.ascontiguousarray(rows.T)
    signals = [
        asammdf.Signal(samples=column, timestamps=time, name=name, unit=units.get(name, ""))
        for name, column in zip(names[1:], columns[1:], strict=True)
    ]
    with asammdf.MDF(version=VERSION) as mdf:
        mdf.start_time = START
        mdf.append(signals, comment="dct-harness", common_timebase=True)
        mdf.save(path, overwrite=True)


def read(path: Path) -> tuple[list[str], np.ndarray, dict[str, str]]:
    """Return names, rows and units of a file whose channels share one time axis."""
    signals = channels(path)
    axes = [signal.timestamps for signal in signals]
    if any(not np.array_equal(axis, axes[0]) for axis in axes):
        raise ConfigError(f"{path}: its channels have several time axes; give --step to resample")
    names = ["time", *(signal.name for signal in signals)]
    rows = np.column_stack([axes[0], *(signal.samples for signal in signals)])
    return names, rows, {"time": "s"} | {s.name: s.unit for s in signals if s.unit}


def channels(path: Path) -> list[Any]:
    """Return every channel with numbers, physical values, each with its own time axis."""
    asammdf = _asammdf()
    try:
        with asammdf.MDF(path) as mdf:
            found = list(mdf.iter_channels(skip_master=True))
    except Exception as error:  # asammdf raises its own and many built-in errors
        raise ConfigError(f"{path}: is not a readable MDF file: {error}") from error
    numeric = [s for s in found if s.samples.ndim == 1 and s.samples.dtype.kind in "fiub"]
    if not numeric:
        raise ConfigError(f"{path}: has no channel with numbers")
    return numeric
