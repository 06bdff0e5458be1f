"""Runs of a sweep on the workers of a dask cluster: one that exists, or one of this machine.

Files travel by content: each goes once to each worker, whatever it is called and however many runs
read it, and lies there under its SHA-256. A run whose worker dies is taken by another one; after
some deaths it is recorded as lost. A run that fails is tried again on another worker, for the cause
may be of the worker: no room, no memory, a library that its machine lacks.

What runs unpack and write lies in the folder of their worker. That of a worker that was killed goes
with the sweep, or, on a cluster elsewhere, when dask starts the next worker there.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import ConfigError
from .bundle import Bundle
from .cases import Job
from .runs import Prepared, Row, Setup, may_mend
from .workers import LOST, TRIES, Rows

HERE = "local"  # in place of an address: a cluster of this machine
GRACE = "30 s"  # to find the scheduler
RUN = "dct-harness-sweep-"  # what folders of a run begin with
READY: dict[Setup, Prepared] = {}  # of a worker's process
SCRATCH = "dask-scratch"  # in the folder of the sweep: folders of the workers of this machine


def cluster(jobs: list[Job], setup: Setup, files: list[Path], address: str, count: int) -> Rows:
    """Yield rows as runs end on a cluster; `count` workers when it is of this machine.

    Raises
    ------
    ConfigError
        dask is not installed, or there is no scheduler at the address.
    """
    client_type, cluster_type, completed, killed, dask_config = _dask()
    bundle = Bundle.of(files)
    with ExitStack() as stack:
        if address == HERE:
            scratch = stack.enter_context(_scratch(setup.folder / SCRATCH))
            stack.enter_context(dask_config.set({"temporary-directory": str(scratch)}))
            place: Any = stack.enter_context(cluster_type(
                n_workers=count, threads_per_worker=1, dashboard_address=None))  # fmt: skip
        else:
            place = address
        try:
            client = stack.enter_context(client_type(place, timeout=GRACE))
        except (OSError, TimeoutError, ValueError) as error:
            raise ConfigError(f"--dask {address}: no scheduler there: {error}") from error
        blobs = client.scatter(bundle.blobs(), broadcast=True)
        submit = partial(client.submit, _apart, pure=False, retries=TRIES)
        futures = {submit(job, setup, bundle, blobs): (job, setup.retries) for job in jobs}
        ended = completed(list(futures))
        for future in ended:
            job, left = futures.pop(future)
            try:
                row, another, worker = future.result()
            except killed:
                yield {"run": job.number, **job.chosen, "verdict": LOST}
                continue
            if another and left:
                again = submit(job, setup, bundle, blobs, **_elsewhere(client, worker))
                futures[again] = job, left - 1
                ended.add(again)
            else:
                yield row


def _elsewhere(client: Any, worker: str) -> dict[str, Any]:
    """Return what sends a run to any other worker, as long as there is one."""
    others = [address for address in client.nthreads() if address != worker]
    return {"workers": others, "allow_other_workers": True} if others else {}


@contextmanager
def _scratch(folder: Path) -> Iterator[Path]:
    """Yield an empty folder; it goes at the end or, after SIGKILL, when the next sweep begins."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        yield folder.resolve()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _dask() -> tuple[Any, Any, Any, Any, Any]:
    try:
        from dask import config
        from distributed import Client, LocalCluster, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise ConfigError("--dask needs `pip install 'dct-harness[dask]'`") from error
    return Client, LocalCluster, as_completed, KilledWorker, config


def _apart(
    job: Job, setup: Setup, bundle: Bundle, blobs: dict[str, bytes]
) -> tuple[Row, bool, str]:
    """Run once on a worker; all its files are in the worker's folder, which goes with it.

    Returns the row, whether another try may mend it, and the worker's address.
    """
    from distributed import get_worker

    worker = get_worker()
    own = worker.local_directory
    # For all runs of this process: FMUs are unpacked into it, by Python and by the compiled master.
    os.environ["TMPDIR"] = tempfile.tempdir = own
    root = bundle.unpack(Path(own), blobs)
    with tempfile.TemporaryDirectory(prefix=f"{RUN}{os.getpid()}-") as out:
        there = replace(setup, common=bundle.moved(setup.common, root), folder=Path(own))
        moved = job._replace(shared=bundle.moved(job.shared, root))
        row, error = _prepared(there).attempt(moved, folder=Path(out))
    return row, may_mend(error), worker.address


def _prepared(setup: Setup) -> Prepared:
    """Return what this process has ready for the runs of a sweep; of the last sweep only."""
    found = READY.get(setup)
    if found is None:
        found = Prepared(setup)
        READY.clear()
        READY[setup] = found
    return found
