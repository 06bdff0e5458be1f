"""The page of the shipped study says what its rows say."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest
from dct_harness.sweep import study_file

LARGEST = 400_000  # bytes of rows and picture in the repository


@pytest.fixture(scope="module")
def script(repo_root: Path) -> ModuleType:
    path = repo_root / "examples/study/page.py"
    spec = importlib.util.spec_from_file_location("study_page_script", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_its_rows_give(script: ModuleType, repo_root: Path) -> None:
    page = (repo_root / "docs/pages/study.md").read_text("utf-8")
    assert page == script.page(script.load()), "python examples/study/page.py writes it anew"


def test_the_rows_are_of_the_shipped_study(script: ModuleType, repo_root: Path) -> None:
    data = script.load()
    study = study_file.load(repo_root / "examples/study/robustness.toml")
    assert [(f["name"], tuple(f["given"])) for f in data.factors] == [
        (f.name, f.given) for f in study.factors]  # fmt: skip
    assert (data.plan["seed"], data.plan["sampling"]) == (study.seed, study.sampling)
    assert len(data.rows) >= 1000
    points = study.points()
    for row in data.rows[::50]:
        point = points[row["run"] - 1]
        assert {name: row[name] for name in point} == point
    assert not data.failed


def test_what_is_kept_is_small(script: ModuleType) -> None:
    kept = (script.ROWS, script.PLAN, script.PAGES / script.PICTURE)
    assert sum(path.stat().st_size for path in kept) < LARGEST
