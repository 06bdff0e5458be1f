"""How far a run is: a bar with the time left on a terminal, a line every 10 % elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any, TextIO

LINES = 10  # printed per run where there is no terminal


class Silent:
    """Shows nothing."""

    def update(self, done: int, total: int) -> None:
        """Take note of `done` of `total` steps."""

    def close(self) -> None:
        """Leave the output stream as other text needs it."""

    def __enter__(self) -> Silent:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Lines(Silent):
    """Prints a line at every tenth of the run."""

    def __init__(self, stream: TextIO, unit: str) -> None:
        self._stream, self._unit, self._tenths = stream, unit, 0
        self._start = time.monotonic()

    def update(self, done: int, total: int) -> None:
        """Print when another tenth is complete."""
        tenths = LINES * done // total
        if tenths > self._tenths:
            self._tenths = tenths
            percent = 100 * tenths // LINES
            left = (time.monotonic() - self._start) * (total - done) / done
            rest = f", {left:.0f} s left" if done < total else ""
            print(f"{percent:3d} %  {self._unit} {done} of {total}{rest}", file=self._stream,
                  flush=True)  # fmt: skip


class Bar(Silent):
    """A progress bar that disappears when it is closed."""

    def __init__(self, stream: TextIO, unit: str) -> None:
        from tqdm import tqdm

        self._bar: Any = tqdm(unit=unit, leave=False, file=stream)

    def update(self, done: int, total: int) -> None:
        """Draw the bar."""
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Remove the bar."""
        self._bar.close()


def choose(quiet: bool, unit: str = "step") -> Silent:
    """Return what suits standard error."""
    if quiet:
        return Silent()
    return (Bar if sys.stderr.isatty() else Lines)(sys.stderr, unit)
