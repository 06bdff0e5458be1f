"""`dct-harness run`: one closed loop, its result directory, its KPIs and the exit code."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .. import formats, kpi, results
from ..errors import HarnessError, InterruptedRunError, instant
from ..fmu import sources
from ..kpi.estimation import PLANT
from ..master import check_step, watch
from ..master.master import BUILD, SCENARIO, Run, Wanted
from ..master.native import NativeRun
from ..master.wiring import Wirings
from ..ssp import calibration
from . import junit, progress, selection
from .arguments import Verbs, add_limits, add_loudness, amount, limits, seconds, verb
from .environment import environment

KPI_FAILS = 1
SHOWN = 6  # parameters in a line
DETAILS = ("phase/", "state/", "event/")  # scopes that --verbose shows
ENGINES = {"fmpy": Run, "native": NativeRun}
FORMATS = tuple(suffix[1:] for suffix in formats.SUFFIXES)
EXAMPLES = """run examples/closed_loop/paper_case1.toml --out target/results/paper_case1
run examples/closed_loop/torque_tracking_case1.toml --set control.feedback.enabled=false
run examples/closed_loop/paper_case1.toml --plant target/fmu/DctPlant.fmu --timeout 60
run examples/closed_loop/paper_case1.toml --engine native
run examples/closed_loop/calibration_case1.toml --calibration earlier/calibration.ssv
run examples/closed_loop/paper_case1.toml --plant Antrieb.fmu --map antrieb.toml"""

CODES = """0 pass or not judged, 1 a limit is missed or --check-step finds a larger change,
2 usage or configuration, 3 FMU invalid, 4 FMU failed at run time or asked to end the simulation
before stop, 5 timeout, 6 no binary for this platform, 130 interrupted (4, 5 and 130: what was made
until then is kept, limits are not judged)"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    parser = verb(verbs, "run", run, "run a closed loop", EXAMPLES, CODES)
    selection.add_options(parser)
    parser.add_argument("--out", type=Path, metavar="FOLDER",
                        help="result directory (target/results/NAME)")  # fmt: skip
    longest = "longest time of the run by the clock (none); what was made until then is kept"
    parser.add_argument("--timeout", type=seconds, metavar="SECONDS", help=longest)
    finer = "repeat at half the step; exit 1 when an output changes by more, RMS in %% of its RMS"
    parser.add_argument("--check-step", type=amount, metavar="PERCENT", help=finer)
    engine = ("fmpy (default), or native: the compiled master, the same numbers in a fraction of "
              "the time; `cargo xtask native` builds it")  # fmt: skip
    parser.add_argument("--engine", choices=tuple(ENGINES), default="fmpy", help=engine)
    add_limits(parser)
    parser.add_argument("--format", choices=FORMATS, default="csv", help="of the results (csv)")
    parser.add_argument("--report", action="store_true", help="write OUT/report/index.html too")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="limits as JUnit XML")
    add_loudness(parser, "run.json and the KPIs", "also KPIs per phase, FMU messages")


def run(args: argparse.Namespace) -> int:
    """Run a system file; returns 1 when a KPI misses its limit.

    Raises
    ------
    HarnessError
        The run did not reach its end; the samples until then are written.
    """
    with junit.prevented(args.junit, args.system.stem):
        loop = Asked(args).loop()
        out = args.out or Path("target/results") / loop.system.name
        results.check_writable(out)
    loop.outdated = sources.remark(loop.paths.values())
    try:
        return _run(loop, out, args)
    finally:
        if loop.package is not None:
            loop.package.folder.cleanup()


def _run(loop: Run, out: Path, args: argparse.Namespace) -> int:
    """Run, judge, write and print."""
    failure = _execute(loop, out, args)
    record = save(loop, out, failure, args.format)
    kpis = None if failure else _judge(loop, record, out)
    _say(args, out, record, kpis)
    if args.junit:
        junit.write(args.junit, loop.system.name, _cases(record, kpis))
    if args.report and record["samples"]:
        _report(out, loop.system.title, args)
    if failure:
        raise failure
    if args.check_step is not None and not check_step.check(loop, out, args):
        return KPI_FAILS
    return KPI_FAILS if kpis and kpis["verdict"] == "fail" else 0


