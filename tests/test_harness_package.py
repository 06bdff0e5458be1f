"""The wheel of dct-harness: whole, licensed, and built without a word of what setuptools drops."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from email.message import Message
from email.parser import Parser
from pathlib import Path

import pytest

LICENCES = {"LICENSE-APACHE", "LICENSE-MIT"}


@pytest.fixture(scope="module")
def built(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Return the wheel, and what building it said."""
    folder = tmp_path_factory.mktemp("wheel")
    unbuilt = shutil.ignore_patterns("build", "*.egg-info", "__pycache__")
    source = shutil.copytree(repo_root / "tests/harness", folder / "source", ignore=unbuilt)
    words = ["wheel", "--verbose", "--no-deps", "--no-build-isolation", "--wheel-dir", folder]
    done = subprocess.run([sys.executable, "-m", "pip", *words, source],
                          capture_output=True, text=True, check=True)  # fmt: skip
    (wheel,) = folder.glob("*.whl")
    return wheel, done.stdout + done.stderr


def _members(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def _metadata(wheel: Path) -> Message:
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (n for n in archive.namelist() if n.endswith(".dist-info/METADATA"))
        return Parser().parsestr(archive.read(name).decode())


def test_nothing_that_its_build_says_is_deprecated(built: tuple[Path, str]) -> None:
    assert "adding 'dct_harness/cli.py'" in built[1]
    assert "Deprecat" not in built[1]


def test_it_holds_every_file_of_the_package(built: tuple[Path, str], repo_root: Path) -> None:
    listed = subprocess.run(["git", "ls-files", "dct_harness"], cwd=repo_root / "tests/harness",
                            capture_output=True, text=True, check=True).stdout  # fmt: skip
    assert set(listed.split()) - _members(built[0]) == set()


def test_it_brings_its_licences_and_its_page(built: tuple[Path, str], repo_root: Path) -> None:
    told = _metadata(built[0])
    assert told["License-Expression"] == "MIT OR Apache-2.0"
    assert set(told.get_all("License-File")) == LICENCES
    assert told.get_payload() == (repo_root / "tests/harness/README.md").read_text()
    with zipfile.ZipFile(built[0]) as archive:
        for name in LICENCES:
            (member,) = (n for n in archive.namelist() if n.endswith(f"/{name}"))
            assert archive.read(member) == (repo_root / name).read_bytes()
