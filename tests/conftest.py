"""Shared by all Python tests: where the repository and its FMUs are."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def repo_root() -> Path:
    """Root of the repository."""
    return Path(__file__).resolve().parent.parent
