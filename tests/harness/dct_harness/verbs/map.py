"""`dct-harness map`: a mapping file to start from, for a supplier's plant."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .. import results
from ..contract import plant
from ..errors import ConfigError
from ..fmu.archive import described
from ..supplier import skeleton
from .arguments import Verbs, verb

CODES = "0 written, 2 a file cannot be read or exists already, 3 no FMU"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "map", make, "write a mapping file for a supplier's plant to start from",
                  "map Supplier.fmu\nmap Supplier.fmu --out supplier.toml", CODES)  # fmt: skip
    parser.add_argument("fmu", type=Path, help="the supplier's plant")
    parser.add_argument("--out", type=Path, metavar="FILE", help="file to write (standard output)")
    parser.add_argument("-q", "--quiet", action="store_true", help="print errors only")


def make(args: argparse.Namespace) -> int:
    """Write the skeleton; an existing file is kept."""
    text = skeleton.text(plant(), described(args.fmu), args.fmu)
    if args.out is None:
        sys.stdout.write(text)
        return 0
    if args.out.exists():
        raise ConfigError(f"{args.out}: exists already; name another file or remove it")
    results.write_text(args.out, text)
    if not args.quiet:
        print(f"mapping to be completed: {args.out}")
    return 0
