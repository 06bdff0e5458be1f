"""What ARCHITECTURE.md and the style page promise, as far as a machine can see it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LINES = 400
CODE = (".rs", ".py", ".c", ".h", ".js", ".css", ".j2", ".sh", ".toml", ".md")

# Rust files with unsafe code, with the reason why it is there.
UNSAFE = {
    "src/fmi2/ffi.rs": "the C boundary of every FMU: instances",
    "src/fmi2/ffi/pointer.rs": "the importer's pointers become references",
    "src/fmi2/ffi/real.rs": "a variable is reached by its distance from the start of its model",
    "src/fmi2/ffi/real/other.rs": "the same of Integers and Booleans",
    "src/fmi2/ffi/states.rs": "FMU states at that boundary",
    "src/fmi2/ffi/variables.rs": "variables at that boundary",
    "src/fmi2/ffi/strings.rs": "Strings at that boundary",
    "src/fmi2/ffi/tests.rs": "calls that boundary as an importer does",
    "src/fmi2/ffi/tests/sequences.rs": "random calls at that boundary",
    "src/fmi2/ffi/tests/saved.rs": "random calls with FMU states at that boundary",
    "src/fmi2/ffi/tests/strings.rs": "calls with Strings at that boundary",
    "src/fmi2/ffi/tests/resources.rs": "calls of a model with files at that boundary",
    "src/fmi2/export.rs": "the tokens of the exported functions, which call ffi.rs",
    "examples/ecu_observer/lib.rs": "three exported C names: the attribute, and no unsafe block",
    "tests/fuzz/importer.rs": "random calls at that boundary, with the models of this project",
    "tests/fuzz/importer/saved.rs": "random calls with FMU states at that boundary",
    "tests/fuzz/packages.rs": "tells the checker where to unpack",
    "src/master/raw/lib.rs": "the master's calls of FMUs, on the raw binding of the `fmi` crate",
    "src/master/raw/log.rs": "what FMUs say to the master, from C",
    "src/master/raw/memory.rs": "the master tells the processor what it will write",
    "fmu-build/check/native.rs": "loads FMUs of any origin through their C interface",
    "fmu-build/check/native/abilities.rs": "what of that interface an FMU need not have",
    "fmu-build/check/native/asynchronous.rs": "steps that an FMU goes on computing",
}

# The packages that may depend on each other: every other edge is a hole in a wall.
WALLS = {
    "dct-driveline": {"nalgebra"},
    "fmi2-cosim": set(),
    "dct-models": {"dct-driveline", "fmi2-cosim"},
    "dct-plant": {"dct-models", "fmi2-cosim"},
    "dct-observer": {"dct-models", "fmi2-cosim"},
    "dct-clutch-control": {"dct-models", "fmi2-cosim"},
    "bench-empty": {"fmi2-cosim"},
    "xtask": set(),
}
FMU_CRATES = {
    "dct-plant": "Plant", "dct-observer": "Observer", "dct-clutch-control": "ClutchControl",
}  # fmt: skip
OUTSIDE_AN_FMU = {"serde", "serde_json", "quick-xml", "zip", "fmi", "clap", "libloading", "object"}

CARD = (
    "Cargo.toml", "src", "modelDescription", "fmu-build", "tests", "examples", "benches", "xtask",
    "README.md", "ARCHITECTURE.md", "PAPER.md", "CHANGELOG.md", "CITATION.cff", "LICENSE-MIT",
    "LICENSE-APACHE", ".ci/run", ".cargo/config.toml", "rustfmt.toml",
)  # fmt: skip

# What no file may hold: a pattern, and what it would mean. Split, so that this file passes.
FORBIDDEN = {
    "\\.\\./" "shared": "the workplace",
    "(?<![\\w.])/" "work/": "the workplace",
    "\\bTO" "DO\\b|\\bFIX" "ME\\b|\\bto" "do!|\\bunim" "plemented!": "unfinished work",
    "#\\[ig" "nore|mark\\.(sk" "ip|xf" "ail)|pytest\\.sk" "ip\\(": "a test that does not run",
    "\\bdbg" "!\\(|break" "point\\(\\)": "debugging",
}  # fmt: skip
DRIVELINE_WORDS = re.compile(r"clutch|driveline|gear|vehicle|engine|slipping|wheel", re.IGNORECASE)
FMI_WORDS = re.compile(r"\bfmi|importer|\bvalue reference", re.IGNORECASE)
IMPURE = re.compile(r"\bstd::|\balloc::|\b(Vec|Box|String|Rc|Arc)\b|\bformat!|println!")


@cache
def _files(*suffixes: str) -> tuple[str, ...]:
    """Return the committed files with one of these endings, relative to the root."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    names = listed.stdout.decode().split("\0")[:-1]
    return tuple(n for n in names if n.endswith(suffixes) and (ROOT / n).is_file())


