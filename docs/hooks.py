"""Pages that are made of what they describe: the command line, the tables, PAPER.md."""

from __future__ import annotations

import argparse
import re
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
        "reference/kpis.md": registry.markdown(),
        "reference/variables.md": _text("modelDescription/VARIABLES.md"),
        "paper.md": _text("PAPER.md"),
    }
    pages |= {f"schema/{p.name}": p.read_text(encoding="utf-8") for p in SCHEMAS.glob("*.json")}
    for uri, content in pages.items():
        files.append(File.generated(config, uri, content=content))
    return files


def _text(name: str) -> str:
    """Return a file of the repository; links to its other files become their names."""
    text = (ROOT / name).read_text(encoding="utf-8")
    return re.sub(r"\[([^\]]+)\]\((?!https?:|#)[^)]*\)", r"\1", text)


def command_line() -> str:
    """Return the help of `dct-harness` and of each verb."""
    parser = cli.parser()
    choices = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction)).choices
    parts = ["# Command line", _block(parser.format_help())]
    for name, verb in choices.items():
        parts += [f"## {name}", _block(verb.format_help())]
    return "\n\n".join(parts) + "\n"


def _block(text: str) -> str:
    return f"```text\n{text.rstrip()}\n```"
