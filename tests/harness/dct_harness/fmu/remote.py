"""The parent's end of `host`: requests with a time limit, and why a process ended."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from io import BufferedReader
from pathlib import Path
from typing import IO, Any, cast

from ..errors import FmuRuntimeError, RunTimeoutError
from . import host

TAIL = 2000  # bytes of what the FMU printed last that are shown
LONGEST = 64 << 20  # bytes of an answer
GRACE = 2.0  # s, for fmi2Terminate and fmi2FreeInstance


class Remote:
    """A process with one FMU; every request either answers in time or ends it."""

    def __init__(self, name: str, seconds: float) -> None:
        self.name, self.seconds = name, seconds
        self._printed = bytearray()
        self._process = subprocess.Popen(
            [sys.executable, host.__file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip
        self._pipes = (self._process.stdin, self._process.stdout, self._process.stderr)
        self._to, self._from = (cast(IO[bytes], pipe).fileno() for pipe in self._pipes[:2])
        self._poll = select.poll()
        self._poll.register(self._from, select.POLLIN)
        self._drained = threading.Thread(target=self._drain, daemon=True)
        self._drained.start()
        self._read(len(host.READY), "starting its process", None)

    def _drain(self) -> None:
        """Take what the FMU prints, so that it never waits; keep the end."""
        with contextlib.suppress(OSError, ValueError):
            while part := cast(BufferedReader, self._pipes[2]).read1(1 << 16):
                self._printed += part
                del self._printed[:-TAIL]

    def send(self, letter: bytes, doing: str) -> int:
        """Send a request of one letter; returns the byte of the answer."""
        try:
            os.write(self._to, letter)
        except OSError:
            raise self._ended(doing) from None
        return self._answer(1, doing)[0]

    def ask(self, do: str, doing: str, **more: Any) -> Any:
        """Send a request in JSON; returns the answer."""
        text = json.dumps({"do": do, **more}).encode()
        try:
            os.write(self._to, b"J" + len(text).to_bytes(4, "little") + text)
        except OSError:
            raise self._ended(doing) from None
        size = int.from_bytes(self._answer(4, doing), "little")
        if size > LONGEST:
            raise self._broken(doing, f"answered with {size} bytes")
        try:
            told = json.loads(self._answer(size, doing))
            answer, alone = told["answer"], told["alone"]
        except (ValueError, KeyError, TypeError):
            raise self._broken(doing, "wrote into the harness's own pipe") from None
        if not alone:
            raise self._broken(doing, "started a process of its own")
        return answer

    def _answer(self, count: int, doing: str) -> bytes:
        return self._read(count, doing, 1000 * self.seconds)

    def _read(self, count: int, doing: str, patience: float | None) -> bytes:
        """Return so many bytes; `patience` [ms] with each, None where no FMU is at work yet."""
        found = b""
        while len(found) < count:
            if not self._poll.poll(patience):
                self.kill()
                raise RunTimeoutError(
                    f"{self.name}: {doing} did not return within {self.seconds:g} s "
                    "(--call-timeout)"
                )
            part = os.read(self._from, count - len(found))
            if not part:
                raise self._ended(doing)
            found += part
        return found

    def forked(self, doing: str) -> FmuRuntimeError:
        """End the process; returns the error that says why."""
        return self._broken(doing, "started a process of its own")

    def _broken(self, doing: str, what: str) -> FmuRuntimeError:
        self.kill()
        return FmuRuntimeError(f"{self.name}: {doing}: the FMU {what}")

    def _ended(self, doing: str) -> FmuRuntimeError:
        """Return how the process ended: a signal, or an exit of its own."""
        peak = self._peak()
        code = self._process.wait()
        self.kill()
        if code < 0:
            try:
                how = f"crashed ({signal.Signals(-code).name})"
            except ValueError:
                how = f"crashed (signal {-code})"
        else:
            how = f"ended its process (exit code {code})"
        self._drained.join(GRACE)
        said = bytes(self._printed).decode("utf-8", "replace").strip()
        tail = f"\n  it printed: {said}" if said else ""
        return FmuRuntimeError(f"{self.name}: {doing}: the FMU {how}{peak}{tail}")

    def _peak(self) -> str:
        """Reap the process; returns how much memory it had, where the system tells."""
        until = time.monotonic() + GRACE
        while hasattr(os, "wait4") and time.monotonic() < until:
            with contextlib.suppress(ChildProcessError):
                pid, status, usage = os.wait4(self._process.pid, os.WNOHANG)
                if pid:
                    self._process.returncode = os.waitstatus_to_exitcode(status)
                    return f", its process had {usage.ru_maxrss / 1024:.0f} MiB"
            time.sleep(0.001)
        self.kill()  # it has closed the pipe but not ended
        return ""

    def close(self) -> None:
        """Let the process end by itself, then make sure."""
        with contextlib.suppress(OSError):
            cast(IO[bytes], self._pipes[0]).close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(GRACE)
        self.kill()

    def kill(self) -> None:
        """End the process and everything that it started."""
        started = _descendants(self._process.pid)
        for pid in (*started, self._process.pid):
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        with contextlib.suppress(OSError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        for pipe in self._pipes[:2]:
            with contextlib.suppress(OSError):
                cast(IO[bytes], pipe).close()


def _descendants(pid: int) -> list[int]:
    """Return the processes that a process started, and theirs (Linux)."""
    found: list[int] = []
    for file in Path(f"/proc/{pid}/task").glob("*/children"):
        with contextlib.suppress(OSError):
            for child in map(int, file.read_text().split()):
                found += [child, *_descendants(child)]
    return found