def _text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def _rust_code(name: str) -> str:
    """Return a Rust file without its comments."""
    return re.sub(r"//.*", "", _text(name))


def test_files_are_found() -> None:
    assert len(_files(".rs")) > 50
    assert len(_files(".py")) > 20


def test_files_are_short() -> None:
    """All but the table of all variables, which is generated."""
    written = [n for n in _files(*CODE) if n != "modelDescription/VARIABLES.md"]
    assert [n for n in written if len(_text(n).splitlines()) > LINES] == []


def test_unsafe_code_is_where_it_is_known_to_be() -> None:
    word = re.compile(r"\bunsafe\b")
    assert {n for n in _files(".rs") if word.search(_rust_code(n))} == set(UNSAFE)


@pytest.mark.parametrize("pattern", FORBIDDEN, ids=FORBIDDEN.values())
def test_no_file_holds(pattern: str) -> None:
    word = re.compile(pattern)
    assert [n for n in _files(*CODE, ".csv", ".json", ".html") if word.search(_text(n))] == []


def test_the_fmi_room_never_meets_a_clutch() -> None:
    names = [n for n in _files(".rs", ".md", ".toml") if n.startswith("src/fmi2/")]
    assert [n for n in names if DRIVELINE_WORDS.search(_text(n))] == []


def _driveline() -> list[str]:
    """Return the files of the driveline that are neither tests nor programs."""
    names = (n for n in _files(".rs") if n.startswith("src/driveline/"))
    return [n for n in names if not any(f"/{d}/" in n for d in ("tests", "benches", "examples"))]


def test_the_driveline_never_meets_fmi() -> None:
    assert [n for n in _driveline() if FMI_WORDS.search(_text(n))] == []


def test_the_driveline_has_no_standard_library() -> None:
    assert "#![no_std]" in _text("src/driveline/lib.rs")
    assert "#![forbid(unsafe_code)]" in _text("src/driveline/lib.rs")
    found = {n: IMPURE.findall(_rust_code(n).split("#[cfg(test)]")[0]) for n in _driveline()}
    assert {n: words for n, words in found.items() if words} == {}


