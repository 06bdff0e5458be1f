"""What people cite: figures of the front page, how to make each again, and CITATION.cff."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from dct_harness import cli

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs/pages"
GENERATED = {"paper.md": "PAPER.md"}  # pages of the site that are files of the repository
CELLS = ("figure", "command", "expected", "source", "test")
FIGURES = re.compile(r"\d+(?:\.\d+)?(?: ?/ ?\d+(?:\.\d+)?)+|\d+\.\d+|\d{2,}(?= N·m| %| runs)")
MADE = "target/"  # files that a command of the page makes


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def _rows() -> list[dict[str, str]]:
    """Return the rows of the table of the page, by CELLS."""
    lines = re.findall(r"^\| (.*) \|$", text("docs/pages/reproduce.md"), re.MULTILINE)
    return [dict(zip(CELLS, line.split(" | "), strict=True)) for line in lines[2:]]


ROWS = _rows()
every_row = pytest.mark.parametrize("row", ROWS, ids=[row["figure"] for row in ROWS])


def _source(cell: str) -> str:
    """Return the file in which the figure stands."""
    linked = re.search(r"\]\(([^)#]+)", cell)
    if linked is None:
        return cell
    return GENERATED.get(linked[1], f"docs/pages/{linked[1]}")


@every_row
def test_an_expected_figure_is_the_one_that_stands_in_full_elsewhere(row: dict[str, str]) -> None:
    known = re.sub(r"\s*/\s*", "/", text(_source(row["source"])))
    for figure in FIGURES.findall(row["expected"].replace(" / ", "/")):
        parts = [figure] if figure in known else figure.split("/")  # a table has them in cells
        assert all(re.search(rf"(?<![\d.]){re.escape(p)}(?![\d])", known) for p in parts), figure


@every_row
def test_what_a_row_names_is_there(row: dict[str, str]) -> None:
    assert (ROOT / row["test"].strip("`")).is_file()
    program, *words = shlex.split(row["command"].strip("`"))
    named = [word for word in words if "/" in word and not word.startswith(MADE)]
    assert [word for word in named if not (ROOT / word).is_file()] == []
    if program == "dct-harness":
        cli.parser().parse_args(words)
    elif program == "cargo" and "--test" in words:
        assert (ROOT / f"src/driveline/tests/{words[-1]}.rs").is_file()
    elif program == "cargo" and "--example" in words:
        assert (ROOT / f"src/driveline/examples/{words[-1]}.rs").is_file()
    else:
        assert program == "python" or words in (["xtask", "bench"],)


def test_the_check_of_the_reference_runs_as_it_is_written() -> None:
    (words,) = (w for row in ROWS if "golden" in (w := shlex.split(row["command"].strip("`")))[1])
    done = subprocess.run([sys.executable, *words[1:]], cwd=ROOT, capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "against Radau" in done.stdout


def test_most_rows_hold_figures() -> None:
    assert len(ROWS) > 12
    assert sum(bool(FIGURES.search(row["expected"])) for row in ROWS) > 9


def test_readme_tells_what_an_engine_inertia_costs_as_papers_table_does() -> None:
    heading = re.search(r"^\| paper's scenario \| (.*) \|$", text("PAPER.md"), re.MULTILINE)
    row = re.search(r"^\| J_e \+20 % \| (.*) \|$", text("PAPER.md"), re.MULTILINE)
    cost = dict(zip(heading[1].split(" | "), row[1].split(" | "), strict=True))
    kalman, calibrating = (cost[m].replace("/", " / ") for m in ("kalman", "calibrating"))
    readme = " ".join(text("README.md").split())
    assert f"errs by {kalman} %" in readme
    assert f"stays at {calibrating} %" in readme


def test_readme_tells_of_the_study_what_its_page_does() -> None:
    page, readme = text("docs/pages/study.md"), " ".join(text("README.md").split())
    runs = int(re.search(r"^(\d+) runs of", page, re.MULTILINE)[1])
    lines = re.findall(r"^\| (\w+ \| [\d.]+ / .*) \|$", page, re.MULTILINE)
    rows = [line.split(" | ") for line in lines]
    worst = {r[0]: max(float(cell.split(" / ")[2]) for cell in r[1::2]) for r in rows}
    kept = {r[0]: [float(share.removesuffix("%")) for share in r[2::2]] for r in rows}
    assert f"of {runs:,} runs with seven errors" in readme
    assert kept.pop("calibrating") == [100.0, 100.0, 100.0]
    assert f"in all runs ({worst['calibrating']:.1f} % at worst)" in readme
    assert "each other method in less than half of them" in readme
    assert len(kept) == 4
    assert all(max(shares) < 50 for shares in kept.values())


def test_the_first_lines_of_readme_tell_what_its_table_and_the_demo_do() -> None:
    readme = text("README.md")
    (believed, true, observer, map_based), _ = re.findall(
        r"^\| case \d: (.*?); true (.*?) \| (.*?) \| (.*?) \|$", readme, re.MULTILINE)  # fmt: skip
    shaft = [errors.split(" / ")[2] for errors in (map_based, observer)]
    first = " ".join(readme.partition("## ")[0].split())
    assert (f"believed {believed.replace(', ', ' and ')} but is {true.replace(', ', ' and ')}, "
            f"a torque map misses the drive-shaft torque by {shaft[0]} % of its RMS, "
            f"the observer by {shaft[1]} %") in first  # fmt: skip
    runs = re.search(r"^const RUNS: .*; (\d+)\] =", text("xtask/demo.rs"), re.MULTILINE)[1]
    assert f"runs {runs} closed loops" in first


def test_the_citation_is_of_this_version_and_of_the_paper() -> None:
    cited = yaml.safe_load(text("CITATION.cff"))
    done = subprocess.run(["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"],
                          cwd=ROOT, capture_output=True, text=True, check=True)  # fmt: skip
    packages = json.loads(done.stdout)["packages"]
    assert {p["version"] for p in packages if p["name"].startswith("dct-")} == {cited["version"]}
    assert {" OR ".join(cited["license"])} == {p["license"] for p in packages}
    assert cited["cff-version"] == "1.2.0"
    assert text("README.md").startswith(f"# {cited['title']}\n")
    (author,) = cited["authors"]
    assert f"Copyright (c) 2026 {author['name']}" in text("LICENSE-MIT")
    (paper,) = cited["references"]
    assert all(
        f'"{paper["title"]}"' in " ".join(text(n).split()) for n in ("README.md", "PAPER.md")
    )