class Asked:
    """What a command line asks to run, once or with other values each time."""

    def __init__(self, args: argparse.Namespace) -> None:
        formats.require(Path(f"results.{args.format}"))
        self.args = args
        self._model, self._paths, self._names, self.package = selection.choose(args)
        self._wirings = Wirings()

    def loop(self, sets: Iterable[str] = ()) -> Run:
        """Return a run; `sets`: `component.variable=value` of this run alone."""
        model = self._model.copy()
        for text in sets:
            model.override(text)
        loop = ENGINES[self.args.engine](model, self._paths, self._names, limits(self.args))
        loop.package, loop.wirings = self.package, self._wirings
        return loop


def judged(
    loop: Run, out: Path, args: argparse.Namespace, keep: bool, chosen: Wanted | None = None
) -> tuple[results.Results, dict[str, Any]]:
    """Return signals and KPIs of a run; only one that fails, or is to `keep`, is written to `out`.

    `chosen`: which of its signals the caller needs besides those that the KPIs are of; an engine
    may then leave out the others.

    Raises
    ------
    HarnessError
        The run did not reach its end; `in_part`: not all of its signals are there to be looked at.
    """
    brief = {"system": loop.system.as_dict(), "status": "complete"}
    if chosen is not None and not keep:
        loop.wanted = lambda names: {*chosen(names), *kpi.reads(names, brief)}
    try:
        failure = _execute(loop, out, args)
        if isinstance(failure, InterruptedRunError):
            raise failure  # who goes on with the sweep makes it anew
        if failure is not None or keep:
            record = save(loop, out, failure, args.format)
        if failure is not None:
            failure.in_part = loop.kept is not loop.names
            raise failure
        if keep:
            return results.from_table(*loop.table(), record, out), _judge(loop, record, out)
        unkept = frozenset(loop.names).difference(loop.kept)
        signals = dict(zip(loop.kept, results.columns(loop.rows), strict=True))
        beside = dict(zip(loop.measured.names, loop.measured.table.T, strict=True))
        courses = {"time": loop.times, **signals, **beside}
        told = results.Results(courses, brief, out, unkept, loop.spacing)
        return told, kpi.compute(told, brief, whole=True)
    finally:
        if loop.package is not None:
            loop.package.folder.cleanup()


def _execute(loop: Run, out: Path, args: argparse.Namespace) -> HarnessError | None:
    """Run to the end; returns the error that prevented it."""

    def hang(error: HarnessError) -> None:
        save(loop, out, error, args.format)
        print(f"dct-harness: {error}", file=sys.stderr, flush=True)
        loop.remove_directories()

    quiet = args.quiet or args.json
    try:
        with (
            watch.interruptible(loop), watch.time_limit(loop, args.timeout, hang),
            progress.choose(quiet) as shown,
        ):  # fmt: skip
            loop.execute(shown.update)
    except HarnessError as error:
        return error
    return None


def save(loop: Run, out: Path, failure: HarnessError | None, suffix: str = "csv") -> dict[str, Any]:
    """Write the samples so far and `run.json`; returns the content of the latter.

    A run that failed before its first sample writes nothing.
    """
    record = {**loop.summary(failure), "environment": environment()}
    if len(loop.rows):
        (out / results.KPIS_JSON).unlink(missing_ok=True)
        results.write(out, *loop.table(), record, f".{suffix}")
    return record


def _judge(loop: Run, record: dict[str, Any], out: Path) -> dict[str, Any]:
    """Compute the KPIs and write them, and what an observer has learnt."""
    told = results.from_table(*loop.table(), record, out)
    calibration.save(out, told)
    kpis = kpi.compute(told, record)
    results.write_text(out / results.KPIS_JSON, json.dumps(kpis, indent=2) + "\n")
    return kpis


