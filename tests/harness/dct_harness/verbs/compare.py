"""`dct-harness compare`: does a run still do what the reference did."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path

from .. import results
from ..compare import Outcome, Tolerance, Tolerances, compare, tolerances
from ..errors import instant
from ..kpi.table import UNDEFINED, aligned
from ..kpi.typography import figure, pair, shortened, unit
from . import junit
from .arguments import Verbs, add_loudness, amount, verb

REGRESSION = 1
SHOWN = 20  # failing signals that are printed without --verbose
EXAMPLES = """compare reference/paper_case1 target/results/paper_case1
compare a.parquet b.csv --abs 0.5 --tube 0.005
compare reference target/results/paper_case1 --tolerances tolerances.toml --junit regression.xml"""
HEAD = ["signal", "of allowance", "at [s]", "reference", "run", "unit", "NRMSE", "verdict"]

CODES = "0 all signals agree, 1 a signal leaves its tolerance, 2 usage or a file cannot be read"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "compare a run with a reference, signal by signal"
    parser = verb(verbs, "compare", run, text, EXAMPLES, CODES)
    start = Tolerance()
    parser.add_argument("reference", type=Path, help="result directory or file that is right")
    parser.add_argument("run", type=Path, help="result directory or file to judge")
    parser.add_argument(
        "--tolerances", type=Path, metavar="FILE", help="TOML: tolerances by signal name"
    )
    parser.add_argument(
        "--abs", type=amount, help=f"tolerance in the signal's unit ({start.abs:g})"
    )
    parser.add_argument(
        "--rel",
        type=amount,
        help=f"tolerance as a share of the signal's largest magnitude ({start.rel:g})",
    )
    parser.add_argument("--tube", type=amount, help="time [s] by which an event may move (0)")
    parser.add_argument("--nrmse", type=amount, help="bound of RMS error / RMS (none)")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="write JUnit XML")
    add_loudness(parser, "the outcome of every signal", "print every signal")


def run(args: argparse.Namespace) -> int:
    """Compare; returns 1 when a signal leaves its tolerance."""
    suite = f"compare {args.run}"
    with junit.prevented(args.junit, suite):
        reference, ours = results.load_any(args.reference), results.load_any(args.run)
        allowed = _tolerances(args)
        outcomes = compare(reference, ours, allowed)
    if args.junit:
        junit.write(args.junit, suite, [_case(o) for o in outcomes])
    if args.json:
        print(json.dumps([_plain(o) for o in outcomes]))
    elif not args.quiet:
        for pattern in allowed.unused(list(reference.signals)):
            print(f"note: no signal matches '{pattern}' of {args.tolerances}")
        print(table(outcomes, args.verbose))
    return 0 if all(o.passed for o in outcomes) else REGRESSION


def _tolerances(args: argparse.Namespace) -> Tolerances:
    given = {k: v for k in ("abs", "rel", "tube", "nrmse") if (v := getattr(args, k)) is not None}
    start = Tolerance(**given)
    return tolerances.load(args.tolerances, start) if args.tolerances else Tolerances(start)


def _case(outcome: Outcome) -> junit.Case:
    group, _, name = outcome.name.partition(".")
    return junit.Case(group, name or group, None if outcome.passed else sentence(outcome))


def _plain(outcome: Outcome) -> dict[str, object]:
    """Return an outcome as strict JSON, which knows no infinity."""
    return {
        k: None if isinstance(v, float) and not math.isfinite(v) else v
        for k, v in asdict(outcome).items()
    }


def sentence(outcome: Outcome) -> str:
    """Return what is wrong with a signal."""
    text = f"{outcome.name} {outcome.reason}"
    if outcome.time is not None and outcome.value is not None:
        text += (f" (worst at t = {instant(outcome.time)} s: {outcome.value:.6g} for "
                 f"{outcome.reference:.6g} {outcome.unit})")  # fmt: skip
    return text


def table(outcomes: list[Outcome], everything: bool) -> str:
    """Return the signals that fail, the worst first, or all of them; then the verdict."""
    failed = sorted((o for o in outcomes if not o.passed), key=lambda o: -o.worst)
    shown = sorted(outcomes, key=lambda o: -o.worst) if everything else failed[:SHOWN]
    lines = [aligned(HEAD, [_cells(o) for o in shown], lambda k: k in (1, 2, 3, 4, 6)), ""]
    if len(failed) > len(shown):
        lines.append(f"and {len(failed) - len(shown)} more (--verbose)")
    count = f"{len(outcomes) - len(failed)} of {len(outcomes)} agree"
    lines.append(f"verdict: {'fail' if failed else 'pass'}, {count}")
    return "\n".join(lines).strip("\n")


def _cells(o: Outcome) -> list[str]:
    time, reason = UNDEFINED, o.reason  # of what is not there, or ends elsewhere
    if o.time is not None:
        time, reason = instant(o.time), shortened(o.reason, 3)
    return [o.name, figure(o.worst, 3), time, *pair(o.reference, o.value), unit(o.unit),
            figure(o.nrmse, 2), "pass" if o.passed else reason]  # fmt: skip
