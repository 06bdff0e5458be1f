"""What a process of a sweep is asked in place of a run; it imports nothing that starts threads."""

from __future__ import annotations

import os
import threading

import numpy as np
from dct_harness.sweep.cases import Job


def threads(job: Job) -> dict[str, int]:
    """Return how many threads there are beside Python's own, after a product of matrices."""
    square = np.ones((500, 500))
    assert (square @ square)[0, 0] == 500
    return {"run": job.number, "threads": len(os.listdir("/proc/self/task"))
            - threading.active_count()}  # fmt: skip
