"""`dct-harness doctor`: versions, platform, and which FMUs load here."""

from __future__ import annotations

import argparse
import zipfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from . import loader
from .arguments import Verbs, verb
from .environment import environment
from .errors import HarnessError

OPTIONAL = {
    "pyarrow": "results as Parquet: pip install dct-harness[parquet]",
    "asammdf": "results as MF4: pip install dct-harness[mf4]",
    "matplotlib": "pictures: pip install dct-harness[picture]",
}


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "doctor", doctor, "versions, platform, do the FMUs load",
                  "doctor target/fmu/*.fmu")  # fmt: skip
    parser.add_argument("fmus", type=Path, nargs="*")


def doctor(args: argparse.Namespace) -> int:
    """Print what a run depends on; returns the worst exit code of the FMUs."""
    for name, text in environment().items():
        print(f"{name}: {text}")
    for package, gives in OPTIONAL.items():
        print(f"{package}: {_version(package) or f'not installed ({gives})'}")
    print(f"glibc: {loader.glibc_present() or 'none'}")
    return max((_diagnose(path) for path in args.fmus), default=0)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _platforms(path: Path) -> str:
    """Return the platforms an FMU has binaries for, as its archive says."""
    try:
        with zipfile.ZipFile(path) as archive:
            parts = [name.split("/") for name in archive.namelist()]
    except (OSError, zipfile.BadZipFile):
        return ""
    found = sorted({p[1] for p in parts if len(p) > 2 and p[0] == "binaries" and p[2]})
    return f"{path}: binaries for {', '.join(found) or 'no platform'}"


def _diagnose(path: Path) -> int:
    """Print whether an FMU loads; returns the exit code that stands for the answer."""
    from .isolated import load

    if platforms := _platforms(path):
        print(platforms)
    try:
        fmu = load("doctor", path)
    except HarnessError as error:
        print(error)
        return error.exit_code
    needed = loader.glibc_needed(fmu.library)
    fmu.close()
    print(f"{path}: loads" + (f", needs glibc {needed} or newer" if needed else ""))
    return 0
