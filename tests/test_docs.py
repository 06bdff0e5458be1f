"""The docs site: it builds without a warning, asks nobody for anything, and its commands work."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from dct_harness import cli
from dct_harness.kpi import KPIS

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "docs" / "pages"
RESULTS = ROOT / "target" / "docs-run"  # where every page puts them
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```", re.MULTILINE | re.DOTALL)
FOREIGN = re.compile(r'<(?:script|link|img)[^>]+(?:src|href)="https?://([^"/]+)')


def environment() -> dict[str, str]:
    """Return an environment in which this Python's programs come first."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "NO_MKDOCS_2_WARNING": "1"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site; a warning is an error."""
    out = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "-f", "docs/mkdocs.yml", "-d", out],
        cwd=ROOT, env=environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return out


def test_every_page_is_built_and_loads_nothing_foreign(site: Path) -> None:
    built = {p.relative_to(site).with_suffix(".md") for p in site.rglob("*.html")}
    assert {p.relative_to(PAGES) for p in PAGES.rglob("*.md")} < built
    for page in site.rglob("*.html"):
        assert FOREIGN.findall(page.read_text(encoding="utf-8")) == [], page


def test_generated_pages_hold_every_verb_kpi_and_table(site: Path) -> None:
    def page(name: str) -> str:
        return (site / name).read_text(encoding="utf-8")

    verbs = [module.__name__.rpartition(".")[2] for module in cli.VERBS]
    assert len(verbs) > 5
    assert page("reference/cli.html").count("usage: dct-harness") == len(verbs) + 1
    assert all(f"<code>{k.key}</code>" in page("reference/kpis.html") for k in KPIS)
    assert "driveShaft.torque" in page("reference/variables.html")
    for words in ("cargo fmu replay [OPTIONS]", "cargo fmu merge [OPTIONS]", "platforms"):
        assert words in page("reference/cargo.html")
    assert "Deviation" in page("paper.html") or "deviation" in page("paper.html")


def test_the_first_page_leads_to_every_written_page() -> None:
    first = (PAGES / "index.md").read_text(encoding="utf-8")
    pages = {p.relative_to(PAGES).as_posix() for p in PAGES.rglob("*.md")} - {"index.md"}
    assert {page for page in pages if f"({page})" not in first} == set()


@pytest.mark.parametrize("name", sorted(
    str(p.relative_to(PAGES)) for p in PAGES.rglob("*.md") if BLOCK.search(p.read_text("utf-8"))
))  # fmt: skip
def test_commands_of_a_page_work_in_their_order(name: str) -> None:
    """Shell commands together, so that variables last; a Python program by itself."""
    shutil.rmtree(RESULTS, ignore_errors=True)  # of an earlier test: the reader has none either
    blocks = BLOCK.findall((PAGES / name).read_text(encoding="utf-8"))
    shell = "".join(text for language, text in blocks if language == "sh")
    programs = [[sys.executable, "-c", text] for language, text in blocks if language == "python"]
    for command in (["bash", "-euc", shell], *programs):
        done = subprocess.run(
            command, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr


def test_every_example_of_the_help_names_verbs_and_options_that_exist(
    capsys: pytest.CaptureFixture[str],
) -> None:
    examples = []
    for module in cli.VERBS:
        with pytest.raises(SystemExit):
            cli.main(
                [
                    module.__name__.rpartition(".")[2].removesuffix("_verb").replace("_", "-"),
                    "--help",
                ]
            )
        examples += re.findall(r"^  dct-harness (.*)$", capsys.readouterr().out, re.MULTILINE)
    assert len(examples) >= 2 * len(cli.VERBS) - 4
    for example in examples:
        cli.parser().parse_args([word.strip("'") for word in example.split(" > ")[0].split()])


def _pages() -> dict[str, str]:
    """Return every written page of the repository, by its name."""
    listed = ["git", "ls-files", "*.md"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return {name: (ROOT / name).read_text("utf-8") for name in names.split()}


def _shown(program: str) -> list[tuple[str, list[str]]]:
    """Return page and words of each line of a page's blocks that begins with a program."""
    line = re.compile(rf"^ *(?:time )?{program} ((?:[^\n]*\\\n)*[^\n]*)", re.MULTILINE)
    found = [(page, text.replace("\\\n", " ")) for page, whole in _pages().items()
             for text in line.findall(whole)]  # fmt: skip
    return [(page, shlex.split(text.split(" > ")[0], comments=True)) for page, text in found]


def test_commands_of_every_page_name_verbs_options_and_files_that_exist() -> None:
    """Those too that take long, and so are not run by a test."""
    commands = [(page, words) for page, words in _shown("dct-harness") if words != ["--help"]]
    assert len({page for page, _ in commands}) > 12
    for page, words in commands:
        cli.parser().parse_args(words)
        ours = [w for w in words if w.startswith(("examples/", "src/", "tests/", "docs/"))]
        assert [w for w in ours if not (ROOT / w).exists()] == [], page


@pytest.mark.parametrize("program", ["xtask", "fmu"])
def test_chores_that_pages_name_are_there(program: str) -> None:
    asked = ["cargo", "-q", program, "--help"]
    done = subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True)
    known = set(re.findall(r"^  ([a-z]+)\b", done.stdout, re.MULTILINE))
    named = re.compile(rf"(?:^ *|`)cargo {program} ([a-z]+)", re.MULTILINE)
    found = {verb for whole in _pages().values() for verb in named.findall(whole)}
    assert len(found) > 3
    assert found - known == set()
