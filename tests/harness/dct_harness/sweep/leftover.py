"""What a sweep that was killed leaves: signals of runs without a row, and runs that still end.

Locks say who is at work. The folder of a sweep is locked by the process that collects its rows,
the store in it by each process that makes runs. They go with their process, even by SIGKILL; a file
system that knows no locks, or a platform, does without.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing import parent_process
from pathlib import Path

from .. import results
from ..errors import ConfigError
from .store import FOLDER

if sys.platform != "win32":
    import fcntl

NAME = re.compile(r"run-(\d{4,})")


def run_folder(out: Path, number: int) -> Path:
    """Return where the signals of a run lie."""
    return out / f"run-{number:04d}"


def remove(out: Path, rows: Collection[int]) -> None:
    """Remove what lies of runs that have no row."""
    for folder in out.glob("run-*"):
        named = NAME.fullmatch(folder.name)
        if named and int(named[1]) not in rows:
            results.remove(folder)


@contextmanager
def alone(out: Path) -> Iterator[None]:
    """Keep a folder for one sweep, from when the runs of a killed one before it have ended.

    Raises
    ------
    ConfigError
        Another sweep is at work there.
    """
    (out / FOLDER).mkdir(parents=True, exist_ok=True)
    if sys.platform == "win32":
        yield
        return
    with _opened(out) as own:
        if not _lock(own, fcntl.LOCK_EX | fcntl.LOCK_NB):
            raise ConfigError(f"--out {out}: another sweep is at work there; choose another folder")
        with _opened(out / FOLDER) as store:
            _lock(store, fcntl.LOCK_EX)
        yield


@cache
def makes_runs(out: Path) -> None:
    """Let others see, until this worker ends, that it makes runs of the sweep in this folder."""
    if sys.platform != "win32" and parent_process() is not None and (out / FOLDER).is_dir():
        _lock(os.open(out / FOLDER, os.O_RDONLY), fcntl.LOCK_SH)


@contextmanager
def _opened(folder: Path) -> Iterator[int]:
    opened = os.open(folder, os.O_RDONLY)
    try:
        yield opened
    finally:
        os.close(opened)


def _lock(folder: int, how: int) -> bool:
    """Lock as long as the folder is open; returns False where another process has it."""
    with suppress(OSError):  # of a file system without locks
        try:
            fcntl.flock(folder, how)
        except BlockingIOError:
            return False
    return True
