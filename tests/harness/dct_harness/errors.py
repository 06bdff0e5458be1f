"""Errors of the harness, each with the exit code of the command line."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

import numpy as np


class HarnessError(Exception):
    """Base of all errors that the command line reports as one sentence.

    `in_part`: the run that it ended recorded some of its signals only.
    """

    exit_code = 2
    in_part = False


class ConfigError(HarnessError):
    """A system file, scenario or option is wrong (exit code 2).

    `variable`: of a component, where its value is what is wrong.
    """

    def __init__(self, message: str, variable: str = "") -> None:
        super().__init__(message)
        self.variable = variable


class FmuInvalidError(HarnessError):
    """An FMU or its archive is not usable (exit code 3)."""

    exit_code = 3


class FmuRuntimeError(HarnessError):
    """An FMU failed while it ran (exit code 4)."""

    exit_code = 4


class RunTimeoutError(HarnessError):
    """A run took longer than it may (exit code 5)."""

    exit_code = 5


class PlatformError(HarnessError):
    """An FMU has no binary for this platform (exit code 6)."""

    exit_code = 6


class InterruptedRunError(HarnessError):
    """Someone pressed Ctrl-C (exit code 130, as a shell reports the signal)."""

    exit_code = 130


def instant(t: float) -> str:
    """Return a time [s] for sentences: shortest form, rounded to 1 ns, ``9.412``."""
    rounded = round(float(t), 9) + 0.0  # no -0
    return np.format_float_positional(rounded, trim="-")


def unreadable(path: Path, what: str, error: OSError, suffix: str = "") -> str:
    """Return why a file cannot be read, and what may have been meant.

    Of one that is not there it is the nearest name beside it, of a folder the first file in it
    that ends with `suffix`.
    """
    if path.is_dir():
        inside = min(path.glob(f"*{suffix}"), default=None) if suffix else None
        such = f", such as {inside}" if inside else ""
        return f"{path}: is a folder: name the {what} itself{such}"
    told = f"{path}: cannot read the {what}: {error.strerror or error}"
    if not (isinstance(error, FileNotFoundError) and path.parent.is_dir()):
        return told
    hint = did_you_mean(path.name, (beside.name for beside in path.parent.iterdir()))
    return f"{told}.{hint}" if hint else told


def not_utf8(path: Path) -> str:
    """Return that a table's text cannot be read, and how a spreadsheet writes one that can."""
    return f"{path}: is not UTF-8 text; spreadsheets write it as 'CSV UTF-8'"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return `` Did you mean 'x'?`` for the closest known name, or an empty string.

    Of a list of numbers, `x[1]` and on, a name without a number means the first.
    """
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    if not close:
        return ""
    (hit,) = close
    if hit.endswith("]") and "[" not in name:
        stem = hit.rpartition("[")[0]
        hit = next(n for n in names if n.endswith("]") and n.rpartition("[")[0] == stem)
    return f" Did you mean '{hit}'?"
