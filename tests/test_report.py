"""The report in a real browser: headless Chromium draws it, zooms it, and is asked for errors."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import closed_loop_runs
import pytest
from browsing import DRAWN, PATIENCE, browser, new_page
from dct_harness import report
from playwright.sync_api import Browser, Page, TimeoutError
from test_report_data import HOSTILE, write_all, write_run

__all__ = ["browser"]  # a fixture
LAPTOP = {"width": 1366, "height": 768}
SHEET = (1030, 640)  # px of an A4 page across: 297 mm less margins of 12 mm, at 96 px an inch
SHEET_HEIGHT = (210 - 2 * 12) / 25.4 * 96  # px, of the same
LEAD = 200  # px that a heading and some lines take at most
ZOOM = (8.5, 11.5)  # s, the upshift
PIXEL = 0.05  # s; one pixel of a 1200 px wide panel is 0.025 s of 30 s

RANGES = """() => [...document.querySelectorAll(".plot")].map((div) => ({
  id: div.id,
  ranges: Object.keys(div._fullLayout).filter((k) => /^xaxis\\d*$/.test(k))
    .map((k) => div._fullLayout[k].range),
}))"""
LINES = """() => [...document.querySelectorAll(".plot")].map((div) => ({
  id: div.id,
  wanted: div.data.filter((t) => t.mode === "lines").length,
  drawn: [...div.querySelectorAll("svg .scatterlayer .trace")].filter((trace) =>
    [...trace.querySelectorAll(".js-line")].some((path) => path.getTotalLength() > 10)).length,
}))"""


class Visit:
    """A page with everything it complained about or asked the network for."""

    def __init__(self, browser: Browser, file: Path, **options: object) -> None:
        self.page: Page = new_page(browser, viewport=LAPTOP, **options)
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(file.as_uri())
        self.page.wait_for_selector(DRAWN)

    def _console(self, message: object) -> None:
        if message.type in ("error", "warning"):
            self.complaints.append(message.text)

    def foreign(self) -> list[str]:
        """Return requests beyond the page itself and what it holds inside."""
        own = self.page.url.partition("#")[0]
        return [u for u in self.requests if u != own and not u.startswith(("data:", "blob:"))]


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    return report.write(write_all(folder, step=0.001), folder / "report", "All runs")


@pytest.fixture
def visit(browser: Browser, full: Path) -> Iterator[Visit]:
    visited = Visit(browser, full)
    yield visited
    visited.page.close()


@pytest.fixture
def shots(repo_root: Path) -> Path:
    folder = repo_root / "target" / "report-screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_figure_draws_without_complaint(
    browser: Browser, full: Path, shots: Path, scheme: str
) -> None:
    visited = Visit(browser, full, color_scheme=scheme)
    figures = visited.page.evaluate(LINES)
    kinds = {figure["id"].partition("-")[0] for figure in figures}
    assert kinds == {"driveline", "torques", "friction", "tracking", "energy"}
    for figure in figures:
        assert figure["drawn"] == figure["wanted"] > 0, figure
    assert visited.complaints == []
    assert visited.foreign() == []
    visited.page.screenshot(path=shots / f"laptop-{scheme}.png")
    visited.page.screenshot(path=shots / f"page-{scheme}.png", full_page=True)
    visited.page.close()


def test_dark_page_has_dark_figures(browser: Browser, full: Path) -> None:
    visited = Visit(browser, full, color_scheme="light")
    paper = "() => document.querySelector('.plot')._fullLayout.paper_bgcolor"
    light = visited.page.evaluate(paper)
    visited.page.emulate_media(color_scheme="dark")
    visited.page.wait_for_function(f"(light) => ({paper})() !== light", arg=light)
    assert visited.complaints == []
    visited.page.close()


def test_figures_fit_a_laptop(visit: Visit) -> None:
    wide = visit.page.evaluate("document.documentElement.scrollWidth")
    assert wide <= LAPTOP["width"]
    heights = visit.page.eval_on_selector_all(
        ".plot[id^=torques]", "plots => plots.map(p => p.offsetHeight)"
    )
    assert max(heights) <= LAPTOP["height"]


def test_figures_fit_the_sheet_they_are_printed_on(visit: Visit) -> None:
    """A sheet is narrower than a laptop: figures were cut off after 26 of 30 s."""
    sizes = """() => [...document.querySelectorAll(".plot")].map(
      (p) => [p._fullLayout.width, p._fullLayout.height, p.clientWidth, p.clientHeight])"""
    before = visit.page.evaluate(sizes)
    visit.page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    for width, height, *_ in visit.page.evaluate(sizes):
        assert (width, height <= SHEET[1]) == (SHEET[0], True)
    assert_headings_share_the_sheet_of_their_figure(visit.page)
    visit.page.evaluate("window.dispatchEvent(new Event('afterprint'))")
    visit.page.wait_for_function(f"(was) => JSON.stringify(({sizes})()) === JSON.stringify(was)",
                                 arg=before)  # fmt: skip
    visit.page.emulate_media(media="print")
    margins = visit.page.evaluate("""() => [...document.styleSheets[0].cssRules].filter(
      (r) => r instanceof CSSPageRule).map((r) => [r.style.size, r.style.margin])""")
    assert margins == [["a4 landscape", "12mm"]]
    assert visit.complaints == []


def assert_headings_share_the_sheet_of_their_figure(page: Page) -> None:
    """Headings of four sections stood alone on a page, as their figure went to the next."""
    spans = page.evaluate("""() => [...document.querySelectorAll("section")].flatMap((s) => {
      const figure = s.querySelector("figure");
      const top = s.getBoundingClientRect().top;
      const box = figure?.getBoundingClientRect();
      return box ? [[box.top - top, box.bottom - top]] : [];
    })""")
    whole = [bottom for lead, bottom in spans if lead < LEAD]
    assert whole
    assert max(whole) <= SHEET_HEIGHT


def assert_shared(page: Page, start: float, end: float, tolerance: float) -> None:
    for figure in page.evaluate(RANGES):
        for low, high in figure["ranges"]:
            assert low == pytest.approx(start, abs=tolerance), figure
            assert high == pytest.approx(end, abs=tolerance), figure


def await_range(page: Page, start: float, tolerance: float, timeout: float = PATIENCE) -> None:
    page.wait_for_function(
        f"([start, tolerance]) => ({RANGES})().every("
        "(f) => f.ranges.every((r) => Math.abs(r[0] - start) < tolerance))",
        arg=[start, tolerance],
        timeout=timeout,
    )


def test_phase_menu_zooms_every_figure(visit: Visit) -> None:
    visit.page.select_option("#zoom", label="upshift (8.5–11.5 s)")
    await_range(visit.page, ZOOM[0], 1e-9)
    assert_shared(visit.page, *ZOOM, 1e-9)
    visit.page.select_option("#zoom", label="whole scenario")
    await_range(visit.page, 0.0, 1e-9)
    assert_shared(visit.page, 0.0, 30.0, 1e-9)
    assert visit.complaints == []


def test_dragging_in_one_figure_zooms_all(visit: Visit) -> None:
    plot = visit.page.locator(".plot[id^=torques]").first
    plot.scroll_into_view_if_needed()
    box = plot.locator(".nsewdrag").first.bounding_box()
    assert box is not None
    x = [box["x"] + box["width"] * t / 30 for t in ZOOM]
    y = box["y"] + box["height"] / 2
    visit.page.mouse.move(x[0], y)
    visit.page.mouse.down()
    visit.page.mouse.move(x[1], y, steps=8)
    visit.page.mouse.up()
    await_range(visit.page, ZOOM[0], PIXEL)
    assert_shared(visit.page, *ZOOM, PIXEL)
    assert visit.page.eval_on_selector("#zoom", "menu => menu.value") == "custom"
    zoom_out(visit.page, sum(x) / 2, y)
    assert_shared(visit.page, 0.0, 30.0, 1e-9)


def zoom_out(page: Page, x: float, y: float) -> None:
    """Double-click; again where a busy machine let 0.3 s pass between the two clicks."""
    for _ in range(20):
        page.mouse.dblclick(x, y)
        with suppress(TimeoutError):
            await_range(page, 0.0, 1e-9, timeout=PATIENCE / 20)
            return
    raise AssertionError("a double click zooms nothing out")


def test_keyboard_moves_and_zooms(visit: Visit) -> None:
    plot = visit.page.locator(".plot[id^=friction]").first
    plot.focus()
    visit.page.keyboard.press("+")
    await_range(visit.page, 30 / 8, 1e-9)
    visit.page.keyboard.press("ArrowRight")
    await_range(visit.page, 30 / 8 + 22.5 / 10, 1e-9)
    visit.page.keyboard.press("0")
    await_range(visit.page, 0.0, 1e-9)
    assert_shared(visit.page, 0.0, 30.0, 1e-9)


def test_phases_in_sight_are_named_where_they_have_room(visit: Visit) -> None:
    names = (
        """() => [...document.querySelector(".plot")._fullLayout.annotations].map((a) => a.text)"""
    )
    assert {"launch", "upshift", "coast"} <= set(visit.page.evaluate(names))
    visit.page.select_option("#zoom", label="upshift (8.5–11.5 s)")
    await_range(visit.page, ZOOM[0], 1e-9)
    assert visit.page.evaluate(names) == ["upshift"]
    bands = """() => document.querySelector(".plot")._fullLayout.shapes.filter(
      (s) => s.type === "rect" && s.yref === "paper").map((s) => [s.x0, s.x1])"""
    assert [4.0, 8.5] not in visit.page.evaluate(bands)
    assert list(ZOOM) in visit.page.evaluate(bands)


OVERLAPS = """() => [...document.querySelectorAll(".plot")].flatMap((plot) => {
  const names = [...plot.querySelectorAll(".annotation-text")];
  const boxes = names.map((e) => e.getBoundingClientRect());
  return boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) => a.left < b.right
    && b.left < a.right && a.top < b.bottom && b.top < a.bottom).map(() => plot.id));
})"""  # figures whose headings overlap


@pytest.mark.parametrize("width", [420, 768, 1366, 1920])
def test_the_page_has_no_sideways_scroll_at_any_width(
    browser: Browser, full: Path, shots: Path, width: int
) -> None:
    page = new_page(browser, viewport={"width": width, "height": 768})
    page.goto(full.as_uri())
    page.wait_for_selector(DRAWN)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(OVERLAPS) == []
    page.screenshot(path=shots / f"width-{width}.png")
    page.close()


def test_everything_can_be_reached_by_keyboard(visit: Visit) -> None:
    """Tab goes to the skip link, then the links of the page, and opens what is folded."""
    visit.page.keyboard.press("Tab")
    assert visit.page.evaluate("document.activeElement.className") == "skip"
    limits = visit.page.get_by_text("All 13 limits are kept")
    limits.focus()
    visit.page.keyboard.press("Enter")
    assert visit.page.locator("table.limits").is_visible()
    reach = visit.page.evaluate("""() => [...document.querySelectorAll(
      "a[href], select, summary, .plot, .scroll")].every((e) => e.tabIndex >= 0)""")
    assert reach


def test_links_of_the_page_lead_somewhere(visit: Visit) -> None:
    found, missing = visit.page.evaluate("""() => {
      const links = [...document.querySelectorAll("a[href^='#']")]
      const names = links.map((a) => a.getAttribute("href"))
      return [names, names.filter((h) => !document.querySelector(h))]}""")
    assert found
    assert missing == []


def test_tables_have_their_rows(visit: Visit) -> None:
    limits = visit.page.locator("table.limits tbody tr")
    assert limits.count() == 6 + 6 + 1
    verdicts = visit.page.locator("table.overview tbody tr")
    methods = verdicts.locator("td:nth-child(3)").all_inner_texts()
    assert methods == ["paper"] * verdicts.count()
    matrices = visit.page.locator("#kpis table.matrix")
    assert matrices.count() == 4
    scopes = matrices.first.locator("tbody th").all_inner_texts()
    assert scopes[0] == "whole scenario"
    assert "upshift" in scopes
    assert len(scopes) == 1 + 9 + 3
    numbers = matrices.first.locator("tbody tr").first.locator("td").all_inner_texts()
    assert len(numbers) == 15
    assert all(re.match(r"[<>]?\d", number) for number in numbers)
    assert visit.page.locator("table.full").first.locator("tbody tr").count() == 3 * len(scopes)
    assert visit.page.locator("table.wiring tbody tr").count() == 9
    assert visit.page.locator("svg.diagram .box").count() == 4


def test_methods_side_by_side_draw(browser: Browser, shots: Path, tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "methods_case1", "Methods", methods=True, learning=True)
    visited = Visit(browser, report.write([run], tmp_path / "report", "Methods"))
    figures = visited.page.evaluate(LINES)
    assert all(f["drawn"] == f["wanted"] > 0 for f in figures), figures
    assert {f["id"].partition("-")[0] for f in figures} >= {
        "torques",
        "errors",
        "friction",
        "calibration",
    }
    assert visited.page.locator("table.methods tbody tr").count() == 5
    assert "Fig. 10 of the paper" in visited.page.locator("figcaption").nth(1).inner_text()
    visited.page.locator("table.methods").scroll_into_view_if_needed()
    visited.page.screenshot(path=shots / "methods.png")
    assert visited.complaints == []
    visited.page.close()


def test_friction_over_the_position_keeps_its_axis(
    browser: Browser, shots: Path, tmp_path: Path
) -> None:
    """Drawn over the stroke: the time window of the other figures does not move it."""
    closed_loop_runs.run("calibration_worn", (), tmp_path / "run")
    visited = Visit(browser, report.write([tmp_path / "run"], tmp_path / "report", "Worn"))
    page = visited.page
    plot = page.locator(".plot[id^=frictionmap]")
    titles = plot.locator(".infolayer text[class*=title]").all_text_contents()
    assert titles.count("position [mm]") == 2
    page.select_option("#zoom", label="launch (1–4 s)")
    moved = "(f) => f.id.startsWith('torques') && Math.abs(f.ranges[0][0] - 1) < 1e-9"
    page.wait_for_function(f"() => ({RANGES})().some({moved})")
    (own,) = (f for f in page.evaluate(RANGES) if f["id"].startswith("frictionmap"))
    assert own["ranges"] == [[2.0, 10.0]] * 2
    plot.scroll_into_view_if_needed()
    plot.screenshot(path=shots / "friction-map.png")
    assert visited.complaints == []
    page.close()


def test_every_axis_names_its_unit(visit: Visit) -> None:
    titles = visit.page.eval_on_selector_all(
        ".plot .infolayer text[class*=title]",
        "all => all.map((t) => t.textContent).filter(Boolean)",
    )
    assert len(titles) > 20
    assert all(re.search(r"\[.+\]$", title) for title in titles), titles


def test_one_hostile_supplier_run_draws(browser: Browser, tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "supplier", HOSTILE, drop=(".state", ".muF"))
    visited = Visit(browser, report.write([run], tmp_path / "report", HOSTILE))
    assert visited.page.locator("h1").inner_text() == HOSTILE
    assert all(f["drawn"] == f["wanted"] > 0 for f in visited.page.evaluate(LINES))
    assert visited.complaints == []
    visited.page.close()
