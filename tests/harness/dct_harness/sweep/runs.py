"""One run of a sweep: what it needs, its row, and whether another try may mend what went wrong."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from .. import results
from ..errors import (
    ConfigError,
    FmuRuntimeError,
    HarnessError,
    InterruptedRunError,
    RunTimeoutError,
    did_you_mean,
)
from ..fmu.kept import Kept
from ..kpi.scopes import SCENARIO
from ..results import Results
from ..verbs import run as run_verb
from . import leftover, memory
from .cases import Job
from .study import Words

Row = dict[str, Any]
COURSES = "courses"  # of a row: signal -> values
REPEATED = (FmuRuntimeError, RunTimeoutError)  # what another try may mend
KEPT = Kept()  # FMUs that this process has open


@dataclass(frozen=True)
class Setup:
    """What is the same for all runs of a sweep."""

    common: Words
    folder: Path  # of kept runs
    keep: bool = False  # the signals of every run, not only of those that fail
    signals: tuple[str, ...] = ()  # globs of courses that a row holds
    every: float = 0.1  # s between their samples
    retries: int = 0


class Prepared:
    """Makes the runs of a sweep in one process, with what it has ready for them.

    What the runs of a combination of axes share (system, mapping, wiring, scenario) is read for the
    first of them and stays for the others. It is empty when it is sent to another process.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup = setup
        self._asked: tuple[Words, run_verb.Asked] | None = None  # of the last combination

    def run_one(self, job: Job) -> Row:
        """Run until it succeeds or its retries are used up; returns the last row.

        The first try records what its row needs, the others everything; where there is no other,
        one is made to keep all signals of a run that fails.
        """
        row, error = self.attempt(job)
        left = self._setup.retries
        while may_mend(error) and (left or (error and error.in_part)):
            row, error = self.attempt(job, whole=True)
            left = max(0, left - 1)
        return row

    def attempt(
        self, job: Job, whole: bool = False, folder: Path | None = None
    ) -> tuple[Row, HarnessError | None]:
        """Run once; returns the row and what prevented the run's end.

        `whole`: all signals are recorded, not only those that the row needs; `folder`: of kept
        runs, instead of the sweep's.

        The row has the chosen values, the verdict and the KPIs of the whole scenario. A run that
        fails does not end the sweep: its verdict is its exit code's name, and `error` says why.
        """
        try:
            return self._done(job, whole, folder or self._setup.folder), None
        except (ConfigError, InterruptedRunError):
            raise
        except HarnessError as error:
            row = {"run": job.number, **job.chosen, "verdict": f"exit {error.exit_code}",
                   "error": str(error)}  # fmt: skip
            return row, error

    def _done(self, job: Job, whole: bool, folder: Path) -> Row:
        """Return the row of a run that reaches its end."""
        setup, asked = self._setup, self._combination(job.shared)
        loop = asked.loop(job.sets)
        loop.kept_open = KEPT
        needed = None if whole else partial(_matching, setup.signals)
        out = leftover.run_folder(folder, job.number)
        if out.is_dir():
            results.remove(out)  # of a try before, or of a sweep that was killed
        told, kpis = run_verb.judged(loop, out, asked.args, setup.keep, needed)
        values = {"/".join(filter(None, (r["kpi"], r["signal"], r["estimate"]))): r["value"]
                  for r in kpis["rows"] if r["scope"] == SCENARIO}  # fmt: skip
        courses = _courses(told, setup.signals, setup.every)
        more = {COURSES: courses} if courses else {}
        return {"run": job.number, **job.chosen, "verdict": kpis["verdict"], **values, **more}

    def _combination(self, shared: Words) -> run_verb.Asked:
        """Return what runs of a combination ask for; an opened .ssp goes with its run."""
        if self._asked is not None and self._asked[0] == shared:
            return self._asked[1]
        memory.keep()
        words = map(str, (*self._setup.common, *shared, "-q"))
        asked = run_verb.Asked(parser().parse_args(list(words)))
        results.check_writable(self._setup.folder)
        leftover.makes_runs(self._setup.folder)
        if asked.package is None:
            self._asked = shared, asked
        return asked


def may_mend(error: HarnessError | None) -> bool:
    """Return whether another try may mend what went wrong."""
    return type(error) in REPEATED


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    from ..cli import parser as made

    return made()


def _courses(told: Results, globs: tuple[str, ...], every: float) -> dict[str, Any]:
    """Return the chosen signals at every so many seconds, `time` first."""
    if not globs:
        return {}
    names = _matching(globs, tuple(told.signals))
    lost = next((g for g in globs if not any(fnmatch(n, g) for n in names)), None)
    if lost is not None:
        hint = did_you_mean(lost, (*told.signals, *told.unkept))
        raise ConfigError(f"keep.signals: no signal of the run is called '{lost}'.{hint}")
    wanted = np.arange(0.0, told.time[-1] + every / 2, every)
    index = np.searchsorted(told.time, wanted - every * 1e-6).clip(max=len(told.time) - 1)
    return {n: told[n][index].tolist() for n in dict.fromkeys(("time", *names))}


@lru_cache(16)
def _matching(globs: tuple[str, ...], names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names that at least one of the globs matches."""
    return tuple(name for name in names if any(fnmatch(name, glob) for glob in globs))
