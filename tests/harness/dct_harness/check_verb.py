"""`dct-harness check`: is one FMU valid, does it load, what does it offer."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .arguments import Verbs, verb

INVALID = 3


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "check", check, "validate and load one FMU",
                  "check target/fmu/DctPlant.fmu")  # fmt: skip
    parser.add_argument("fmu", type=Path)


def check(args: argparse.Namespace) -> int:
    """Print the faults and the inputs and outputs of an FMU; returns 3 when it has faults."""
    from fmpy.validation import validate_fmu

    from .fmu import Fmu

    fmu = Fmu("check", args.fmu)
    try:
        problems = validate_fmu(str(args.fmu))
        for text in problems:
            print(text, file=sys.stderr)
        for variable in (*fmu.inputs, *fmu.outputs):
            print(f"{variable.causality:7} {variable.type:11} {variable.name}")
    finally:
        fmu.close()
    return INVALID if problems else 0