def _cases(record: dict[str, Any], kpis: dict[str, Any] | None) -> list[junit.Case]:
    """Return a case for the run itself and one per limit."""
    cases = [junit.Case("run", junit.ENDS, error=record["error"])]
    if kpis:
        for judged in kpis["limits"]:
            what = " ".join(kpi.table.limit_cells([judged])[0][:3])
            missed = None if judged["pass"] else _missed(judged, kpis)
            cases.append(junit.Case("limits", what, missed))
    return cases


def _missed(judged: dict[str, Any], kpis: dict[str, Any]) -> str:
    """Return a sentence on a limit that is missed; also why, where its KPI has no value."""
    title, of, scope, value, limit, _ = kpi.table.limit_cells([judged])[0]
    if judged["value"] is not None:
        return f"{title} {of} {scope}: {value}, limit {limit}"
    why = "".join(f" ({told})" for told in kpi.limits.of_nothing([judged], kpis["rows"]))
    return f"{title} {of} {scope}: not defined in this run{why}, limit {limit}"


def _report(out: Path, title: str, args: argparse.Namespace) -> None:
    """Write the report of this run beside its results."""
    from .. import report

    page = report.write([out], out / "report", title)
    if not (args.quiet or args.json):
        print(f"report: {page}")


def _say(
    args: argparse.Namespace, out: Path, record: dict[str, Any], kpis: dict[str, Any] | None
) -> None:
    """Print what the chosen loudness shows; errors are printed by the caller."""
    if args.verbose:
        _say_coupling(record["coupling"])
        for m in record["log"]:
            text = f"{instant(m['time'])} s {m['component']} [{m['category']}] {m['message']}"
            print(text, file=sys.stderr)
    elif not (args.quiet or args.json):
        for m in record["log"]:
            if m["category"] in (SCENARIO, BUILD):
                print(m["message"], file=sys.stderr)
    if args.quiet and kpis:
        for judged in kpis["limits"]:
            if not judged["pass"]:
                print(f"dct-harness: limit missed: {_missed(judged, kpis)}", file=sys.stderr)
    if args.json:
        print(json.dumps({"out": str(out), "run": record, "kpis": kpis}))
    elif not args.quiet:
        if kpis:
            print(kpi.format_table(kpis if args.verbose else _whole(kpis)) + "\n")
            if kpis["verdict"] == "fail":
                _say_beliefs(record["parameters"])
        if record["samples"]:
            print(f"{out}: {record['samples']} samples to t = {instant(record['reached'])} s")


def _say_coupling(coupling: dict[str, Any]) -> None:
    """Name what the coupling costs: signals one step late, and algebraic loops."""
    print(f"coupling: {coupling['order']}", file=sys.stderr)
    for wire in coupling["delayed"]:
        print(f"  one step late: {wire['from']} -> {wire['to']}", file=sys.stderr)
    for loop in coupling["loops"]:
        print(f"  algebraic loop: {', '.join(loop)}", file=sys.stderr)


def _say_beliefs(parameters: dict[str, Any]) -> None:
    """Name what another component believes of the vehicle that the plant is not."""
    plant = parameters.get(PLANT, {})
    for component, its in parameters.items():
        other = [_belief(name, p, plant[name]) for name, p in its.items()
                 if name in plant and p["value"] != plant[name]["value"]]  # fmt: skip
        if other:
            more = f" and {len(other) - SHOWN} more" if len(other) > SHOWN else ""
            print(f"{component} believes {', '.join(other[:SHOWN])}{more}\n")


def _belief(name: str, believed: dict[str, Any], true: dict[str, Any]) -> str:
    unit = "" if believed["unit"] == "1" else believed["unit"]
    return f"{name} = {believed['value']} (plant {true['value']}) {unit}".rstrip()


def _whole(kpis: dict[str, Any]) -> dict[str, Any]:
    """Return the KPIs without those of single phases and clutch states."""
    rows = [r for r in kpis["rows"] if not r["scope"].startswith(DETAILS)]
    return {**kpis, "rows": rows}
