"""`dct-harness check`: is one FMU valid, does it load, what does it offer."""

from __future__ import annotations

import argparse
import sys
from dataclasses import asdict
from pathlib import Path

from ..fmu.values import unit_of
from ..kpi.table import aligned
from ..supplier.against import Finding
from .arguments import Verbs, add_loudness, say, say_outdated, verb

BROKEN = 1  # contract
INVALID = 3
HEAD = ["causality", "type", "variable", "unit"]

CODES = """0 valid, 1 the contract is broken (--against),
2 a file cannot be read, 3 FMU invalid, 4 its code fails, 5 its code hangs,
6 no binary for this platform"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "check", check, "validate and load one FMU",
                  "check target/fmu/DctPlant.fmu\n"
                  "check Supplier.fmu --against plant --map supplier.toml", CODES)  # fmt: skip
    parser.add_argument("fmu", type=Path, help="the FMU")
    parser.add_argument(
        "--against",
        choices=["plant"],
        help="also look for the signals that the observer needs of a plant, their units and signs",
    )
    parser.add_argument("--map", type=Path, metavar="FILE",
                        help="mapping file (.toml) of that plant's names")  # fmt: skip
    add_loudness(parser, "problems and variables, or the lines of the contract")


def check(args: argparse.Namespace) -> int:
    """Print the faults of an FMU and what it offers; returns 3 when it is invalid.

    With --against: 1 when it breaks the contract.
    """
    say_outdated(args, [args.fmu])
    if args.against:
        return _against(args)
    from ..fmu.faults import faults
    from ..fmu.isolated import load

    fmu = load("check", args.fmu)
    fmu.close()
    problems = faults(fmu.description)
    for text in problems:
        print(text, file=sys.stderr)
    offered = [{"causality": v.causality, "type": v.type, "name": v.name, "unit": unit_of(v)}
               for v in (*fmu.inputs, *fmu.outputs)]  # fmt: skip
    rows = [[v["causality"], v["type"], v["name"], v["unit"]] for v in offered]
    say(args, aligned(HEAD, rows, lambda _: False), {"problems": problems, "variables": offered})
    return INVALID if problems else 0


def _against(args: argparse.Namespace) -> int:
    """Print the contract of a plant; returns 1 when the plant breaks it."""
    from ..fmu.archive import described
    from ..fmu.isolated import load
    from ..supplier import against, mapping, sanity
    from ..supplier.mapped import Mapped

    description = described(args.fmu)
    names = mapping.load(args.map) if args.map else against.identity(description, args.fmu)
    found = against.findings(description, names, same_names=args.map is None)
    parts = [_table(["variable", "the FMU's", "contract"], found)]
    if not any(f.fault for f in found):
        signs = sanity.signs(lambda: Mapped(load("plant", args.fmu), names), names.known)
        parts.append(_table(["sign", "signal", "manoeuvre"], signs))
        found += signs
    faults = sum(f.fault for f in found)
    kept = against.untold(names) if args.map else []
    parts += [_kept(kept, bool(names.share))] if kept else []
    verdict = f"{faults} faults" if faults else "a plant that the observer can use"
    say(args, "\n\n".join([*parts, f"verdict: {verdict}"]),
        {"faults": faults, "lines": [asdict(f) for f in found], "untold": kept})  # fmt: skip
    return BROKEN if faults else 0


def _kept(names: list[str], shared: bool) -> str:
    """Return a sentence on parameters of the vehicle, a list of numbers by its name."""
    short = list(dict.fromkeys(name.partition("[")[0] for name in names))
    if not shared:
        return (
            'without share = ["observer"] the observer keeps the vehicle of Table 1: give it '
            f"{', '.join(short)} by the system file"
        )
    return (
        f"[parameters] and [known] do not say {', '.join(short)}: the observer keeps those of "
        "Table 1; give its own under [known]"
    )


def _table(head: list[str], found: list[Finding]) -> str:
    return aligned(head, [[f.name, f.theirs or "-", f.verdict] for f in found], lambda _: False)
