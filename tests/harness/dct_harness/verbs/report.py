"""`dct-harness report`: the HTML page about runs, and their common verdict."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import ConfigError
from ..sweep.store import PLAN
from .arguments import Verbs, add_loudness, say, verb
from .run import KPI_FAILS

EXAMPLES = """report target/results/paper_case1 --out target/report
report target/demo/*
report target/study/robustness --out target/study_report
report target/results/paper_case1 --compare-to reference/paper_case1"""

CODES = """0 written, 1 written and a run misses a limit or did not reach its end,
2 usage, or a file cannot be read or written"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "write an HTML report of result directories"
    parser = verb(verbs, "report", report, text, EXAMPLES, CODES)
    parser.add_argument("runs", type=Path, nargs="+", help="result directories, or that of a study")
    parser.add_argument(
        "--compare-to",
        type=Path,
        nargs="+",
        default=[],
        metavar="RUN",
        help="earlier runs to overlay",
    )
    parser.add_argument("--title", help="heading of the page (Closed loop, or that of the study)")
    parser.add_argument("--out", type=Path, default=Path("target/report"), metavar="FOLDER",
                        help="folder of the page (target/report)")  # fmt: skip
    add_loudness(parser, "page, verdict and limits")


def _study(args: argparse.Namespace) -> int:
    """Write the page of one study."""
    from .. import report as page

    if len(args.runs) > 1 or args.compare_to:
        raise ConfigError(f"{args.runs[0]}: is a study; report it alone")
    path = page.write_study(args.runs[0], args.out, args.title or "")
    say(args, f"report: {path}", {"page": str(path)})
    return 0


def report(args: argparse.Namespace) -> int:
    """Write the page; returns 1 when a run misses a limit or did not reach its end."""
    from .. import report as page
    from ..report import earlier, runs

    if (args.runs[0] / PLAN).is_file():
        return _study(args)
    views = runs.load(args.runs)
    if args.compare_to:
        views = earlier.beside(views, args.compare_to)
    verdict, judged = runs.overall(views, runs.pairs(views))
    path = page.write_views(views, args.out, args.title or "Closed loop")
    limits = [{"run": view.title, **limit} for view, limit in judged]
    say(args, f"report: {path}\nverdict: {verdict}",
        {"page": str(path), "verdict": verdict, "limits": limits})  # fmt: skip
    return KPI_FAILS if verdict == "fail" else 0
