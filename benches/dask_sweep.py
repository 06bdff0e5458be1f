"""Runs of a sweep on a dask cluster of this machine, each a plain loop on fmpy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import psutil
from distributed import Client, LocalCluster

LOOP = Path(__file__).resolve().with_name("fmpy_loop.py")
WORKERS = 2


def _whole(work: tuple[Any, ...], _number: int) -> int:
    import fmpy_loop

    return fmpy_loop.whole(*work)


def _spent() -> float:
    """Return the CPU time of this process and of all its workers [s]."""
    here = psutil.Process()
    times = [p.cpu_times() for p in (here, *here.children(recursive=True))]
    return sum(t.user + t.system for t in times)


def cpu(runs: int, work: tuple[Any, ...]) -> float:
    """Return the CPU time of one of `runs` runs [s], of all processes; the first does not count."""
    with (
        LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.upload_file(str(LOOP))
        data = client.scatter(work, broadcast=True, hash=False)
        client.gather([client.submit(_whole, data, -1 - k, pure=False) for k in range(WORKERS)])
        before = _spent()
        futures = [client.submit(_whole, data, k, pure=False) for k in range(runs)]
        rows = client.gather(futures)
        spent = _spent() - before
    if any(count != len(work[1]) for count in rows):
        raise SystemExit(f"dask: runs of {rows} rows instead of {len(work[1])}")
    return spent / runs
