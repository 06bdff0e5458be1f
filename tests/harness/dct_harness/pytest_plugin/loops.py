"""Closed loops of a test session, run through the same code as `dct-harness run`."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from .. import cli, results
from ..compare import Tolerance, Tolerances, compare
from ..errors import ConfigError
from ..master.master import BUILD
from ..results import Results
from ..verbs.compare import table

PATHS = {"plant": "--plant", "map": "--map", "scenario": "--scenario"}  # overrides that are files


@dataclass(frozen=True)
class Loop:
    """A finished run: signals by `loop["plant.engine.speed"]`, KPIs, verdict, directory."""

    results: Results
    kpis: dict[str, Any]
    path: Path

    @property
    def time(self) -> np.ndarray:
        """Communication points [s], shape (n,)."""
        return self.results.time

    def __getitem__(self, name: str) -> np.ndarray:
        return self.results[name]

    @property
    def verdict(self) -> str:
        """Return `pass`, `fail` or `not judged`, by the limits of the system file."""
        return self.kpis["verdict"]

    def kpi(self, key: str, signal: str, scope: str = "scenario", estimate: str = "") -> float:
        """Return one KPI in its unit; the error lists what there is."""
        wanted = (key, signal, scope, estimate)
        rows = {(r["kpi"], r["signal"], r["scope"], r["estimate"]): r["value"]
                for r in self.kpis["rows"]}  # fmt: skip
        if wanted not in rows:
            known = sorted({row[:2] for row in rows})
            raise ConfigError(f"no KPI {wanted}; there are {known}")
        return rows[wanted]


class Loops:
    """Runs by system and overrides, each made once."""

    def __init__(self, fmu_dir: Path, directory: Path) -> None:
        self._fmus, self._directory = fmu_dir, directory
        self._made: dict[str, Loop] = {}

    def run(self, system: Path, overrides: dict[str, Any]) -> Loop:
        """Return a run; a limit that is missed is no error, see `Loop.verdict`.

        Raises
        ------
        HarnessError
            The run is not possible or did not reach its end.
        """
        options = [word for name, value in overrides.items() for word in _words(name, value)]
        key = json.dumps([str(system), options])
        if key not in self._made:
            out = self._directory / f"{len(self._made) + 1}-{system.stem}"
            command = ["run", str(system), "--fmu-dir", str(self._fmus), "--out", str(out)]
            args = cli.parser().parse_args([*command, "--quiet", *options])
            args.action(args)
            loaded = results.load(out)
            for message in loaded.run["log"]:
                if message["category"] == BUILD:
                    warnings.warn(message["message"], stacklevel=3)
            kpis = json.loads((out / "kpis.json").read_text(encoding="utf-8"))
            self._made[key] = Loop(loaded, kpis, out)
        return self._made[key]


def _words(name: str, value: Any) -> list[str]:
    """Return the command-line words of an override."""
    if name in PATHS:
        return [PATHS[name], str(value)]
    text = json.dumps(value) if isinstance(value, (bool, int, float, str)) else str(value)
    return ["--set", f"{name.replace('__', '.')}={text}"]


def outside(run: Any, reference: Any, globs: list[str], bounds: dict[str, Any]) -> str:
    """Return a table of the signals that leave their tolerance; an empty string for none.

    Raises
    ------
    ConfigError
        No signal of the reference matches.
    """
    ours, theirs = _results(run), _results(reference)
    chosen = [n for n in theirs.signals if any(fnmatchcase(n, g) for g in globs) and n != "time"]
    if not chosen:
        raise ConfigError(f"no signal of the reference matches {', '.join(globs)}")
    kept = {n: theirs.signals[n] for n in ("time", *chosen)}
    found = compare(Results(kept, theirs.run), ours, Tolerances(Tolerance(**bounds)))
    return "" if all(o.passed for o in found) else f"\n{table(found, False)}"


def _results(what: Any) -> Results:
    if isinstance(what, Loop):
        return what.results
    return what if isinstance(what, Results) else results.load_any(what)
