"""Runs of a sweep one after the other, or in several processes at once.

A run that ends its process (a crash in an FMU that is not isolated, no memory) is tried anew in a
new one, then recorded as lost; the other runs go on.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from .errors import ConfigError, HarnessError, InterruptedRunError
from .kpi.scopes import SCENARIO

Job = tuple[int, dict[str, Any]]  # run number, chosen values
Row = dict[str, Any]
TRIES = 3  # of a run that takes its process with it
LOST = "process lost"


def serial(jobs: list[Job], one: Callable[[Job], Row]) -> Iterator[Row]:
    """Yield the row of each job, in this process."""
    for job in jobs:
        yield one(job)


def parallel(jobs: list[Job], one: Callable[[Job], Row], count: int) -> Iterator[Row]:
    """Yield rows as runs end, in `count` processes; after a lost process those in it alone again.

    `one` must be picklable.
    """
    tries = dict.fromkeys((number for number, _ in jobs), 0)
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
            tries[job[0]] += alone
            if tries[job[0]] >= TRIES:
                yield {"run": job[0], **job[1], "verdict": LOST}
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
            pool.shutdown(wait=False, cancel_futures=True)
            for process in list((pool._processes or {}).values()):
                process.terminate()
            raise


def _quiet() -> None:
    """Leave Ctrl-C to the process that collects the rows; end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ["OMP_NUM_THREADS"] = "1"


def run_one(
    file: Path, fmu_dir: Path, folder: Path, engine: str, keep: bool, job: Job
) -> dict[str, Any]:
    """Run once; returns the drawn values, the verdict and the KPIs of the whole scenario.

    A run that fails does not end the sweep: its verdict is its exit code's name.
    """
    from .cli import parser

    number, chosen = job
    out = folder / f"run-{number:04d}"
    command = ["run", str(file), "--fmu-dir", str(fmu_dir), "--out", str(out), "-q"]
    command += ["--engine", engine]
    command += [word for n, v in chosen.items() for word in ("--set", f"{n}={json.dumps(v)}")]
    words = parser().parse_args(command)
    try:
        words.action(words)
    except (ConfigError, InterruptedRunError):
        raise
    except HarnessError as error:
        return {"run": number, **chosen, "verdict": f"exit {error.exit_code}"}
    kpis = json.loads((out / "kpis.json").read_text(encoding="utf-8"))
    if not keep:
        shutil.rmtree(out)
    whole = {"/".join(filter(None, (r["kpi"], r["signal"], r["estimate"]))): r["value"]
             for r in kpis["rows"] if r["scope"] == SCENARIO}  # fmt: skip
    return {"run": number, **chosen, "verdict": kpis["verdict"], **whole}
