"""`dct-harness sweep`: many runs of a system, as a study file or a few options say."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import results
from ..errors import ConfigError, InterruptedRunError
from ..fmu.isolated import Limits
from ..kpi.table import aligned, number
from ..master import watch
from ..results import write_text
from ..sweep import cases as study_cases
from ..sweep import leftover, sampling, study_file
from ..sweep.cases import Job
from ..sweep.on_dask import HERE, cluster
from ..sweep.runs import Prepared, Row, Setup
from ..sweep.store import GOOD, Store, digest
from ..sweep.study import DASK, LOCAL, Shown, Study
from ..sweep.workers import Rows, parallel, serial
from . import junit, progress
from .arguments import Verbs, add_loudness, patience, say, say_outdated, seconds, verb
from .run import ENGINES, KPI_FAILS

SWEEP_CSV = "sweep.csv"
EXAMPLES = """sweep examples/study/robustness.toml --jobs 2
sweep examples/study/robustness.toml --runs 4 --out target/small --resume
sweep loop.toml --vary 'plant.vehicle.mass=uniform(1300,1900)' --runs 50 --seed 7
sweep loop.toml --vary 'plant.clutch1.kineticFriction=normal(0.26,0.02)' --out target/sweep
sweep loop.toml --vary 'observer.observer.method=choice(paper,kalman)' --jobs 2 --engine native
sweep loop.toml --vary 'plant.vehicle.mass=normal(1500,90)' --sampling sobol --runs 64 --resume"""
STUDY_FILE = """
a study file:
  [study]
  name = "mass"
  system = "loop.toml"          # relative to this file
  sampling = "latin-hypercube"  # random, latin-hypercube, sobol, saltelli, grid
  runs = 100
  engine = "native"

  [factors.mass]                # a column of the results, an axis of the report
  set = ["plant.vehicle.mass", "plant.vehicle.wheelInertia"]  # or one: "plant.vehicle.mass"
  uniform = [0.8, 1.2]          # normal, lognormal, truncated, values
  relative = true               # times what the parameter has otherwise
  label = "vehicle mass / nominal"

  [methods]                     # each with everything else; so [scenarios], [presets], [mappings]
  names = ["paper", "kalman"]

  [[kpis]]                      # what the report shows
  kpi = "estimation.percentOfRms"
  signal = "driveShaft.torque"
  max = 10                      # %; above it the estimate counts as broken
