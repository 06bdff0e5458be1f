"""Runs of a sweep one after the other, or in several processes at once.

A run that ends its process (a crash in an FMU that is not isolated, no memory) is tried anew in
others, then recorded as lost; the other runs go on.
"""

from __future__ import annotations

import contextlib
import os
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator
from multiprocessing import connection, get_context

from .cases import Job
from .runs import Row
from .worker_process import work

THREADS = "OMP_NUM_THREADS"  # NumPy reads it when it is loaded, and never again
TRIES = 3  # of a run that takes its process with it
LOST = "process lost"
One = Callable[[Job], Row]
Rows = Generator[Row, None, None]  # to be closed by who takes no more of them
SPAWN = get_context(
    "spawn"
)  # a copy of this process would have its threads' locks, not its threads


def serial(jobs: list[Job], one: One) -> Rows:
    """Yield the row of each job, in this process."""
    for job in jobs:
        yield one(job)


def parallel(jobs: list[Job], one: One, count: int) -> Rows:
    """Yield rows as runs end, in `count` processes, which end with the generator.

    `one` must be picklable. What it raises is raised here.
    """
    waiting, tries = deque(jobs), Counter[int]()
    workers = [Worker(one) for _ in range(min(count, len(jobs)))]
    rows: list[Row] = []
    try:
        while True:
            _give(workers, waiting, one)
            yield from rows  # while the workers make the next ones
            busy = [w for w in workers if w.job is not None]
            if not busy:
                return
            rows = []
            for job, row in _answers(busy):
                tries[job.number] += 1
                if row is not None:
                    rows.append(row)
                elif tries[job.number] < TRIES:
                    waiting.append(job)
                else:
                    rows.append({"run": job.number, **job.chosen, "verdict": LOST})
    finally:
        _end(workers)


def _give(workers: list[Worker], waiting: deque[Job], one: One) -> None:
    """Give every worker without a job the next one; a new worker takes the place of a lost one."""
    for k, worker in enumerate(workers):
        if not waiting:
            return
        if worker.lost:
            workers[k] = Worker(one)
        if workers[k].job is None:
            workers[k].give(waiting.popleft())


def _answers(busy: list[Worker]) -> list[tuple[Job, Row | None]]:
    """Wait for the next workers that are done; return the job of each and its row, None if lost."""
    ready = connection.wait([w.pipe for w in busy])
    return [w.take() for w in busy if w.pipe in ready]


def _end(workers: list[Worker]) -> None:
    """End the processes: runs at their next communication point; at a second Ctrl-C at once."""
    try:
        for worker in workers:
            worker.end()
        for worker in workers:
            worker.process.join()
    except KeyboardInterrupt:
        for worker in workers:
            worker.process.kill()
        raise


@contextlib.contextmanager
def _of_one_thread() -> Iterator[None]:
    """Let processes that start meanwhile compute in one thread each, unless the user chose."""
    if THREADS in os.environ:
        yield
        return
    os.environ[THREADS] = "1"
    try:
        yield
    finally:
        del os.environ[THREADS]


class Worker:
    """A process that makes runs, seen from the process that collects the rows."""

    def __init__(self, one: One) -> None:
        self.pipe, there = SPAWN.Pipe()
        self.job: Job | None = None  # of the run that it makes
        self.lost = False
        self.process = SPAWN.Process(target=work, args=(there, one), daemon=True)
        with _of_one_thread():
            self.process.start()
        there.close()  # so that the pipe ends with the process

    def give(self, job: Job) -> None:
        """Let it make a run; whether it is still there is seen when its row is awaited."""
        self.job = job
        with contextlib.suppress(OSError):
            self.pipe.send(job)

    def take(self) -> tuple[Job, Row | None]:
        """Return its job and the row, None when the process was lost; raise what the run raised."""
        job, self.job = self.job, None
        assert job is not None
        try:
            row, error = self.pipe.recv()
        except (EOFError, OSError):
            self.lost = True
            return job, None
        if error is not None:
            raise error
        return job, row

    def end(self) -> None:
        """Tell the process to end, and the run that it makes."""
        self.pipe.close()
        if self.job is not None:
            self.process.terminate()
