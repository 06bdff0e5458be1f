"""A package outside this workspace: its listings, how it is written, and cargo in it."""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs/pages/howto/your-own-fmu.md").read_text(encoding="utf-8")
BUILT = ROOT / "target" / "outside"  # stays warm, unlike the package


def listing(name: str) -> str:
    """Return the block of the page that begins with the comment of a file's name."""
    (found,) = re.findall(rf"^```\w+\n(?:#|//) {re.escape(name)}\n(.*?)^```$", PAGE, re.M | re.S)
    return found


def write_package(folder: Path, manifest: str, code: str) -> Path:
    """Write a package; returns its folder."""
    (folder / "src").mkdir(parents=True)
    path = (ROOT / "src/fmi2").as_posix()
    (folder / "Cargo.toml").write_text(manifest.replace("../dct/src/fmi2", path))
    (folder / "src/lib.rs").write_text(code)
    return folder


def cargo(*words: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run cargo with `cargo-fmu` in the search path, as after `cargo install`; no network."""
    _build_tool()
    tool = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug"
    env = os.environ | {
        "PATH": f"{tool}{os.pathsep}{os.environ['PATH']}",
        "CARGO_TARGET_DIR": str(BUILT),
        "CARGO_NET_OFFLINE": "true",
    }
    return subprocess.run(["cargo", *map(str, words)], cwd=folder, env=env, capture_output=True,
                          text=True, check=False)  # fmt: skip


@cache
def _build_tool() -> None:
    """Build `cargo-fmu`, which the FMUs of the other tests were built with."""
    subprocess.run(["cargo", "build", "--quiet", "-p", "fmu-build"], cwd=ROOT, check=True)
