"""Line and column of every key in a TOML file, against what the parser found in it."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest
from dct_harness.system import tomlfile
from dct_harness.system.tomlplaces import places

TRICKY = r'''# a = 1
title = "not # a comment, [nor] a.table = {}"
a.b . "c.d" = 1
"k\u00e9y \"x\"" = 'C:\path'
text = """
[no.header]
no = "key" \"""
""""
raw = \'\'\'it's # [raw]\'\'\'
when = 1979-05-27 07:32:00.5
list = [ 1, # one
  [2, "]"], {x = {y = 3}, z = [4]}, 1979-05-27,
]
[ table . 'x.y' ]
inner = {p = "}", q = -inf}
[[many]]
n = 1
[many.sub]
s = 0x1F
[[many]]
n = 2
[[many.deep]]
d = true
[[many.deep]]
d = false
'''.replace("\\'\\'\\'", "'''")


def keys(value: Any, head: tuple[str | int, ...] = ()) -> set[tuple[str | int, ...]]:
    """Return the path of everything in parsed data."""
    if isinstance(value, dict):
        inner = value.items()
    else:
        inner = enumerate(value) if isinstance(value, list) else ()
    return {head}.union(*(keys(v, (*head, k)) for k, v in inner))


def texts(root: Path) -> dict[str, str]:
    """Return the tricky text and every TOML file of the project; those of target/ come and go."""
    listed = ["git", "ls-files", "-z", "*.toml"]
    done = subprocess.run(listed, cwd=root, capture_output=True, text=True, check=True)
    names = done.stdout.split("\0")[:-1]
    assert len(names) > 15
    return {"tricky": TRICKY, **{n: (root / n).read_text(encoding="utf-8") for n in names}}


def test_every_key_of_every_file_has_a_place(repo_root: Path) -> None:
    for name, text in texts(repo_root).items():
        assert set(places(text)) == keys(tomlfile.loads(text)) - {()}, name


@pytest.mark.parametrize(("path", "line", "column"), [
    (("title",), 2, 1),
    (("a", "b", "c.d"), 3, 7),
    (('kéy "x"',), 4, 1),
    (("list", 0), 11, 10),
    (("list", 2, "x", "y"), 12, 19),
    (("list", 2, "z", 0), 12, 32),
    (("table", "x.y", "inner", "q"), 15, 19),
    (("many",), 16, 1),
    (("many", 0, "sub", "s"), 19, 1),
    (("many", 1), 20, 1),
    (("many", 1, "deep", 1, "d"), 25, 1),
    (("many", 1, "none"), 20, 1),  # what it would stand in
])  # fmt: skip
def test_a_key_is_where_an_editor_shows_it(
    path: tuple[str | int, ...], line: int, column: int
) -> None:
    assert places(TRICKY).find(*path) == (line, column)


def test_a_key_that_nothing_holds_has_no_place() -> None:
    assert places(TRICKY).find("none") is None
