"""Result directory: `results.csv`, `run.json`, and their loader.

`run.json` holds `system` (effective system file), `step` [s], `stop` [s], `status`
("complete" or "partial"), `error`, `samples`, `reached` (time of the last sample [s]), `fmus`
(component -> path, modelName, guid, generationTool, sha256), `parameters` (component -> name ->
value, unit, and item of an enumeration), `wiring` (list of from, to), `events` (list of time,
component, variable, from, to), `log` (list of component, time, category, status, message),
`wall_time` (component -> s), and `environment`.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .errors import ConfigError, did_you_mean

RESULTS_CSV = "results.csv"
RUN_JSON = "run.json"


@dataclass(frozen=True)
class Results:
    """Signals of one run by name, in SI units, all of shape (number of samples,)."""

    signals: dict[str, np.ndarray]
    run: dict[str, Any]
    path: Path | None = None

    @property
    def time(self) -> np.ndarray:
        """Communication points [s]."""
        return self.signals["time"]

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a signal by `<component>.<variable>`; the error names the nearest one."""
        try:
            return self.signals[name]
        except KeyError:
            raise KeyError(f"no signal '{name}'.{did_you_mean(name, self.signals)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.signals


def write_text(path: Path, text: str) -> None:
    """Write a file whole: to a temporary name beside it, then renamed."""
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(text, encoding="utf-8", newline="\n")
    os.replace(temporary, path)


def write(out: Path, names: list[str], rows: np.ndarray, run: dict[str, Any]) -> None:
    """Write `results.csv` and `run.json`.

    `rows` has shape (samples, len(names)); numbers are written so that they read back exactly.
    """
    out.mkdir(parents=True, exist_ok=True)
    lines = [",".join(names)]
    lines += [",".join(map(repr, row)) for row in rows.tolist()]
    write_text(out / RESULTS_CSV, "\n".join(lines) + "\n")
    write_text(out / RUN_JSON, json.dumps(run, indent=2, ensure_ascii=False) + "\n")


def load(directory: str | Path) -> Results:
    """Load a result directory.

    Raises
    ------
    ConfigError
        The directory holds no complete pair of `results.csv` and `run.json`, or a damaged one.
    """
    directory = Path(directory)
    for name in (RESULTS_CSV, RUN_JSON):
        if not (directory / name).is_file():
            raise ConfigError(f"{directory}: no {name}; make it with `dct-harness run`")
    with (directory / RESULTS_CSV).open(encoding="utf-8") as file:
        names = file.readline().rstrip("\n").split(",")
        try:
            table = np.loadtxt(file, delimiter=",", comments=None, ndmin=2)
        except ValueError as error:
            raise ConfigError(f"{directory / RESULTS_CSV}: {error}") from error
    run = json.loads((directory / RUN_JSON).read_text(encoding="utf-8"))
    return from_table(names, table, run, directory)


def from_table(names: list[str], rows: np.ndarray, run: dict[str, Any], directory: Path) -> Results:
    """Return results whose `rows` have shape (samples, len(names))."""
    columns = np.ascontiguousarray(rows.T)
    return Results(dict(zip(names, columns, strict=True)), run, directory)
