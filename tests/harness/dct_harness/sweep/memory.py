"""Memory of a process that makes many runs."""

from __future__ import annotations

import ctypes

from ..fmu.loader import glibc_present

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # of mallopt(3)
FREE = 256 << 20  # bytes that stay with the process when nothing needs them
LARGE = 32 << 20  # bytes of a block that goes back at once, the most that glibc allows


def keep() -> None:
    """Let this process keep the memory that a run frees: the next run needs as much.

    Otherwise the C library gives it back to the machine and asks for it again page by page, 1,700
    times in a run of 30 s by the compiled master: a tenth of its time.
    """
    if glibc_present():
        library = ctypes.CDLL(None)
        library.mallopt(MMAP_THRESHOLD, LARGE)
        library.mallopt(TRIM_THRESHOLD, FREE)
