"""Runs of a sweep on the workers of a dask cluster: one that exists, or one of this machine.

Files travel by content: each goes once to each worker, whatever it is called and however many runs
read it, and lies there under its SHA-256. A run whose worker dies is taken by another one; after
some deaths it is recorded as lost.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

from .errors import ConfigError
from .study_cases import Job
from .sweep_bundle import Bundle
from .sweep_workers import LOST, TRIES, Row, Setup, run_one

HERE = "local"  # in place of an address: a cluster of this machine
GRACE = "30 s"  # to find the scheduler


def cluster(
    jobs: list[Job], setup: Setup, files: list[Path], address: str, count: int
) -> Iterator[Row]:
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
            scratch = tempfile.TemporaryDirectory(prefix="dct-harness-dask-")
            told = {"temporary-directory": stack.enter_context(scratch)}
            stack.enter_context(dask_config.set(told))
            place: Any = stack.enter_context(cluster_type(
                n_workers=count, threads_per_worker=1, dashboard_address=None))  # fmt: skip
        else:
            place = address
        try:
            client = stack.enter_context(client_type(place, timeout=GRACE))
        except (OSError, TimeoutError, ValueError) as error:
            raise ConfigError(f"--dask {address}: no scheduler there: {error}") from error
        blobs = client.scatter(bundle.blobs(), broadcast=True)
        futures = {client.submit(_apart, job, setup, bundle, blobs, pure=False,
                                 retries=TRIES): job for job in jobs}  # fmt: skip
        for future in completed(futures):
            job = futures[future]
            try:
                yield future.result()
            except killed:
                yield {"run": job.number, **job.chosen, "verdict": LOST}


def _dask() -> tuple[Any, Any, Any, Any, Any]:
    try:
        from dask import config
        from distributed import Client, LocalCluster, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise ConfigError("--dask needs `pip install 'dct-harness[dask]'`") from error
    return Client, LocalCluster, as_completed, KilledWorker, config


def _apart(job: Job, setup: Setup, bundle: Bundle, blobs: dict[str, bytes]) -> Row:
    """Run once on a worker; the files stay in the worker's folder, which goes with it."""
    from distributed import get_worker

    root = bundle.unpack(Path(get_worker().local_directory), blobs)
    with tempfile.TemporaryDirectory(prefix=f"dct-harness-sweep-{os.getpid()}-") as out:
        there = replace(setup, common=bundle.moved(setup.common, root), folder=Path(out))
        return run_one(there, job._replace(words=bundle.moved(job.words, root)))
