"""Runs of a sweep one after the other, or in several processes at once.

A run that ends its process (a crash in an FMU that is not isolated, no memory) is tried anew in a
new one, then recorded as lost; the other runs go on. When the sweep itself is killed, its processes
end.
"""

from __future__ import annotations

import argparse
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import cache, lru_cache, partial
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from typing import Any

import numpy as np

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
from ..master import watch
from ..results import Results
from ..verbs import run as run_verb
from .cases import Job
from .study import Words

Row = dict[str, Any]
COURSES = "courses"  # of a row: signal -> values
REPEATED = (FmuRuntimeError, RunTimeoutError)  # what another try may mend
TRIES = 3  # of a run that takes its process with it
LOST = "process lost"
KEPT = Kept()  # FMUs that this process has open


def serial(jobs: list[Job], one: Callable[[Job], Row]) -> Iterator[Row]:
    """Yield the row of each job, in this process."""
    for job in jobs:
        yield one(job)


def parallel(jobs: list[Job], one: Callable[[Job], Row], count: int) -> Iterator[Row]:
    """Yield rows as runs end, in `count` processes; after a lost process those in it alone again.

    `one` must be picklable.
    """
    tries = dict.fromkeys((job.number for job in jobs), 0)
    waiting, suspects = list(jobs), list[Job]()
    while waiting or suspects:
        batch = waiting or suspects[:1]
        alone = not waiting
        left: list[Job] = []
        for job, row in _pool(batch, one, 1 if alone else count):
            if row is None:
                left.append(job)
            else:
                yield row
        waiting = []
        suspects = suspects[1:] if alone else suspects
        for job in left:
            tries[job.number] += alone
            if tries[job.number] >= TRIES:
                yield {"run": job.number, **job.chosen, "verdict": LOST}
            else:
                suspects.append(job)


def _pool(
    jobs: list[Job], one: Callable[[Job], Row], count: int
) -> Iterator[tuple[Job, Row | None]]:
    """Yield each job with its row; with None when its process, or one beside it, was lost."""
    context = get_context("spawn")
    with ProcessPoolExecutor(count, mp_context=context, initializer=_quiet) as pool:
        running: dict[Future[Row], Job] = {pool.submit(one, job): job for job in jobs}
        try:
            while running:
                done, _ = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    job = running.pop(future)
                    try:
                        yield job, future.result()
                    except BrokenProcessPool:
                        yield job, None
        except BaseException:
            processes = list((pool._processes or {}).values())  # a pool that is shut down has none
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            raise


def _quiet() -> None:
    """Leave Ctrl-C to the process that collects the rows; end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end_at_once)
    os.environ["OMP_NUM_THREADS"] = "1"
    threading.Thread(target=_end_with_the_sweep, daemon=True).start()


def _end_with_the_sweep() -> None:
    """Wait until the process that collects the rows is gone, even by SIGKILL; then end this one.

    SIGTERM lets a run end at its next communication point and remove its files.
    """
    sweep = parent_process()
    if sweep is None:
        return
    connection.wait([sweep.sentinel])
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(watch.GRACE)
    _end_at_once()


def _end_at_once(*_: Any) -> None:
    """End this process, which makes no run just now, and remove what it has unpacked."""
    KEPT.remove_folder()
    os._exit(1)


@dataclass(frozen=True)
class Setup:
    """What is the same for all runs of a sweep."""

    common: Words
    folder: Path  # of kept runs
    keep: bool = False  # the signals of every run, not only of those that fail
    signals: tuple[str, ...] = ()  # globs of courses that a row holds
    every: float = 0.1  # s between their samples
    retries: int = 0


def run_one(setup: Setup, job: Job) -> Row:
    """Run until it succeeds or its retries are used up; returns the last row.

    The first try records what its row needs, the others everything; where there is no other, one
    is made to keep all signals of a run that fails.
    """
    row, error = attempt(setup, job)
    left = setup.retries
    while may_mend(error) and (left or (error and error.in_part)):
        row, error = attempt(setup, job, whole=True)
        left = max(0, left - 1)
    return row


def may_mend(error: HarnessError | None) -> bool:
    """Return whether another try may mend what went wrong."""
    return type(error) in REPEATED


def attempt(setup: Setup, job: Job, whole: bool = False) -> tuple[Row, HarnessError | None]:
    """Run once; returns the row and what prevented the run's end.

    `whole`: all signals are recorded, not only those that the row needs.

    The row has the chosen values, the verdict and the KPIs of the whole scenario. A run that fails
    does not end the sweep: its verdict is its exit code's name, and `error` says why.
    """
    try:
        return _done(setup, job, whole), None
    except (ConfigError, InterruptedRunError):
        raise
    except HarnessError as error:
        row = {"run": job.number, **job.chosen, "verdict": f"exit {error.exit_code}",
               "error": str(error)}  # fmt: skip
        return row, error


def _done(setup: Setup, job: Job, whole: bool) -> Row:
    """Return the row of a run that reaches its end."""
    out = setup.folder / f"run-{job.number:04d}"
    words = [*map(str, (*setup.common, *job.words)), "--out", str(out), "-q"]
    needed = None if whole else partial(_matching, setup.signals)
    told, kpis = run_verb.judged(_parser().parse_args(words), setup.keep, needed, KEPT)
    values = {"/".join(filter(None, (r["kpi"], r["signal"], r["estimate"]))): r["value"]
             for r in kpis["rows"] if r["scope"] == SCENARIO}  # fmt: skip
    courses = _courses(told, setup.signals, setup.every)
    more = {COURSES: courses} if courses else {}
    return {"run": job.number, **job.chosen, "verdict": kpis["verdict"], **values, **more}


@cache
def _parser() -> argparse.ArgumentParser:
    """Return the command line's parser, which takes as long to make as a run's words to parse."""
    from ..cli import parser

    return parser()


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
