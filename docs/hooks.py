"""Pages that are made of what they describe: the command line, the tables, PAPER.md."""

from __future__ import annotations

import argparse
import inspect
import re
import subprocess
from pathlib import Path

from dct_harness import cli
from dct_harness.kpi import registry
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parent.parent
SCHEMAS = ROOT / "tests/harness/dct_harness/schema"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    pages = {
        "reference/cli.md": command_line(),
        "reference/cargo.md": cargo(),
        "reference/kpis.md": _unsigned(registry.markdown()),
        "reference/master.md": _text("src/master/README.md"),
        "reference/variables.md": variables(),
        "paper.md": _text("PAPER.md"),
    }
    pages |= {f"schema/{p.name}": p.read_text(encoding="utf-8") for p in SCHEMAS.glob("*.json")}
    for uri, content in pages.items():
        files.append(File.generated(config, uri, content=content))
    return files


def _unsigned(text: str) -> str:
    """Return a page without the line that says what wrote it."""
    kept = (line for line in text.splitlines() if not line.endswith("; do not edit."))
    return "\n".join(kept) + "\n"


def variables() -> str:
    """Return the tables of variables without the columns that only importers read."""
    told = (
        "Variability, dependencies and value references (vr) stand in "
        "`modelDescription/VARIABLES.md`, and in `documentation/index.html` of each FMU.\n"
    )
    lines = _text("modelDescription/VARIABLES.md").splitlines()
    lines = [line.replace(" vr is the value reference.", "") for line in lines]
    lines = [_shown(line) if line.startswith("|") else line for line in lines]
    return "\n".join(["---", "hide: [toc]", "---", *lines[:1], "", told, *lines[4:]]) + "\n"


def _shown(row: str) -> str:
    """Return a row of VARIABLES.md: name, causality, type, start, min, max, description."""
    cells = re.split(r"(?<!\\) \| ", row.strip("| ") if "---" in row else row[2:-2])
    return f"| {' | '.join(cells[k] for k in (1, 2, 4, 5, 6, 7, 9))} |"


def _text(name: str) -> str:
    """Return a file of the repository; of its links those to pages of the site stay."""
    text = (ROOT / name).read_text(encoding="utf-8")
    text = re.sub(r"\[([^\]]+)\]\((?!https?:|#|docs/pages/)[^)]*\)", r"\1", text)
    return text.replace("](docs/pages/", "](")


def command_line() -> str:
    """Return what each verb of `dct-harness` does, and its help."""
    parser = cli.parser()
    choices = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction)).choices
    parts = ["# dct-harness", _block(parser.format_help())]
    for name, verb in choices.items():
        action = inspect.getdoc(verb.get_default("action")) or ""
        parts += [f"## {name}", _prose(action), _block(verb.format_help())]
    return "\n\n".join(parts) + "\n"


def _prose(text: str) -> str:
    """Return a docstring's sentences; its numpy-style sections stay in the code."""
    return text.partition("\nRaises\n")[0].partition("\nParameters\n")[0].strip()


def cargo() -> str:
    """Return the help of `cargo xtask` and of every command of `cargo fmu`."""
    overview = _help("fmu", "--help")
    commands = re.findall(r"^  (\w+) {2,}", overview.partition("Options:")[0], re.MULTILINE)
    parts = ["# cargo fmu, cargo xtask", "## cargo xtask", _block(_help("xtask", "--help"))]
    parts += ["## cargo fmu", _block(overview)]
    for name in commands:
        if name != "help":
            parts += [f"## cargo fmu {name}", _block(_help("fmu", name, "--help"))]
    return "\n\n".join(parts) + "\n"


def _help(*words: str) -> str:
    done = subprocess.run(
        ["cargo", "-q", *words], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return done.stdout


def _block(text: str) -> str:
    return f"```text\n{text.rstrip()}\n```"
