"""Shared by all Python tests: where the repository and its FMUs are, and the C fixture FMU."""

from __future__ import annotations

from pathlib import Path

import pytest
from harness_fixture import lag_fmu


@pytest.fixture(scope="session")
def repo_root() -> Path:
    """Root of the repository."""
    return Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def lag_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Shared library of the C fixture."""
    return lag_fmu.compile_library(tmp_path_factory.mktemp("library"))


@pytest.fixture(scope="session")
def lag_dir(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """Directory with `Lag.fmu`."""
    folder = tmp_path_factory.mktemp("lag")
    lag_fmu.write_fmu(folder / "Lag.fmu", lag_library)
    return folder


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory with the lag as `Lag.fmu`, which misbehaves from t = 0.1 s on as `mode` says."""
    return lag_fmu.write_hostile(tmp_path_factory.mktemp("hostile"))
