"""`dct-harness export-ssp`: a system with everything it needs as one SSP 1.0 file."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..ssp.export import Export
from . import selection
from .arguments import Verbs, add_loudness, called, say, say_outdated, verb

EXAMPLES = """export-ssp examples/closed_loop/paper_case1.toml --out target/paper_case1.ssp
export-ssp loop.toml --plant Antrieb.fmu --map antrieb.toml
run target/paper_case1.ssp"""

CODES = "0 written, 2 usage or configuration, 3 FMU invalid"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "write a system, its FMUs, values and scenario as one .ssp"
    parser = verb(verbs, "export-ssp", export, text, EXAMPLES, CODES)
    selection.add_options(parser)
    parser.add_argument("--out", type=called(".ssp"), metavar="FILE",
                        help="file to write (target/NAME.ssp)")  # fmt: skip
    add_loudness(parser, "file and components")


def export(args: argparse.Namespace) -> int:
    """Write the file and say where it is."""
    with selection.opened(args) as (model, paths, names, _):
        out = args.out or Path("target") / f"{model.name}.ssp"
        Export(model, paths, names).write(out)
        say_outdated(args, paths.values())
    say(args, f"{out}: {len(paths)} components, runs with `dct-harness run {out}`",
        {"file": str(out), "components": list(paths)})  # fmt: skip
    return 0
