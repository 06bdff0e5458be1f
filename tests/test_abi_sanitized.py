"""The C importer and the libraries with the address sanitizer in both: no byte outside its object.

rustc has sanitizers, but on stable it wants to be persuaded with RUSTC_BOOTSTRAP.
"""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path

import pytest
from importer_cases import MODELS
from test_abi import CASES, PROBE, ROOT, TIMEOUT, arguments, host, library

TARGET = ROOT / "target" / "sanitized"
CRATES = {
    PROBE: "abi-probe", "DctPlant": "dct-plant", "DctObserver": "dct-observer",
    "DctClutchControl": "dct-clutch-control",
}  # fmt: skip
FLAGS = {
    "RUSTFLAGS": "-Zsanitizer=address", "RUSTC_BOOTSTRAP": "1",
    "CARGO_PROFILE_RELEASE_LTO": "off", "CARGO_PROFILE_RELEASE_STRIP": "none",
    "CARGO_PROFILE_RELEASE_CODEGEN_UNITS": "16",
}  # fmt: skip


@cache
def _built() -> Path:
    """Return the folder of the libraries, built for the triple of this machine.

    A triple has to be named: without one, build scripts would be built with the sanitizer too.
    """
    said = subprocess.run(["rustc", "-vV"], capture_output=True, text=True, check=True).stdout
    triple = said.split("host: ")[1].splitlines()[0]
    packages = [word for crate in CRATES.values() for word in ("-p", crate)]
    command = ["cargo", "build", "--quiet", "--release", "--lib", "--target", triple,
               "--target-dir", TARGET, *packages]  # fmt: skip
    subprocess.run(command, cwd=ROOT, check=True, env=os.environ | FLAGS)
    return TARGET / triple / "release"


def _ran(model: str, case: str) -> subprocess.CompletedProcess[str]:
    name = CRATES[PROBE].replace("-", "_") if model == PROBE else model
    sanitized = library(model)._replace(path=_built() / f"lib{name}.so")
    command = [host("-fsanitize=address"), *arguments(sanitized, case)]
    return subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False)


@pytest.mark.parametrize("model", [PROBE, *MODELS])
@pytest.mark.parametrize("case", CASES)
def test_the_sanitizer_finds_nothing(model: str, case: str) -> None:
    done = _ran(model, case)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_the_sanitizer_sees_what_it_is_there_for() -> None:
    done = _ran(PROBE, "overrun")
    assert done.returncode != 0
    assert "heap-buffer-overflow" in done.stderr