"""
CALL_HELP = f"longest time for a call of a foreign FMU, as for run ({Limits.seconds:g})"
HEAD = ["KPI", "signal", "estimate", "least", "median", "95 %", "most"]
KEYS = ("kpi", "signal", "estimate", "least", "median", "quantile95", "most")
PLAIN = ("runs", "seed", "sampling", "jobs", "engine", "fmu_dir")  # options that a study has too

CODES = """0 every run passes, 1 a run misses a limit or fails (its row says why),
2 usage or configuration, 130 interrupted (finished runs are kept: --resume)"""


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "run a system many times: a study file, or parameters drawn by a seed"
    parser = verb(verbs, "sweep", sweep, text, EXAMPLES, CODES)
    parser.epilog = f"{parser.epilog}{STUDY_FILE}"
    parser.add_argument("system", type=Path, help="study file, or system file with --vary")
    _add_draws(parser)
    parser.add_argument("--jobs", type=int, help=f"processes at once ({Study.jobs})")
    for name, kind, told in (
        ("scenario", "FILE", "scenario CSV instead of the file's"),
        ("plant", "FMU", "FMU to use as component 'plant'"),
        ("map", "FILE", "mapping file (.toml): names, units, codings of that plant"),
    ):
        parser.add_argument(f"--{name}", type=Path, metavar=kind, help=told)
    parser.add_argument("--stop", type=seconds, metavar="SECONDS",
                        help="end of every run (that of the file)")  # fmt: skip
    parser.add_argument("--call-timeout", type=patience, metavar="SECONDS", help=CALL_HELP)
    parser.add_argument("--set", action="append", default=[], metavar="COMPONENT.VARIABLE=VALUE",
                        help="a parameter or start value of all runs")  # fmt: skip
    there = "run on the workers of a dask scheduler; 'local': --jobs workers of this machine"
    parser.add_argument("--dask", metavar="ADDRESS", help=there)
    engine = f"as for run ({Study.engine})"
    parser.add_argument("--engine", choices=tuple(ENGINES), help=engine)
    going = "go on with a sweep in OUT that was cut: finished runs are kept"
    parser.add_argument("--resume", action="store_true", help=going)
    again = "with --resume: also make runs again that failed or were lost"
    parser.add_argument("--retry", action="store_true", help=again)
    parser.add_argument("--fmu-dir", type=Path, metavar="FOLDER",
                        help=f"where FMUs are ({Study.fmu_dir})")  # fmt: skip
    parser.add_argument("--out", type=Path,
                        metavar="FOLDER", help="folder of sweep.csv and of kept runs "
                        "(target/sweep, of a study target/study/NAME)")  # fmt: skip
    parser.add_argument("--report", action="store_true", help="write OUT/report/index.html too")
    parser.add_argument("--junit", type=Path, metavar="FILE", help="runs as JUnit XML")
    parser.add_argument("--keep", action="store_true", help="keep the signals of every run")
    add_loudness(parser, "verdict, misses and the spread of the KPIs", "also every run as it ends")


def _add_draws(parser: argparse.ArgumentParser) -> None:
    """Add what a sweep draws, and how."""
    parser.add_argument(
        "--vary", action="append", default=[], metavar="DRAW", help=sampling.VARY_HELP
    )
    many = (f"sets of numbers, each with every set of choices ({Study.runs}); "
            "saltelli makes factors + 2 times as many, grid combines so many levels")  # fmt: skip
    parser.add_argument("--runs", type=int, help=many)
    parser.add_argument("--seed", type=int, help=f"same seed, same draws ({Study.seed})")
    how = f"how numbers are drawn ({Study.sampling}); saltelli: for Sobol indices"
    parser.add_argument("--sampling", choices=sampling.METHODS, help=how)


def sweep(args: argparse.Namespace) -> int:
    """Run, write `sweep.csv` and print how the KPIs spread; returns 1 when a run misses a limit."""
    with junit.prevented(args.junit, args.system.stem):
        return _sweep(args, plan(args))


def _sweep(args: argparse.Namespace, study: Study) -> int:
    out = args.out or (Path("target/study") / study.name if study.file else Path("target/sweep"))
    jobs, files = study_cases.jobs(study), study_cases.files(study)
    say_outdated(args, (f for f in files if f.suffix == ".fmu"))
    results.check_writable(out)
    with leftover.alone(out):
        return _made(args, study, out, jobs, files)


def _made(
    args: argparse.Namespace, study: Study, out: Path, jobs: list[Job], files: list[Path]
) -> int:
    """Make the runs that have no row yet, write and print."""
    store = Store(out, {**study.identity(), "files": digest(*files)}, args.resume)
    store.describe(study.describe())
    known = {k: row for k, row in store.rows().items() if k <= len(jobs)}
    if args.retry:
        known = {k: row for k, row in known.items() if row["verdict"] in GOOD}
    leftover.remove(out, known)
    left = [job for job in jobs if job.number not in known]
    setup = Setup(study.common, out, args.keep, study.signals, study.every, study.retries)
    varied = [f.name for f in study.factors] + [axis.name for axis in study.axes]
    try:
        with (watch.stoppable(), progress.choose(args.quiet or args.json, unit="run") as shown,
              closing(_rows(study, setup, left, files)) as ended):  # fmt: skip
            for row in ended:
                row["command"] = study_cases.command(study, jobs[row["run"] - 1])
                store.add(row)
                known[row["run"]] = row
                if args.verbose:
                    print(_line(row, varied), flush=True)
                shown.update(len(known), len(jobs))
    except (KeyboardInterrupt, InterruptedRunError):
        kept = f"{len(known)} of {len(jobs)} runs are kept in {out}"
        raise InterruptedRunError(f"interrupted: {kept}, --resume makes the others") from None
    finally:
        rows = [known[k] for k in sorted(known)]
        if rows:
            _write(out / SWEEP_CSV, rows)
    missed = sum(row["verdict"] not in ("pass", "not judged") for row in rows)
    if args.junit:
        junit.write(args.junit, study.name, [_case(row, varied) for row in rows])
    if args.report:
        _report(args, out)
    _say(args, out, _spread(rows, varied, study.kpis), len(rows), missed)
    return KPI_FAILS if missed else 0


def _report(args: argparse.Namespace, out: Path) -> None:
    from .. import report

    page = report.write_study(out, out / "report")
    if not (args.quiet or args.json):
        print(f"report: {page}")


def plan(args: argparse.Namespace) -> Study:
    """Return the study of a file or of the options; options stand above the file.

    Raises
    ------
    ConfigError
        Nothing is varied, or the study file is wrong.
    """
    if study_file.is_study(args.system):
        study = study_file.load(args.system)
    else:
        study = Study(args.system.stem, args.system)
    given = {k: v for k in PLAIN if (v := getattr(args, k)) is not None}
    if args.dask:
        given["executor"] = DASK if args.dask == HERE else args.dask
    factors = (*study.factors, *map(sampling.parse, args.vary))
    settings = (*study.settings, *_settings(args))
    study = replace(study, factors=factors, settings=settings, **given)
    if not (study.factors or study.axes):
        raise ConfigError(f"{args.system}: nothing is varied; give --vary {sampling.VARY_HELP}, or "
                          "a study file with [factors]")  # fmt: skip
    return study


def _settings(args: argparse.Namespace) -> Iterator[str | Path]:
    """Yield the words of options that all runs have."""
    for name in ("scenario", "plant", "map"):
        if getattr(args, name) is not None:
            yield from (f"--{name}", getattr(args, name))
    for name in ("stop", "call_timeout"):
        if getattr(args, name) is not None:
            yield from (f"--{name.replace('_', '-')}", repr(getattr(args, name)))
    for text in args.set:
        yield from ("--set", text)


def _rows(study: Study, setup: Setup, jobs: list[Job], files: list[Path]) -> Rows:
    """Yield the row of each run as it ends."""
    if study.executor != LOCAL:
        address = HERE if study.executor == DASK else study.executor
        return cluster(jobs, setup, files, address, study.jobs)
    one = Prepared(setup).run_one
    if study.jobs == 1 or len(jobs) < 2:
        return serial(jobs, one)
    return parallel(jobs, one, min(study.jobs, len(jobs)))


def _case(row: Row, varied: list[str]) -> junit.Case:
    """Return a run as a check: one that misses a limit fails, one without its end is an error."""
    verdict, again = row["verdict"], row["command"]
    told = {
        "failure": f"misses a limit: {again}" if verdict == "fail" else None,
        "error": f"{row.get('error') or verdict}: {again}" if verdict not in GOOD else None,
    }
    return junit.Case("runs", f"run {row['run']}: {_chosen(row, varied)}", **told)


def _line(row: Row, varied: list[str]) -> str:
    """Return one run as --verbose prints it."""
    return f"{row['run']:4d} {row['verdict']:10}  {_chosen(row, varied)}"


def _chosen(row: Row, varied: list[str]) -> str:
    told = (f"{n} = {row[n]:.5g}" if isinstance(row[n], float) else f"{n} = {row[n]}"
            for n in varied)  # fmt: skip
    return ", ".join(told)


def _say(
    args: argparse.Namespace, out: Path, spread: list[list[Any]], runs: int, missed: int
) -> None:
    path, verdict = out / SWEEP_CSV, "fail" if missed else "pass"
    cells = [[*line[:3], *(number(x, 3) for x in line[3:])] for line in spread]
    lines = [aligned(HEAD, cells, lambda k: k > 2), "", f"{path}: {runs} runs",
             f"verdict: {verdict}, {missed} of {runs} runs miss a limit"]  # fmt: skip
    told = [dict(zip(KEYS, line, strict=True)) for line in spread]
    say(args, "\n".join(lines).lstrip("\n"),
        {"file": str(path), "runs": runs, "missed": missed, "verdict": verdict,
         "spread": told})  # fmt: skip


def _write(path: Path, rows: list[Row]) -> None:
    names = [n for n in dict.fromkeys(name for row in rows for name in row) if n != "command"]
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n", extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, text.getvalue())


def _spread(rows: list[Row], varied: list[str], shown: tuple[Shown, ...]) -> list[list[Any]]:
    """Return KPI, signal, estimate, then least, median, 95 % quantile and most of its values.

    Of a study that says which KPIs it shows, these only.
    """
    names = list(dict.fromkeys(name for row in rows for name in row))
    found = []
    for name in names:
        known = [row[name] for row in rows if row.get(name) is not None]
        if name in ("run", "verdict", "error", "command", *varied) or not known:
            continue
        key, signal, *estimate = name.split("/")
        if shown and not any(k.shows(key, signal, "".join(estimate)) for k in shown):
            continue
        figures = (min(known), np.median(known), np.quantile(known, 0.95), max(known))
        found.append([key, signal, "".join(estimate), *map(float, figures)])
    return found
