"""Cells of the report's tables."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from dct_harness.kpi import registry
from dct_harness.report import cells, runs
from dct_harness.report.runs import View
from test_report_data import write_run


def _ratio(observer: float, mapped: float) -> dict[str, Any]:
    """Return the cell map/obs of a scope with these RMS errors [N·m]."""
    base = {"signal": "clutch1.torque", "scope": "phase/coast"}
    rows = [
        base | {"kpi": registry.RMSE.key, "estimate": "observer", "value": observer},
        base | {"kpi": registry.RMSE.key, "estimate": "mapBased", "value": mapped},
        base | {"kpi": registry.RATIO.key, "estimate": "", "value": mapped / observer},
    ]
    found = cells.matrix(cast("View", SimpleNamespace(kpis={"rows": rows})))
    assert found is not None
    cell: dict[str, Any] = found["rows"][0]["cells"][4]
    return cell


@pytest.mark.parametrize(("observer", "mapped", "cell"), [
    (1e-4, 0.0, {"text": "–", "worse": False}),  # an open clutch: both are right
    (0.2, 0.1, {"text": "0.500", "worse": True}),
    (0.2, 0.001, {"text": "<0.01", "worse": True}),
    (0.001, 0.2, {"text": "200", "worse": False}),
])  # fmt: skip
def test_errors_that_are_not_shown_are_not_compared(
    observer: float, mapped: float, cell: dict[str, Any]
) -> None:
    assert _ratio(observer, mapped) == cell


def test_runs_of_one_title_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    """As of a system with and without a change: a missed limit has to say whose it is."""
    folders = [tmp_path / name for name in ("before", "after", "other")]
    titles = ("Same", "Same", "Another")
    made = [write_run(f, "paper_case1", t) for f, t in zip(folders, titles, strict=True)]
    views = runs.load(made)
    assert [view.title for view in views] == ["Same (before)", "Same (after)", "Another"]
    assert [view.title for view in runs.load(made[1:])] == ["Same", "Another"]
    twin = write_run(tmp_path / "elsewhere/before", "paper_case1", "Same")
    titles = [view.title for view in runs.load([made[0], twin])]
    assert titles == [f"Same ({made[0]})", f"Same ({twin})"]
