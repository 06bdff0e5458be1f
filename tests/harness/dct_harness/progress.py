"""How far a run is: a bar with ETA on a terminal, a line every 10 % elsewhere."""

from __future__ import annotations

import sys
from types import TracebackType
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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:  # fmt: skip
        self.close()


class Lines(Silent):
    """Prints a line at every tenth of the run."""

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._tenths = stream, 0

    def update(self, done: int, total: int) -> None:
        """Print when another tenth is complete."""
        tenths = LINES * done // total
        if tenths > self._tenths:
            self._tenths = tenths
            percent = 100 * tenths // LINES
            print(f"{percent:3d} %  step {done} of {total}", file=self._stream, flush=True)


class Bar(Silent):
    """A progress bar that disappears when it is closed."""

    def __init__(self, stream: TextIO) -> None:
        from tqdm import tqdm

        self._bar: Any = tqdm(unit="step", leave=False, file=stream)

    def update(self, done: int, total: int) -> None:
        """Draw the bar."""
        self._bar.total = total
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Remove the bar."""
        self._bar.close()


def choose(quiet: bool) -> Silent:
    """Return what suits standard error."""
    if quiet:
        return Silent()
    return Bar(sys.stderr) if sys.stderr.isatty() else Lines(sys.stderr)
