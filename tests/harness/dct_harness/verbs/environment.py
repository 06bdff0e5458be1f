"""Versions and platform that a run depends on."""

from __future__ import annotations

import platform
from importlib.metadata import version


def environment() -> dict[str, str]:
    """Return what `run.json` records of the machine."""
    packages = {n: version(n) for n in ("dct-harness", "fmpy", "numpy")}
    return {**packages, "python": platform.python_version(), "platform": platform.platform()}
