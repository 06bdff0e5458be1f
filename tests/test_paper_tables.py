"""Tables of what errors cost each observer method are those of the example, on every page."""

from __future__ import annotations

import re
import subprocess
from itertools import zip_longest
from pathlib import Path

import pytest

EXAMPLE = ("cargo", "run", "--release", "--quiet", "-p", "dct-driveline", "--example", "robustness")
PAGES = {  # the first cells of the headings
    "PAPER.md": ("paper's scenario", "no error", "calibrating"),
    "docs/pages/accuracy.md": ("creep", "random 2", "no error, 100 Hz", "noise 0.1 rad/s"),
}
RENEW = f"{' '.join(EXAMPLE)} -- {' '.join(PAGES)}"
NUMBER = re.compile(r"\d+(?:\.(\d+))?")

Table = list[str]


@pytest.fixture(scope="module")
def computed(repo_root: Path) -> dict[str, Table]:
    """Return the tables that the example prints, by their headings."""
    done = subprocess.run(EXAMPLE, cwd=repo_root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return _tables(done.stdout)


def _tables(text: str) -> dict[str, Table]:
    """Return the rows below each heading of a Markdown table, without its rule."""
    blocks = re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE)
    return {block.splitlines()[0]: block.splitlines()[2:] for block in blocks}


def _differs(found: str | None, expected: str | None) -> bool:
    """Return whether two rows differ by more than one unit of a last printed digit.

    As much may a last bit of another machine's libm change; what changes an observer moves more.
    """
    if found is None or expected is None:
        return True
    (name, cells), (known, right) = (row.split(" | ", 1) for row in (found, expected))
    if name != known or NUMBER.sub("#", cells) != NUMBER.sub("#", right):
        return True
    pairs = zip(NUMBER.finditer(cells), NUMBER.finditer(right), strict=True)
    return any(_apart(one, other) for one, other in pairs)


def _apart(one: re.Match[str], other: re.Match[str]) -> bool:
    unit = max(10.0 ** -len(m.group(1) or "") for m in (one, other))
    return abs(float(one.group()) - float(other.group())) > 1.01 * unit


def _told(name: str, found: Table, expected: Table) -> list[str]:
    rows = zip_longest(found, expected)
    return [f"{name}: the page has {one}, computed is {other}"
            for one, other in rows if _differs(one, other)]  # fmt: skip


@pytest.mark.parametrize("page", PAGES)
def test_the_tables_are_those_that_the_example_computes(
    page: str, repo_root: Path, computed: dict[str, Table]
) -> None:
    written = _tables((repo_root / page).read_text(encoding="utf-8"))
    shared = [heading for heading in computed if heading in written]
    assert tuple(heading[2:].split(" | ")[0] for heading in shared) == PAGES[page]
    found = [line for h in shared for line in _told(h, written[h], computed[h])]
    assert found == [], f"renew them with `{RENEW}`"


def test_every_computed_table_stands_on_a_page(computed: dict[str, Table]) -> None:
    told = sorted(heading[2:].split(" | ")[0] for heading in computed)
    assert told == sorted(name for names in PAGES.values() for name in names)


@pytest.mark.parametrize(("found", "expected", "differs"), [
    ("| M_v +10 % | 2.5/3.3 | 12/0.0 |", "| M_v +10 % | 2.4/3.4 | 11/0.1 |", False),
    ("| M_v +10 % | 2.5/3.3 | 12/0.0 |", "| M_v +10 % | 2.3/3.3 | 12/0.0 |", True),
    ("| M_v +10 % | 2.5/3.3 | 12/0.0 |", "| M_v +10 % | 2.5/3.3 | 14/0.0 |", True),
    ("| M_v +10 % | 9.9/3.3 |", "| M_v +10 % | 10/3.3 |", False),
    ("| M_v +10 % | 2.5/3.3 |", "| M_v +20 % | 2.5/3.3 |", True),
    ("| M_v +10 % | 2.5/3.3 |", "| M_v +10 % | 2.5/– |", True),
    ("| M_v +10 % | 2.5/3.3 |", None, True),
])  # fmt: skip
def test_one_unit_of_the_last_digit_is_no_difference(
    found: str, expected: str | None, differs: bool
) -> None:
    assert _differs(found, expected) == differs


def test_a_row_that_was_changed_is_named(computed: dict[str, Table]) -> None:
    heading, rows = next(iter(computed.items()))
    changed = [rows[0].replace("2.5/", "2.9/", 1), *rows[1:-1]]
    told = _told(heading, changed, rows)
    assert [line.count(name) for line, name in zip(told, ("2.9/", "None"), strict=True)] == [1, 1]
