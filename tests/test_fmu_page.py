"""`documentation/index.html` of every FMU: well formed, by itself, and complete."""

from __future__ import annotations

import re
import zipfile

import pytest
from fmpy import read_model_description
from fmpy.model_description import ScalarVariable
from importer_cases import MODELS, ROOT, fmu
from lxml import etree

every_model = pytest.mark.parametrize("model", MODELS)
SECTIONS = ["facts", "purpose", "equations", "validity", "inputs", "outputs", "parameters",
            "terminals", "changes"]  # fmt: skip
EQUATIONS = {"DctPlant": ["(1)", "(3)", "(10)", "(11)"], "DctObserver": ["(12)", "(19)", "(29)"],
             "DctClutchControl": ["(21)"]}  # fmt: skip


def _page(model: str) -> etree._Element:
    """Return the page; lxml refuses it unless every element is closed and every name unique."""
    with zipfile.ZipFile(fmu(model)) as archive:
        text = archive.read("documentation/index.html")
    assert text.startswith(b"<!DOCTYPE html>\n")
    return etree.fromstring(text.replace(b"<!DOCTYPE html>\n", b"", 1))


def _texts(element: etree._Element, path: str) -> list[str]:
    return ["".join(found.itertext()) for found in element.findall(path)]


def _start(variable: ScalarVariable) -> str | None:
    """Return the start value, of an enumeration the name of its item."""
    items = variable.declaredType.items if variable.type == "Enumeration" else []
    named = {str(item.value): item.name for item in items}
    return named.get(str(variable.start), variable.start)


@every_model
def test_every_variable_of_the_description_is_in_its_table(model: str) -> None:
    page = _page(model)
    for causality in ("input", "output", "parameter"):
        rows = page.findall(f".//section[@id='{causality}s']//tbody/tr")
        shown = {"".join(row[0].itertext()): [c.text or "" for c in row] for row in rows}
        wanted = [v for v in read_model_description(str(fmu(model))).modelVariables
                  if v.causality == causality]  # fmt: skip
        assert list(shown) == [v.name for v in wanted]
        for variable in wanted:
            cells = shown[variable.name]
            assert cells[-1] == str(variable.valueReference)
            assert cells[-2] == variable.description
            for value in (_start(variable), variable.min, variable.max):
                assert causality == "output" or value is None or str(value) in cells


@every_model
def test_it_explains_the_model_and_links_only_to_what_is_there(model: str) -> None:
    page = _page(model)
    sections = [section.get("id") for section in page.findall(".//section")]
    assert [name for name in sections if name in SECTIONS] == SECTIONS
    numbers = [
        cells.split(",")[0] for cells in _texts(page, ".//table[@class='equations']/*/tr/td")
    ]
    assert set(EQUATIONS[model]) <= set(numbers)
    assert len(page.findall(".//math[@display='block']")) >= 3
    links = {link.get("href") for link in page.iter("a")}
    with zipfile.ZipFile(fmu(model)) as archive:
        members = set(archive.namelist())
    assert {f"#{name}" for name in sections} == {link for link in links if link.startswith("#")}
    files = {f"documentation/{link}" for link in links if not link.startswith("#")}
    assert files < members
    assert len(files) == 3


@every_model
def test_it_loads_nothing_and_runs_nothing(model: str) -> None:
    page = _page(model)
    assert {element.tag for element in page.iter("script", "link", "img", "iframe")} == set()
    assert re.findall(r"url\(|@import|https?://", etree.tostring(page, encoding="unicode")) == []


def test_the_measured_accuracy_is_that_of_the_readme() -> None:
    """The page is measured by the packager, the README's table by the harness."""
    section = _page("DctObserver").find(".//section[@id='accuracy']")
    assert section is not None
    rows = {"".join(row[0].itertext()): _texts(row, "td")[1:] for row in section.iter("tr")}
    assert {"paper", "lyapunov", "energy", "kalman", "calibrating"} < set(rows)
    table = re.findall(r"^\| case \d.*?\| (.*?) \| (.*?) \|$",
                       (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)  # fmt: skip
    assert len(table) == 2
    assert rows["paper"] == [observer for observer, _ in table]
    assert rows["map-based, no observer"] == [map_based for _, map_based in table]


def _accuracy(model: str) -> dict[str, list[str]]:
    section = _page(model).find(".//section[@id='accuracy']")
    assert section is not None
    return {"".join(row[0].itertext()): _texts(row, "td")[1:] for row in section.iter("tr")}


def test_the_plants_figures_are_those_of_held_inputs_and_of_rounding() -> None:
    rows = _accuracy("DctPlant")
    missed = {float(step): float(rows[step][0]) for step in ("10", "5", "1")}
    assert rows["0.1"][0] == "reference"
    for step, percent in missed.items():  # first order in the step that the inputs are held
        assert percent == pytest.approx(missed[10.0] * step / 10.0, rel=0.15)
    assert all(float(rows[step][1]) < 1e-6 for step in ("10", "5", "1", "0.1"))


def test_the_controls_figures_show_what_the_observer_buys() -> None:
    rows = _accuracy("DctClutchControl")
    closed, opened = (
        [float(cell.split()[0]) for cell in rows[name]]
        for name in ("with the observer", "map-based, without")
    )
    assert len(closed) == 2
    assert all(a < 0.25 * b for a, b in zip(closed, opened, strict=True))


def test_changes_are_those_of_the_change_log() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    changes = _page("DctPlant").find(".//section[@id='changes']")
    assert changes is not None
    assert _texts(changes, ".//summary") == re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert changes.findall(".//li")
