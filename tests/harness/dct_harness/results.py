"""Result directory: `results.csv` (or .parquet, .mf4), `run.json`, and their loader.

`run.json` holds `system` (effective system file), `step` [s], `stop` [s], `status`
("complete" or "partial"), `error`, `samples`, `reached` (time of the last sample [s]), `fmus`
(component -> path, modelName, guid, generationTool, sha256), `parameters` (component -> name ->
value, unit, and item of an enumeration), `wiring` (list of from, to), `signals` (name -> unit,
type), `events` (list of time, component, variable, from, to), `log` (list of component, time,
category, status, message), `wall_time` (component -> s; empty with the compiled master, which
does not measure it), and `environment`.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import formats
from .errors import ConfigError, did_you_mean, instant

RESULTS_CSV = "results.csv"
RUN_JSON = "run.json"
KPIS_JSON = "kpis.json"
AGAIN = "make it again with `dct-harness run`"
BLOCK = 512  # rows


@dataclass(frozen=True)
class Results:
    """Signals of one run by name, in SI units, all of shape (number of samples,).

    `unkept`: signals that the run has but did not record: they are in it, to read one is an error.
    `spacing`: the communication step [s], where it is known.
    """

    signals: dict[str, np.ndarray]
    run: dict[str, Any]
    path: Path | None = None
    unkept: frozenset[str] = frozenset()
    spacing: float | None = None

    @property
    def time(self) -> np.ndarray:
        """Communication points [s]."""
        return self.signals["time"]

    @cached_property
    def step(self) -> float:
        """Communication step [s]: the median, as the last one may be shorter."""
        return median_step(self.time) if self.spacing is None else self.spacing

    def __getitem__(self, name: str) -> np.ndarray:
        """Return a signal by `<component>.<variable>`; the error names the nearest one."""
        try:
            return self.signals[name]
        except KeyError:
            if name in self.unkept:
                raise KeyError(f"'{name}' was not recorded in this run") from None
            raise KeyError(f"no signal '{name}'.{did_you_mean(name, self.signals)}") from None

    def __contains__(self, name: object) -> bool:
        return name in self.signals or name in self.unkept


def median_step(time: np.ndarray) -> float:
    """Return the step [s] between most communication points."""
    return float(np.median(np.diff(time)))


def check_writable(out: Path) -> None:
    """Refuse a result directory that cannot be made or written to, before a run rather than after.

    Raises
    ------
    ConfigError
        It is a file, or this user may not write there.
    """
    above = next(folder for folder in (out, *out.absolute().parents) if folder.exists())
    if not above.is_dir():
        raise ConfigError(f"--out {out}: {above} is a file, not a folder; name another folder")
    if not os.access(above, os.W_OK | os.X_OK):
        raise ConfigError(f"--out {out}: {above} is not writable; name another folder")


def write_text(path: Path, text: str) -> None:
    """Write a file whole: to a temporary name beside it, then renamed."""
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(text, encoding="utf-8", newline="\n")
    os.replace(temporary, path)


def write(
    out: Path, names: list[str], rows: np.ndarray, run: dict[str, Any], suffix: str = ".csv"
) -> None:
    """Write `results.csv` (or another suffix of `formats`) and `run.json`.

    `rows` has shape (samples, len(names)). Results of an earlier run in another format go, so
    that a directory never holds those of two runs.
    """
    out.mkdir(parents=True, exist_ok=True)
    formats.write(out / f"results{suffix}", formats.Table(names, rows, units(run)))
    for other in formats.SUFFIXES:
        if other != suffix:
            (out / f"results{other}").unlink(missing_ok=True)
    write_text(out / RUN_JSON, json.dumps(run, indent=2, ensure_ascii=False) + "\n")


def remove(out: Path) -> None:
    """Remove what a run wrote into its directory, and the directory if nothing else lies there."""
    names = (f"{RUN_JSON}*", f"{KPIS_JSON}*", "calibration*.ssv*", "results.*")
    for path in {path for name in names for path in out.glob(name)}:
        path.unlink()
    with suppress(OSError):
        out.rmdir()


def units(run: dict[str, Any]) -> dict[str, str]:
    """Return the unit of each signal that `run.json` gives one."""
    return {n: signal["unit"] for n, signal in run.get("signals", {}).items() if signal["unit"]}


def find(directory: Path) -> Path:
    """Return the results file of a directory, whatever its format.

    Raises
    ------
    ConfigError
        The directory does not hold one results file.
    """
    found = [p for s in formats.SUFFIXES if (p := directory / f"results{s}").is_file()]
    if not found:
        what = f"no {RESULTS_CSV}" if directory.is_dir() else "there is no such directory"
        what = "it is a file, not a directory of results" if directory.is_file() else what
        inside = min((p.parent for p in directory.glob(f"*/{RUN_JSON}")), default=None)
        hint = f", or name one that lies in it, such as {inside}" if inside else ""
        raise ConfigError(f"{directory}: {what}; make it with `dct-harness run`{hint}")
    if len(found) > 1:
        names = ", ".join(path.name for path in found)
        raise ConfigError(f"{directory}: holds {names}; keep the one to read")
    return found[0]


def load(directory: str | Path) -> Results:
    """Load a result directory.

    Raises
    ------
    ConfigError
        The directory holds no complete pair of results and `run.json`, or a damaged one.
    """
    directory = Path(directory)
    path = find(directory)
    if not (directory / RUN_JSON).is_file():
        raise ConfigError(f"{directory}: no {RUN_JSON}; make it with `dct-harness run`")
    table = _read(path)
    return from_table(table.names, table.rows, read_json(directory / RUN_JSON), directory)


def load_any(path: str | Path) -> Results:
    """Load a result directory, or a single file of any format, whose `run` is then empty."""
    path = Path(path)
    if path.is_dir() or not path.suffix:
        return load(path)
    table = _read(path)
    signals = {n: {"unit": table.units.get(n, ""), "type": "Real"} for n in table.names}
    return from_table(table.names, table.rows, {"signals": signals}, path)


def read_json(path: Path, again: str = AGAIN) -> dict[str, Any]:
    """Read a file of a result directory; `again` says what makes it anew.

    Raises
    ------
    ConfigError
        It is cut, or holds something else.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ConfigError(f"{path}: is not valid JSON: {error}; {again}") from None
    if not isinstance(found, dict):
        raise ConfigError(f"{path}: is no JSON object; {again}")
    return found


def _read(path: Path) -> formats.Table:
    """Read results: at least one sample, and time does not go back."""
    table = formats.read(path)
    time = table.rows[:, 0]
    if not time.size:
        raise ConfigError(f"{path}: holds no sample; {AGAIN}")
    bad = np.flatnonzero(~(np.diff(time, prepend=-np.inf) >= 0))
    if bad.size:
        k = int(bad[0])
        after = f" after {instant(time[k - 1])} s" if k else ""
        told = f"time is {time[k]:g} s{after} in sample {k + 1}; it must not fall"
        raise ConfigError(f"{path}: {told}")
    return table


def from_table(names: list[str], rows: np.ndarray, run: dict[str, Any], directory: Path) -> Results:
    """Return results whose `rows` have shape (samples, len(names))."""
    return Results(dict(zip(names, columns(rows), strict=True)), run, directory)


def columns(rows: np.ndarray) -> np.ndarray:
    """Return a copy of shape (signals, samples); block by block, as a cache likes it best."""
    found = np.empty(rows.shape[::-1])
    for first in range(0, len(rows), BLOCK):
        found[:, first : first + BLOCK] = rows[first : first + BLOCK].T
    return found
