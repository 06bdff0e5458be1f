"""`dct-harness doctor`: versions, platform, and which FMUs load here."""

from __future__ import annotations

import argparse
import zipfile
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ..errors import HarnessError
from ..fmu import loader, sources
from .arguments import Verbs, add_loudness, say, verb
from .environment import environment

OPTIONAL = {
    "pyarrow": "results as Parquet: pip install dct-harness[parquet]",
    "asammdf": "results as MF4: pip install dct-harness[mf4]",
    "scipy": "sweeps by Latin hypercube and Sobol: pip install dct-harness[sweep]",
    "distributed": "sweeps on a cluster: pip install dct-harness[dask]",
    "fmu_manipulation_toolbox": "export-container: pip install dct-harness[container]",
    "matplotlib": "pictures: pip install dct-harness[picture]",
}

CODES = """of the worst FMU: 0 it loads,
2 a file cannot be read, 3 FMU invalid, 4 its code fails, 5 its code hangs,
6 no binary for this platform"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "doctor", doctor, "versions, platform, do the FMUs load",
                  "doctor\ndoctor target/fmu/DctPlant.fmu Supplier.fmu --json", CODES)  # fmt: skip
    parser.add_argument("fmus", type=Path, nargs="*", help="FMUs to try to load")
    add_loudness(parser, "versions and what each FMU needs")


def doctor(args: argparse.Namespace) -> int:
    """Print what a run depends on; returns the worst exit code of the FMUs."""
    found = environment() | {p: _version(p) for p in OPTIONAL} | {"glibc": loader.glibc_present()}
    absent = {p: f"not installed ({gives})" for p, gives in OPTIONAL.items()} | {"glibc": "none"}
    lines = [f"{name}: {text or absent[name]}" for name, text in found.items()]
    fmus = [_diagnose(path) for path in args.fmus]
    lines += [line for fmu in fmus for line in _sentences(fmu)]
    say(args, "\n".join(lines), {"machine": found, "fmus": fmus})
    return max((fmu["exitCode"] for fmu in fmus), default=0)


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _platforms(path: Path) -> list[str] | None:
    """Return the platforms an FMU has binaries for, as its archive says; None if it is none."""
    try:
        with zipfile.ZipFile(path) as archive:
            parts = [name.split("/") for name in archive.namelist()]
    except (OSError, zipfile.BadZipFile):
        return None
    return sorted({p[1] for p in parts if len(p) > 2 and p[0] == "binaries" and p[2]})


def _diagnose(path: Path) -> dict[str, Any]:
    """Return file, platforms, the glibc it needs, the error with its exit code, if it is old."""
    from ..fmu.isolated import load

    found = {"file": str(path), "platforms": _platforms(path), "glibc": None, "error": None,
             "exitCode": 0, "outdated": sources.remark([path])}  # fmt: skip
    try:
        fmu = load("doctor", path)
    except HarnessError as error:
        return {**found, "error": str(error), "exitCode": error.exit_code}
    needed = loader.glibc_needed(fmu.library)
    fmu.close()
    return {**found, "glibc": needed}


def _sentences(fmu: dict[str, Any]) -> Iterator[str]:
    if fmu["platforms"] is not None:
        yield f"{fmu['file']}: binaries for {', '.join(fmu['platforms']) or 'no platform'}"
    if fmu["error"]:
        yield fmu["error"]
    else:
        needs = f", needs glibc {fmu['glibc']} or newer" if fmu["glibc"] else ""
        yield f"{fmu['file']}: loads{needs}"
    if fmu["outdated"]:
        yield fmu["outdated"]
