"""`dct-harness check`: is one FMU valid, does it load, what does it offer."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .against import Finding
from .arguments import Verbs, verb

BROKEN = 1  # contract
INVALID = 3


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "check", check, "validate and load one FMU",
                  "check target/fmu/DctPlant.fmu\n"
                  "check Supplier.fmu --against plant --map supplier.toml")  # fmt: skip
    parser.add_argument("fmu", type=Path)
    parser.add_argument("--against", choices=["plant"], help="hold it to the contract of a plant")
    parser.add_argument("--map", type=Path, help="mapping file (.toml) of that plant's names")


def check(args: argparse.Namespace) -> int:
    """Print the faults of an FMU and what it offers; returns 3 when it is invalid.

    With --against: 1 when it breaks the contract.
    """
    if args.against:
        return _against(args)
    from fmpy.validation import validate_fmu

    from .isolated import load

    fmu = load("check", args.fmu)
    try:
        problems = validate_fmu(str(args.fmu))
        for text in problems:
            print(text, file=sys.stderr)
        for variable in (*fmu.inputs, *fmu.outputs):
            print(f"{variable.causality:7} {variable.type:11} {variable.name}")
    finally:
        fmu.close()
    return INVALID if problems else 0


def _against(args: argparse.Namespace) -> int:
    """Print the contract of a plant; returns 1 when the plant breaks it."""
    from . import against, mapping, sanity
    from .archive import described
    from .isolated import load
    from .mapped import Mapped

    description = described(args.fmu)
    names = mapping.load(args.map) if args.map else against.identity(description, args.fmu)
    found = against.findings(description, names, same_names=args.map is None)
    _table(("variable", "the FMU's", "contract"), found)
    if not any(f.fault for f in found):
        signs = sanity.signs(lambda: Mapped(load("plant", args.fmu), names))
        print()
        _table(("sign", "signal", "manoeuvre"), signs)
        found += signs
    faults = sum(f.fault for f in found)
    print(f"\nverdict: {f'{faults} faults' if faults else 'a plant that the observer can use'}")
    return BROKEN if faults else 0


def _table(head: tuple[str, str, str], found: list[Finding]) -> None:
    rows = [head, *((f.name, f.theirs or "-", f.verdict) for f in found)]
    widths = [max(len(row[k]) for row in rows) for k in (0, 1)]
    for first, second, verdict in rows:
        print(f"{first:{widths[0]}}  {second:{widths[1]}}  {verdict}")
