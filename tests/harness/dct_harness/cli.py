"""Command line `dct-harness`: run, check, report, doctor."""

from __future__ import annotations

import argparse
import importlib
import json
import platform
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

from . import results, system
from .errors import ConfigError, HarnessError
from .master import Run

EXAMPLES = """examples:
  dct-harness run examples/closed_loop/paper_case1.toml --out target/results/paper_case1
  dct-harness run examples/closed_loop/torque_tracking_case1.toml \\
    --set control.feedback.enabled=false
  dct-harness check target/fmu/DctPlant.fmu
  dct-harness doctor target/fmu/*.fmu

exit codes: 0 pass, 1 KPI fails, 2 usage or configuration, 3 FMU invalid,
  4 FMU failed at run time, 5 timeout, 6 no binary for this platform
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
    loudness = run.add_mutually_exclusive_group()
    loudness.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    loudness.add_argument("-v", "--verbose", action="store_true", help="print FMU messages too")
    loudness.add_argument("--json", action="store_true", help="print run.json and the KPIs")
    check = verbs.add_parser("check", help="validate and load one FMU")
    check.add_argument("fmu", type=Path)
    report = verbs.add_parser("report", help="write an HTML report of result directories")
    report.add_argument("runs", type=Path, nargs="+")
    report.add_argument("--out", type=Path, default=Path("target/report"))
    doctor = verbs.add_parser("doctor", help="versions, platform, do the FMUs load")
    doctor.add_argument("fmus", type=Path, nargs="*")
    return parser


def environment() -> dict[str, str]:
    """Return the versions that `run.json` records."""
    packages = {n: version(n) for n in ("dct-harness", "fmpy", "numpy")}
    return {**packages, "python": platform.python_version(), "platform": platform.platform()}


def _run(args: argparse.Namespace) -> int:
    model = system.load(args.system)
    if args.scenario:
        model.scenario = args.scenario
    for text in args.set:
        model.override(text)
    paths = {n: args.fmu_dir / c.fmu for n, c in model.components.items()}
    if args.plant:
        if "plant" not in paths:
            raise ConfigError(f"--plant: {args.system} has no component 'plant'")
        paths["plant"] = args.plant
    run, out = Run(model, paths), args.out or Path("target/results") / model.name
    failure: HarnessError | None = None
    try:
        run.execute(None if args.quiet or args.json else _progress())
    except HarnessError as error:
        failure = error
        raise
    except KeyboardInterrupt:
        failure = HarnessError("interrupted")
        raise
    finally:
        if len(run.rows):
            results.write(out, *run.table(), {**run.summary(failure), "environment": environment()})
    loaded = results.load(out)
    kpis = importlib.import_module("dct_harness.kpi").compute(loaded, loaded.run)
    results.write_text(out / "kpis.json", json.dumps(kpis, indent=2) + "\n")
    _print_run(args, out, loaded, kpis)
    return 0


def _print_run(
    args: argparse.Namespace, out: Path, loaded: results.Results, kpis: dict[str, Any]
) -> None:
    if args.json:
        print(json.dumps({"out": str(out), "run": loaded.run, "kpis": kpis}))
    elif not args.quiet:
        if args.verbose:
            for m in loaded.run["log"]:
                print(f"{m['time']:.6g} s {m['component']} [{m['category']}] {m['message']}")
        print(f"{out}: {len(loaded.time)} samples to t = {loaded.time[-1]:g} s")


def _progress() -> Any:
    """Return a progress bar with ETA on a terminal, nothing in CI."""
    if not sys.stderr.isatty():
        return None
    from tqdm import tqdm

    bar = tqdm(unit="step", leave=False)

    def update(done: int, total: int) -> None:
        bar.total = total
        bar.update(done - bar.n)

    return update


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
    report = importlib.import_module("dct_harness.report")
    print(report.write(args.runs, args.out, "Closed loop"))
    return 0


def _doctor(args: argparse.Namespace) -> int:
    from .fmu import Fmu

    for name, text in environment().items():
        print(f"{name}: {text}")
    worst = 0
    for path in args.fmus:
        try:
            Fmu("doctor", path).close()
            print(f"{path}: loads")
        except HarnessError as error:
            print(error)
            worst = max(worst, error.exit_code)
    return worst


def main(argv: list[str] | None = None) -> int:
    """Run one verb; returns the documented exit code."""
    args = _parser().parse_args(argv)
    verbs = {"run": _run, "check": _check, "report": _report, "doctor": _doctor}
    try:
        return verbs[args.verb](args)
    except HarnessError as error:
        print(f"dct-harness: {error}", file=sys.stderr)
        return error.exit_code


if __name__ == "__main__":
    sys.exit(main())
