"""`dct-harness report`: the HTML page about runs, and their common verdict."""

from __future__ import annotations

import argparse
from pathlib import Path

from .arguments import Verbs, add_loudness, say, verb
from .run_verb import KPI_FAILS

EXAMPLES = """report target/results/paper_case1 --out target/report
report target/demo/*
report target/results/paper_case1 --compare-to reference/paper_case1"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "report", report, "write an HTML report of result directories", EXAMPLES)
    parser.add_argument("runs", type=Path, nargs="+", help="result directories")
    parser.add_argument(
        "--compare-to",
        type=Path,
        nargs="+",
        default=[],
        metavar="RUN",
        help="earlier runs to overlay",
    )
    parser.add_argument("--title", default="Closed loop", help="heading of the page")
    parser.add_argument("--out", type=Path, default=Path("target/report"),
                        help="folder of the page (target/report)")  # fmt: skip
    add_loudness(parser, "page, verdict and limits")


def report(args: argparse.Namespace) -> int:
    """Write the page; returns 1 when a run misses a limit or did not reach its end."""
    from . import report as page
    from .report import earlier, runs

    views = runs.load(args.runs)
    if args.compare_to:
        views = earlier.beside(views, args.compare_to)
    verdict, judged = runs.overall(views, runs.pairs(views))
    path = page.write_views(views, args.out, args.title)
    limits = [{"run": view.title, **limit} for view, limit in judged]
    say(args, f"report: {path}\nverdict: {verdict}",
        {"page": str(path), "verdict": verdict, "limits": limits})  # fmt: skip
    return KPI_FAILS if verdict == "fail" else 0
