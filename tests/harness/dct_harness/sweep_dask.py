"""Runs of a sweep on the workers of a dask cluster: one that exists, or one of this machine.

The system travels as one SSP file, once to each worker; its name there is its content hash. A run
whose worker dies is taken by another one; after some deaths it is recorded as lost.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from .errors import ConfigError
from .ssp_export import Export
from .sweep_workers import LOST, TRIES, Job, Row, run_one
from .system import load

HERE = "local"  # in place of an address: a cluster of this machine
GRACE = "30 s"  # to find the scheduler


def cluster(jobs: list[Job], file: Path, fmu_dir: Path, engine: str, address: str,
            count: int) -> Iterator[Row]:  # fmt: skip
    """Yield rows as runs end on a cluster; `count` workers when it is of this machine.

    Raises
    ------
    ConfigError
        dask is not installed, or there is no scheduler at the address.
    """
    client_type, cluster_type, completed, killed, dask_config = _dask()
    archive = _packed(file, fmu_dir)
    digest = hashlib.sha256(archive).hexdigest()
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
        data = client.scatter(archive, broadcast=True)
        futures = {client.submit(_apart, job, data, digest, engine, pure=False,
                                 retries=TRIES): job for job in jobs}  # fmt: skip
        for future in completed(futures):
            number, chosen = futures[future]
            try:
                yield future.result()
            except killed:
                yield {"run": number, **chosen, "verdict": LOST}


def _dask() -> tuple[Any, Any, Any, Any, Any]:
    try:
        from dask import config
        from distributed import Client, LocalCluster, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise ConfigError("--dask needs `pip install 'dct-harness[dask]'`") from error
    return Client, LocalCluster, as_completed, KilledWorker, config


def _packed(file: Path, fmu_dir: Path) -> bytes:
    """Return the system with all it needs, as one file."""
    if file.suffix.lower() == ".ssp":
        return file.read_bytes()
    model = load(file)
    with tempfile.TemporaryDirectory(prefix="dct-harness-sweep-") as folder:
        out = Path(folder) / "system.ssp"
        paths = {n: fmu_dir / c.fmu for n, c in model.components.items()}
        Export(model, paths, None).write(out)
        return out.read_bytes()


def _apart(job: Job, archive: bytes, digest: str, engine: str) -> Row:
    """Run once on a worker; the file stays in the worker's folder, which goes with it."""
    from distributed import get_worker

    folder = Path(get_worker().local_directory)
    file = folder / f"{digest}.ssp"
    if not file.is_file():
        part = folder / f"{digest}.{os.getpid()}.part"
        part.write_bytes(archive)
        os.replace(part, file)
    with tempfile.TemporaryDirectory(prefix="dct-harness-sweep-") as out:
        return run_one(file, folder, Path(out), engine, False, job)