@cache
def _metadata() -> dict:
    command = ["cargo", "metadata", "--format-version", "1", "--locked"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def _dependencies(package: str) -> set[str]:
    """Return what a package depends on when it is used, not tested."""
    (found,) = (p for p in _metadata()["packages"] if p["name"] == package)
    return {d["name"] for d in found["dependencies"] if d["kind"] != "dev"}


def _reachable(package: str) -> set[str]:
    """Return every package that is linked into a package."""
    names = {p["id"]: p["name"] for p in _metadata()["packages"]}
    edges = {node["id"]: node["deps"] for node in _metadata()["resolve"]["nodes"]}
    (start,) = (identifier for identifier, name in names.items() if name == package)
    seen, open_ends = set(), [start]
    while open_ends:
        node = open_ends.pop()
        if node not in seen:
            seen.add(node)
            linked = (d for d in edges[node] if any(k["kind"] is None for k in d["dep_kinds"]))
            open_ends += [d["pkg"] for d in linked]
    return {names[node] for node in seen}


@pytest.mark.parametrize("package", WALLS)
def test_walls_hold(package: str) -> None:
    assert _dependencies(package) == WALLS[package]


@pytest.mark.parametrize("package", FMU_CRATES)
def test_an_fmu_links_no_tool(package: str) -> None:
    assert _reachable(package) & OUTSIDE_AN_FMU == set()
    assert "nalgebra" in _reachable(package)


def test_nobody_depends_on_an_fmu_crate() -> None:
    for package in _metadata()["packages"]:
        named = {dependency["name"] for dependency in package["dependencies"]}
        assert not named & set(FMU_CRATES), package["name"]


def test_the_compiled_master_knows_fmus_as_files() -> None:
    ours = {p["name"] for p in _metadata()["packages"] if p["source"] is None}
    tables = re.split(r"^\[", _text("src/master/Cargo.toml"), flags=re.MULTILINE)
    names = {line.split("=")[0].strip() for table in tables if "dependencies]" in table
             for line in table.splitlines()[1:] if "=" in line}  # fmt: skip
    assert "fmi" in names
    assert names & ours == set()


@pytest.mark.parametrize("crate", FMU_CRATES)
def test_an_fmu_crate_is_one_macro_call(crate: str) -> None:
    lines = [line for line in _rust_code(f"src/fmus/{crate}/lib.rs").splitlines() if line.strip()]
    assert lines == [f"fmi2_cosim::export!(dct_models::{FMU_CRATES[crate]});"]


@pytest.mark.parametrize("name", CARD)
def test_the_design_card_is_complete(name: str) -> None:
    assert (ROOT / name).exists()


def test_the_two_licences_are_what_the_packages_say() -> None:
    assert "Permission is hereby granted" in _text("LICENSE-MIT")
    assert "Apache License" in _text("LICENSE-APACHE")
    ours = [p for p in _metadata()["packages"] if p["source"] is None]
    assert {p["license"] for p in ours} == {"MIT OR Apache-2.0"}


def test_where_things_are_is_told_as_it_is() -> None:
    """A word in backquotes behind a file is in that file."""
    page = _text("ARCHITECTURE.md").partition("## Where is")[2].partition("\n## ")[0]
    found = re.findall(r"`([\w/.]+/[\w.]+)`(?: `(\w+)`)?", page)
    assert len(found) > 20
    missing = [f"{name}: {word}" for name, word in found
               if not (ROOT / name).is_file() or word not in _text(name)]  # fmt: skip
    assert missing == []


@pytest.mark.parametrize("room", ["src/driveline/", "src/driveline/observer/", "src/models/"])
def test_every_file_of_a_room_has_its_line(room: str) -> None:
    names = [n.removeprefix(room) for n in _files(".rs") if n.startswith(room)]
    files = [n for n in names if "/" not in n and n not in ("lib.rs", "mod.rs")]
    card = _text("ARCHITECTURE.md")
    assert [n for n in files if not re.search(rf"(?<!\w){re.escape(n)}", card)] == []


def _commands() -> list[list[str]]:
    """Return the commands of README.md, split into words, without their remarks."""
    lines = re.findall(r"^    ((?:cargo|dct-harness|python) .*)$", _text("README.md"), re.MULTILINE)
    return [line.split("#")[0].split() for line in lines]


def _run(words: list[str]) -> subprocess.CompletedProcess:
    """Run a command with the programs of the Python environment first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(words, cwd=ROOT, env={**os.environ, "PATH": path}, check=False,
                          capture_output=True, text=True)  # fmt: skip


def test_readme_names_the_two_commands_and_the_chores_have_them() -> None:
    chores = [words[2] for words in _commands() if words[:2] == ["cargo", "xtask"]]
    assert chores == ["demo", "test"]
    helped = _run(["cargo", "xtask", "--help"]).stdout
    assert all(re.search(rf"^  {chore}\b", helped, re.MULTILINE) for chore in chores)


def test_readme_installs_a_package_that_is_there() -> None:
    installed = [words[-1] for words in _commands() if "install" in words]
    assert installed
    assert all((ROOT / path / "pyproject.toml").is_file() for path in installed)


def _quick(words: list[str]) -> bool:
    examples = words[0] == "python" and words[1].startswith("examples/")
    return examples or words[0] == "dct-harness" or words[:3] == ["cargo", "fmu", "check"]


@pytest.mark.parametrize("words", list(filter(_quick, _commands())), ids=" ".join)
def test_a_command_of_readme_works(words: list[str]) -> None:
    if words[:2] == ["dct-harness", "run"] and "--out" not in words:
        words = [*words, "--out", "target/readme"]
    done = _run(words)
    assert done.returncode == 0, done.stdout + done.stderr
