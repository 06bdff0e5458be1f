"""Command line `dct-harness`: run, check, report, doctor."""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

from . import loader
from .environment import environment
from .errors import HarnessError, InterruptedRunError
from .run_verb import KPI_FAILS, run

EXAMPLES = """examples:
  dct-harness run examples/closed_loop/paper_case1.toml --out target/results/paper_case1
  dct-harness run examples/closed_loop/torque_tracking_case1.toml \\
    --set control.feedback.enabled=false
  dct-harness check target/fmu/DctPlant.fmu
  dct-harness doctor target/fmu/*.fmu

exit codes: 0 pass, 1 KPI fails, 2 usage or configuration, 3 FMU invalid,
  4 FMU failed at run time, 5 timeout, 6 no binary for this platform,
  130 interrupted (the samples until then are kept)
"""


def _parser() -> argparse.ArgumentParser:
    style = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser("dct-harness", epilog=EXAMPLES, formatter_class=style)
    verbs = parser.add_subparsers(dest="verb", required=True)
    run = verbs.add_parser("run", help="run a closed loop", epilog=EXAMPLES, formatter_class=style)
    run.add_argument("system", type=Path, help="system file (.toml)")
    run.add_argument("--scenario", type=Path, help="scenario CSV instead of the file's")
    run.add_argument("--plant", type=Path, help="FMU to use as component 'plant'")
    run.add_argument("--fmu-dir", type=Path, default=Path("target/fmu"), help="where FMUs are")
    run.add_argument("--set", action="append", default=[], metavar="COMPONENT.VARIABLE=VALUE")
    run.add_argument("--out", type=Path, help="result directory (target/results/NAME)")
    run.add_argument("--timeout", type=_seconds, metavar="SECONDS", help="longest wall-clock time")
    loudness = run.add_mutually_exclusive_group()
    loudness.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    loudness.add_argument(
        "-v", "--verbose", action="store_true", help="also KPIs per phase, FMU messages"
    )
    loudness.add_argument("--json", action="store_true", help="print run.json and the KPIs")
    check = verbs.add_parser("check", help="validate and load one FMU")
    check.add_argument("fmu", type=Path)
    report = verbs.add_parser("report", help="write an HTML report of result directories")
    report.add_argument("runs", type=Path, nargs="+")
    report.add_argument("--out", type=Path, default=Path("target/report"))
    doctor = verbs.add_parser("doctor", help="versions, platform, do the FMUs load")
    doctor.add_argument("fmus", type=Path, nargs="*")
    return parser


def _seconds(text: str) -> float:
    """Read a time [s] greater than 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a time greater than 0 s")
    return value


def _check(args: argparse.Namespace) -> int:
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
    return 3 if problems else 0


def _report(args: argparse.Namespace) -> int:
    from . import report
    from .report import runs

    views = runs.load(args.runs)
    verdict, _ = runs.overall(views, runs.pairs(views))
    print(f"report: {report.write_views(views, args.out, 'Closed loop')}")
    print(f"verdict: {verdict}")
    return KPI_FAILS if verdict == "fail" else 0


def _doctor(args: argparse.Namespace) -> int:
    for name, text in environment().items():
        print(f"{name}: {text}")
    print(f"glibc: {loader.glibc_present() or 'none'}")
    return max((_diagnose(path) for path in args.fmus), default=0)


def _diagnose(path: Path) -> int:
    """Print whether an FMU loads; returns the exit code that stands for the answer."""
    from .fmu import Fmu

    try:
        fmu = Fmu("doctor", path)
    except HarnessError as error:
        print(error)
        return error.exit_code
    needed = loader.glibc_needed(fmu.library)
    fmu.close()
    print(f"{path}: loads" + (f", needs glibc {needed} or newer" if needed else ""))
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run one verb; returns the documented exit code."""
    args = _parser().parse_args(argv)
    verbs = {"run": run, "check": _check, "report": _report, "doctor": _doctor}
    try:
        return verbs[args.verb](args)
    except HarnessError as error:
        print(f"dct-harness: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("dct-harness: interrupted", file=sys.stderr)
        return InterruptedRunError.exit_code


if __name__ == "__main__":
    sys.exit(main())
