"""`dct-harness sweep`: many runs with parameters drawn from distributions, by a seed."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from . import progress, sampling, system
from .arguments import Verbs, add_loudness, say, verb
from .kpi.table import aligned, number
from .results import write_text
from .run_verb import ENGINES, KPI_FAILS
from .sweep_dask import cluster
from .sweep_store import Store, digest
from .sweep_workers import Job, parallel, run_one, serial

SWEEP_CSV = "sweep.csv"
EXAMPLES = """sweep loop.toml --vary 'plant.vehicle.mass=uniform(1300,1900)' --runs 50 --seed 7
sweep loop.toml --vary 'plant.clutch1.kineticFriction=normal(0.26,0.02)' --out target/sweep
sweep loop.toml --vary 'observer.method=choice(paper,kalman)' --jobs 2 --engine native
sweep loop.toml --vary 'plant.vehicle.mass=normal(1500,90)' --sampling sobol --runs 64 --resume"""
HEAD = ["KPI", "signal", "estimate", "least", "median", "95 %", "most"]
KEYS = ("kpi", "signal", "estimate", "least", "median", "quantile95", "most")


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "run a system many times with parameters drawn at random, by a seed"
    parser = verb(verbs, "sweep", sweep, text, EXAMPLES)
    parser.add_argument("system", type=Path, help="system file")
    parser.add_argument(
        "--vary", action="append", required=True, metavar="DRAW", help=sampling.VARY_HELP
    )
    many = "sets of numbers, each with every set of choices (20)"
    parser.add_argument("--runs", type=int, default=20, help=many)
    parser.add_argument("--seed", type=int, default=0, help="same seed, same draws (0)")
    how = "how numbers are drawn (random)"
    parser.add_argument("--sampling", choices=sampling.METHODS, default="random", help=how)
    parser.add_argument("--jobs", type=int, default=1, help="processes at once (1)")
    there = "run on the workers of a dask scheduler; 'local': --jobs workers of this machine"
    parser.add_argument("--dask", metavar="ADDRESS", help=there)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="fmpy", help="as for run")
    going = "go on with a sweep in OUT that was cut: finished runs are kept"
    parser.add_argument("--resume", action="store_true", help=going)
    parser.add_argument("--fmu-dir", type=Path, default=Path("target/fmu"), help="where FMUs are")
    parser.add_argument("--out", type=Path, default=Path("target/sweep"),
                        help="folder of sweep.csv and of kept runs (target/sweep)")  # fmt: skip
    parser.add_argument("--keep", action="store_true", help="keep the signals of every run")
    add_loudness(parser, "verdict, misses and the spread of the KPIs", "also every run as it ends")


def sweep(args: argparse.Namespace) -> int:
    """Run, write `sweep.csv` and print how the KPIs spread; returns 1 when a run misses a limit."""
    factors = [sampling.parse(text) for text in args.vary]
    sets = sampling.points(factors, args.runs, args.seed, args.sampling)
    store = Store(args.out, _study(args), args.resume)
    known = {k: row for k, row in store.rows().items() if k <= len(sets)}
    jobs = [(k, chosen) for k, chosen in enumerate(sets, 1) if k not in known]
    try:
        with progress.choose(args.quiet or args.json, unit="run") as shown:
            for row in _rows(args, jobs):
                store.add(row)
                known[row["run"]] = row
                if args.verbose:
                    print(_line(row, [f.name for f in factors]), flush=True)
                shown.update(len(known), len(sets))
    finally:  # Ctrl-C keeps the runs so far
        rows = [known[k] for k in sorted(known)]
        if rows:
            _write(args.out / SWEEP_CSV, rows)
    missed = sum(row["verdict"] not in ("pass", "not judged") for row in rows)
    _say(args, rows, [f.name for f in factors], missed)
    return KPI_FAILS if missed else 0


def _rows(args: argparse.Namespace, jobs: list[Job]) -> Iterator[dict[str, Any]]:
    """Yield the row of each run as it ends."""
    if args.dask:
        where = (args.system, args.fmu_dir, args.engine, args.dask, args.jobs)
        return cluster(jobs, *where)
    one = partial(run_one, args.system, args.fmu_dir, args.out, args.engine, args.keep)
    if args.jobs == 1 or len(jobs) < 2:
        return serial(jobs, one)
    return parallel(jobs, one, min(args.jobs, len(jobs)))


def _study(args: argparse.Namespace) -> dict[str, Any]:
    """Return what the rows of a sweep depend on."""
    model = system.load(args.system)
    files = [args.system, *([model.scenario] if model.scenario else [])]
    fmus = [args.fmu_dir / c.fmu for c in model.components.values()]
    there = [p for p in (*files, *fmus) if p.is_file()]
    return {"vary": args.vary, "runs": args.runs, "seed": args.seed, "sampling": args.sampling,
            "engine": args.engine, "files": digest(*there)}  # fmt: skip


def _line(row: dict[str, Any], varied: list[str]) -> str:
    """Return one run as --verbose prints it."""
    told = (f"{n} = {row[n]:.5g}" if isinstance(row[n], float) else f"{n} = {row[n]}"
            for n in varied)  # fmt: skip
    return f"{row['run']:4d} {row['verdict']:10}  {', '.join(told)}"


def _say(
    args: argparse.Namespace, rows: list[dict[str, Any]], varied: list[str], missed: int
) -> None:
    spread, path, verdict = (
        _spread(rows, varied),
        args.out / SWEEP_CSV,
        "fail" if missed else "pass",
    )
    cells = [[*line[:3], *(number(x, 3) for x in line[3:])] for line in spread]
    lines = [aligned(HEAD, cells, lambda k: k > 2), "", f"{path}: {len(rows)} runs",
             f"verdict: {verdict}, {missed} of {len(rows)} runs miss a limit"]  # fmt: skip
    told = [dict(zip(KEYS, line, strict=True)) for line in spread]
    say(args, "\n".join(lines).lstrip("\n"),
        {"file": str(path), "runs": len(rows), "missed": missed, "verdict": verdict,
         "spread": told})  # fmt: skip


def _write(path: Path, rows: list[dict[str, Any]]) -> None:
    names = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, text.getvalue())


def _spread(rows: list[dict[str, Any]], varied: list[str]) -> list[list[Any]]:
    """Return KPI, signal, estimate, then least, median, 95 % quantile and most of its values."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    found = []
    for name in names:
        known = [row[name] for row in rows if row.get(name) is not None]
        if name in ("run", "verdict", *varied) or not known:
            continue
        key, signal, *estimate = name.split("/")
        figures = (min(known), np.median(known), np.quantile(known, 0.95), max(known))
        found.append([key, signal, "".join(estimate), *map(float, figures)])
    return found
