"""What is told of an FMU while it runs: its messages, our notes beside them, and its errors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi2

from ..errors import FmuRuntimeError, HarnessError, instant
from .host import MISSING
from .ports import Ports

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
LAST_MESSAGES = 5
ENDS = "asked to end the simulation at {} s (fmi2Terminated)"
UNASKED = "; its log is off: --fmu-log lets it say why"
Failed = Callable[[str, str], HarnessError]  # an error of a function and what it did


class Told(Ports):
    """The messages of one FMU, and the sentences about it."""

    def __init__(self, name: str, path: Path) -> None:
        self.name, self.path = name, path
        self.asked = False  # to log although we have not built it
        self.log: list[dict[str, Any]] = []
        self.now = 0.0
        self._discards = False
        self.ends: dict[str, FmuRuntimeError] = {}  # who wants the run to end; of all FMUs of a run

    def note(self, status: str, category: str, message: str) -> None:
        """Add a message, at the time of the step."""
        self.log.append({"component": self.name, "time": self.now, "status": status,
                         "category": category, "message": message})  # fmt: skip

    def note_discard(self, t: float) -> None:
        """Tell in the log, once, that steps had to be divided."""
        if not self._discards:
            what = f"fmi2DoStep at t = {instant(t)} s returned fmi2Discard; this step was divided"
            self.note("Warning", "harness", what)
        self._discards = True

    def note_end(self, t: float) -> FmuRuntimeError:
        """Tell in the log that the FMU asked to end at `t` [s]; returns the error of going on."""
        told = ENDS.format(instant(t))
        self.note("Warning", "harness", told)
        self.ends[self.name] = FmuRuntimeError(f"{self.name} {told}, before the run's stop")
        return self.ends[self.name]

    def failed(self, function: str, what: str) -> FmuRuntimeError:
        """Return the error of a call, with the last messages."""
        told = f"{self.name}: {function} at t = {instant(self.now)} s {what}"
        return FmuRuntimeError(told + self.said())

    def said(self) -> str:
        """Return the last messages, a line each."""
        if not (self.log or self.asked or self.is_ours):
            return UNASKED
        last = self.log[-LAST_MESSAGES:]
        return "".join(f"\n  {m['category']}: {m['message']}" for m in last)

    def callbacks(self) -> Any:
        """Return what fmi2Instantiate takes; what the FMU says goes to the log."""

        def logger(_env: Any, _instance: Any, status: int, category: bytes, message: bytes) -> None:
            text = _plain((message or b"").decode("utf-8", "replace"))
            self.note(word(status), (category or b"").decode("utf-8", "replace"), text)

        found = fmi2.fmi2CallbackFunctions()
        found.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        found.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        found.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._kept = found
        return found


def returned(status: int) -> str:
    """Return the words for a status that is not good."""
    if status == MISSING:
        return "returned nothing: the FMU has no such function"
    return f"returned fmi2{word(status)}"


def word(status: int) -> str:
    """Return the name of an fmi2Status."""
    return STATUS[status] if 0 <= status < len(STATUS) else str(status)


def _plain(message: str) -> str:
    """Return a message without the doubling of the characters that a C importer would format."""
    return message.replace("%%", "%").replace("##", "#")
