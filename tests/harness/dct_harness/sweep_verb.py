"""`dct-harness sweep`: many runs with parameters drawn from distributions, by a seed."""

from __future__ import annotations

import argparse
import csv
import io
import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from . import progress
from .arguments import Verbs, add_loudness, say, verb
from .errors import ConfigError, HarnessError, InterruptedRunError
from .kpi.scopes import SCENARIO
from .kpi.table import aligned, number
from .results import write_text
from .run_verb import KPI_FAILS

SWEEP_CSV = "sweep.csv"
DRAW = re.compile(r"^(?P<name>[^=]+)=(?P<kind>uniform|normal)\((?P<a>[^,]+),(?P<b>[^,]+)\)$")
EXAMPLES = """sweep loop.toml --vary 'plant.vehicle.mass=uniform(1300,1900)' --runs 50 --seed 7
sweep loop.toml --vary 'plant.clutch1.kineticFriction=normal(0.26,0.02)' --out target/sweep"""
HEAD = ["KPI", "signal", "estimate", "least", "median", "95 %", "most"]
KEYS = ("kpi", "signal", "estimate", "least", "median", "quantile95", "most")
VARY_HELP = "COMPONENT.VARIABLE=uniform(LOW,HIGH) or normal(MEAN,DEVIATION)"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "run a system many times with parameters drawn at random, by a seed"
    parser = verb(verbs, "sweep", sweep, text, EXAMPLES)
    parser.add_argument("system", type=Path, help="system file")
    parser.add_argument("--vary", action="append", required=True, metavar="DRAW", help=VARY_HELP)
    parser.add_argument("--runs", type=int, default=20, help="how many (20)")
    parser.add_argument("--seed", type=int, default=0, help="same seed, same draws (0)")
    parser.add_argument("--fmu-dir", type=Path, default=Path("target/fmu"), help="where FMUs are")
    parser.add_argument("--out", type=Path, default=Path("target/sweep"),
                        help="folder of sweep.csv and of kept runs (target/sweep)")  # fmt: skip
    parser.add_argument("--keep", action="store_true", help="keep the signals of every run")
    add_loudness(parser, "verdict, misses and the spread of the KPIs", "also every run as it ends")


def draws(texts: list[str], runs: int, seed: int) -> dict[str, np.ndarray]:
    """Return the values of each varied parameter, shape (runs,); each has a stream of its own.

    Raises
    ------
    ConfigError
        A text is no draw, or there is no run.
    """
    if runs < 1 or seed < 0:
        raise ConfigError(f"--runs {runs} --seed {seed}: needs at least one run, a seed from 0")
    streams = np.random.SeedSequence(seed).spawn(len(texts))
    drawn = (_draw(t, runs, np.random.default_rng(s)) for t, s in zip(texts, streams, strict=True))
    return dict(drawn)


def _draw(text: str, runs: int, generator: np.random.Generator) -> tuple[str, np.ndarray]:
    """Return name and values of one `name=uniform(a,b)` or `name=normal(a,b)`."""
    match = DRAW.match(text.replace(" ", ""))
    try:
        a, b = (float(match[part]) for part in "ab") if match else (np.nan, np.nan)
    except ValueError:
        a = b = np.nan
    uniform = match is not None and match["kind"] == "uniform"
    if match is None or not np.isfinite([a, b]).all() or b < (a if uniform else 0.0):
        raise ConfigError(f"--vary {text}: write {VARY_HELP}")
    draw = generator.uniform if uniform else generator.normal
    return match["name"], draw(a, b, runs)


def sweep(args: argparse.Namespace) -> int:
    """Run, write `sweep.csv` and print how the KPIs spread; returns 1 when a run misses a limit."""
    values = draws(args.vary, args.runs, args.seed)
    rows: list[dict[str, Any]] = []
    try:
        with progress.choose(args.quiet or args.json, unit="run") as shown:
            for k in range(args.runs):
                chosen = {name: float(drawn[k]) for name, drawn in values.items()}
                rows.append(_one(args, k + 1, chosen))
                if args.verbose:
                    told = ", ".join(f"{name} = {value:.5g}" for name, value in chosen.items())
                    print(f"{k + 1:4d} {rows[-1]['verdict']:10}  {told}", flush=True)
                shown.update(k + 1, args.runs)
    finally:  # Ctrl-C keeps the runs so far
        if rows:
            _write(args.out / SWEEP_CSV, rows)
    missed = sum(row["verdict"] not in ("pass", "not judged") for row in rows)
    _say(args, rows, list(values), missed)
    return KPI_FAILS if missed else 0


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


def _one(args: argparse.Namespace, number: int, chosen: dict[str, float]) -> dict[str, Any]:
    """Run once; returns the drawn values, the verdict and the KPIs of the whole scenario.

    A run that fails does not end the sweep: its verdict is its exit code's name.
    """
    from .cli import parser

    out = args.out / f"run-{number:04d}"
    command = ["run", str(args.system), "--fmu-dir", str(args.fmu_dir), "--out", str(out), "-q"]
    command += [word for name, v in chosen.items() for word in ("--set", f"{name}={v!r}")]
    words = parser().parse_args(command)
    try:
        words.action(words)
    except (ConfigError, InterruptedRunError):
        raise
    except HarnessError as error:
        return {"run": number, **chosen, "verdict": f"exit {error.exit_code}"}
    kpis = json.loads((out / "kpis.json").read_text(encoding="utf-8"))
    if not args.keep:
        shutil.rmtree(out)
    whole = {"/".join(filter(None, (r["kpi"], r["signal"], r["estimate"]))): r["value"]
             for r in kpis["rows"] if r["scope"] == SCENARIO}  # fmt: skip
    return {"run": number, **chosen, "verdict": kpis["verdict"], **whole}


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
