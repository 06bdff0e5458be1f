"""`report --compare-to`: an earlier run dotted in the figures, and what changed in tables."""

from __future__ import annotations

import copy
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from browsing import browser
from dct_harness import cli, report, results
from dct_harness.errors import ConfigError
from dct_harness.kpi import typography
from dct_harness.report import earlier, runs
from test_report import LINES, Visit, shots
from test_report_data import write_all, write_run

__all__ = ["browser", "shots"]  # fixtures
FACTOR = 0.9  # of the observer's first torque in the earlier run


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    """Return a run and an earlier one whose first torque estimate and mass were others."""
    now = write_run(tmp_path / "now", "paper_case1", "Case 1")
    before = tmp_path / "before"
    shutil.copytree(now, before)
    loaded = results.load(before)
    loaded.signals["observer.clutch1.torque"] *= FACTOR
    told = copy.deepcopy(loaded.run["parameters"])
    told["plant"]["mass"] = {"value": 1.0, "unit": "kg"}
    run = {**loaded.run, "parameters": told}
    results.write(before, list(loaded.signals), np.column_stack(list(loaded.signals.values())), run)
    return now, before


def test_changes_are_the_kpis_signals_and_facts_that_differ(pair: tuple[Path, Path]) -> None:
    (view,) = earlier.beside(runs.load([pair[0]]), [pair[1]])
    found = earlier.changes(view)
    assert [s["name"] for s in found["signals"]] == ["observer.clutch1.torque"]
    assert found["signals"][0]["nrmse"] == f"{1 / FACTOR - 1:.2g}"
    assert {k["signal"].split()[0] for k in found["kpis"]} == {"clutch1.torque"}
    facts = [(f["name"], f["was"], f["now"]) for f in found["facts"]]
    assert facts == [("plant.mass", "1.0", "–")]


@pytest.mark.parametrize(("was", "now", "shown"), [
    (-123.456789, -123.4, ("−123.457", "−123.400")), (0.0123, 0.5, ("0.01", "0.50")),
    (100.0, 20.0, ("100", "20")), (0.0, -1e-3, ("0.0000", "−0.0010")), (1.0, 0.0, ("1", "0")),
    (1e-9, 0.5, ("0.00", "0.50")), (-6.8e-10, 3e-9, ("−6.8·10⁻¹⁰", "3.0·10⁻⁹")),
    (12345678.0, 12345679.0, ("1.23456780·10⁷", "1.23456790·10⁷")), (7.0, 7.0, ("7.00", "7.00")),
    (None, 2.5, ("–", "2.50")),
])  # fmt: skip
def test_two_values_have_the_digits_that_tell_what_changed(
    was: float | None, now: float, shown: tuple[str, str]
) -> None:
    assert typography.pair(was, now) == shown


@pytest.mark.parametrize(("name", "printed"), [
    ("N.m", "N·m"), ("kg.m2", "kg·m²"), ("N.m.s/rad", "N·m·s/rad"), ("m/s2", "m/s²"),
    ("min-1", "min⁻¹"), ("m/s^1.75", "m/s¹·⁷⁵"), ("1/min", "1/min"), ("degC", "°C"), ("1", ""),
])  # fmt: skip
def test_units_are_printed_as_people_write_them(name: str, printed: str) -> None:
    assert typography.unit(name) == printed


def test_only_negative_numbers_have_a_minus_sign() -> None:
    assert typography.shortened("differs by 5100.5, allowed 1e-09", 3) == (
        "differs by 5100, allowed 1·10⁻⁹"
    )
    assert typography.pair(1.0, float("inf")) == ("1.00", "inf")
    assert typography.minus("-3.2 %, map-based, 1e-05, <-.4") == "−3.2 %, map-based, 1e-05, <−.4"


def test_the_same_run_has_no_dotted_line(pair: tuple[Path, Path], tmp_path: Path) -> None:
    (view,) = earlier.beside(runs.load([pair[0]]), [pair[0]])
    figures = [report.figures.torques(view), report.figures.driveline(view)]
    lines = [t for f in figures for p in f["panels"] for t in p["traces"]]
    assert not any(t.get("before") for t in lines)
    page = report.write_views([view], tmp_path / "page", "Same").read_text(encoding="utf-8")
    assert re.search(r"All \d+ signals agree with the earlier run", page)


def test_runs_find_their_own_earlier_ones(tmp_path: Path) -> None:
    now, before = write_all(tmp_path / "now"), write_all(tmp_path / "before")
    views = earlier.beside(runs.load(now), before[::-1])
    assert [v.earlier.results.path for v in views] == before
    alone = earlier.beside(runs.load(now), before[:1])
    assert [v.earlier is not None for v in alone] == [True, False, False, False]
    other = write_run(tmp_path / "x", "paper_case3", "Case 3")
    with pytest.raises(ConfigError, match="no run of system 'paper_case3' is shown"):
        earlier.beside(runs.load(now), [other])


def test_the_page_draws_the_earlier_run_dotted(
    browser: object, shots: Path, pair: tuple[Path, Path], tmp_path: Path
) -> None:
    out = tmp_path / "page"
    command = ["report", str(pair[0]), "--compare-to", str(pair[1]), "--out", str(out)]
    cli.main([*command, "--title", "Now & then"])
    visited = Visit(browser, out / "index.html")
    assert visited.page.locator("h1").inner_text() == "Now & then"
    assert all(f["drawn"] == f["wanted"] > 0 for f in visited.page.evaluate(LINES))
    dotted = visited.page.evaluate("""() => [...document.querySelectorAll(".plot")].flatMap(
        (div) => div.data.filter((t) => t.line?.dash === "dot").map((t) => t.name))""")
    assert dotted == ["observer, earlier"]
    visited.page.click("nav a[href='#earlier']")
    assert visited.page.locator("table.changed tbody tr").count() == 1
    assert visited.page.locator("table.kpichange tbody tr").count() > 2
    visited.page.get_by_text("Parameters, FMUs and versions that differ (1)").click()
    assert visited.page.get_by_text("plant.mass").is_visible()
    visited.page.screenshot(path=shots / "earlier.png")
    assert visited.complaints == []
    visited.page.close()
