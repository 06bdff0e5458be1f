"""`dct-harness doctor`: versions, platform, and which FMUs load here."""

from __future__ import annotations

import argparse
from pathlib import Path

from . import loader
from .arguments import Verbs, verb
from .environment import environment
from .errors import HarnessError


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "doctor", doctor, "versions, platform, do the FMUs load",
                  "doctor target/fmu/*.fmu")  # fmt: skip
    parser.add_argument("fmus", type=Path, nargs="*")


def doctor(args: argparse.Namespace) -> int:
    """Print what a run depends on; returns the worst exit code of the FMUs."""
    for name, text in environment().items():
        print(f"{name}: {text}")
    print(f"glibc: {loader.glibc_present() or 'none'}")
    return max((_diagnose(path) for path in args.fmus), default=0)


def _diagnose(path: Path) -> int:
    """Print whether an FMU loads; returns the exit code that stands for the answer."""
    from .isolated import load

    try:
        fmu = load("doctor", path)
    except HarnessError as error:
        print(error)
        return error.exit_code
    needed = loader.glibc_needed(fmu.library)
    fmu.close()
    print(f"{path}: loads" + (f", needs glibc {needed} or newer" if needed else ""))
    return 0
