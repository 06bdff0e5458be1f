"""A process that makes runs of a sweep: it ends when the sweep does, and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import threading
import time
import traceback
from collections.abc import Callable
from multiprocessing import connection, parent_process
from multiprocessing.connection import Connection
from typing import Any, NoReturn

from ..errors import InterruptedRunError
from .cases import Job
from .runs import KEPT, Row

LEAVES = 30.0  # s for a run to end and remove its files; a call into an FMU that takes longer hangs


class Ender:
    """What SIGTERM does: the run that is being made ends and removes its files, then the process.

    As long as the loop of a run goes, `watch.interruptible` stands before it, and ends the loop.
    """

    def __init__(self) -> None:
        self.busy, self.told = False, False
        signal.signal(signal.SIGTERM, self.tell)

    def tell(self, *_: Any) -> None:
        """Interrupt the run, once; without a run end the process."""
        if not self.busy:
            end_at_once()
        if not self.told:
            self.told = True
            raise InterruptedRunError("interrupted by SIGTERM")


def work(pipe: Connection, one: Callable[[Job], Row]) -> None:
    """Answer each job that comes with its row and None, or with None and what the run raised."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal sends it to all processes of a sweep
    ender = Ender()
    threading.Thread(target=_end_with_the_sweep, daemon=True).start()
    try:
        while True:
            pipe.send(_answer(one, pipe.recv(), ender))
    except (EOFError, OSError, InterruptedRunError):  # there are no more jobs
        end_at_once()


def _answer(
    one: Callable[[Job], Row], job: Job, ender: Ender
) -> tuple[Row | None, Exception | None]:
    ender.busy = True
    try:
        return one(job), None
    except InterruptedRunError:
        raise
    except Exception as error:
        if hasattr(error, "add_note"):  # Python 3.11
            error.add_note("".join(traceback.format_exception(error)))
        return None, error
    finally:
        ender.busy = False


def _end_with_the_sweep() -> None:
    """Wait until the process that collects the rows is gone, even by SIGKILL; then end this one."""
    sweep = parent_process()
    if sweep is None:
        return
    connection.wait([sweep.sentinel])
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(LEAVES)
    end_at_once()


def end_at_once() -> NoReturn:
    """End this process, which makes no run just now, and remove what it has unpacked."""
    KEPT.remove_folder()
    os._exit(1)
