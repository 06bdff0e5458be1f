"""What ends a run from outside: Ctrl-C, SIGTERM and a time limit."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ..errors import InterruptedRunError, RunTimeoutError
from .master import Run

SIGNALS: dict[int, str] = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}
GRACE = 2.0  # s; a call into an FMU that takes longer than this past the limit hangs


@contextmanager
def interruptible(run: Run) -> Iterator[None]:
    """Let Ctrl-C and SIGTERM end `run` at its next communication point; a second one at once.

    A CI server that cancels a job sends SIGTERM. Only a process's main thread may do so;
    elsewhere the signals do what they did before.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, _frame: Any) -> None:
        signal.signal(number, previous[number])
        run.abort = InterruptedRunError(f"interrupted by {SIGNALS[number]}")

    previous: dict[int, Any] = {number: signal.signal(number, handle) for number in SIGNALS}
    try:
        yield
    finally:
        for number, action in previous.items():
            signal.signal(number, action)


@contextmanager
def stoppable() -> Iterator[None]:
    """Let SIGTERM end a sweep as Ctrl-C does: its processes end with it, rows are kept."""

    def handle(_number: int, _frame: Any) -> None:
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGTERM, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


@contextmanager
def time_limit(
    run: Run, seconds: float | None, on_hang: Callable[[RunTimeoutError], None]
) -> Iterator[None]:
    """End `run` after `seconds` [s] of wall-clock time.

    It ends at its next communication point. An FMU that does not return from a call would never
    get there: `on_hang` is then called from another thread and the process exits with code 5.
    """
    if seconds is None:
        yield
        return
    finished, limit = threading.Event(), seconds

    def watch() -> None:
        if finished.wait(limit):
            return
        run.abort = RunTimeoutError(f"not finished after {limit:g} s (--timeout)")
        while not finished.wait(GRACE):
            if not run.at_work:
                continue
            error = RunTimeoutError(f"an FMU does not return, {limit:g} s are over (--timeout)")
            try:
                on_hang(error)
            finally:
                os._exit(error.exit_code)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        finished.set()
