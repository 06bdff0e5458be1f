"""`dct-harness convert`: results and measurements from one format, naming and rate to another."""

from __future__ import annotations

import argparse
import sys
from fnmatch import fnmatchcase
from pathlib import Path

from .. import formats, measured
from ..errors import ConfigError, did_you_mean, instant
from .arguments import Verbs, add_loudness, moment, say, seconds, verb

EXAMPLES = """convert target/results/paper_case1 case1.mf4
convert results.parquet results.csv --only 'plant.clutch*' --step 0.01
convert drive.mf4 scenario.csv --map names.toml --step 0.001 --start 12.5 --stop 42.5"""
MAP_HELP = "TOML: [[signals]] with from, to and unit; only these are written, in SI units"

CODES = "0 written, 2 usage, or a file cannot be read or written"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "convert results or measured data between CSV, Parquet and MF4"
    parser = verb(verbs, "convert", convert, text, EXAMPLES, CODES)
    parser.add_argument("source", type=Path, help="result directory or file")
    parser.add_argument("target", type=Path, help="file to write (.csv, .parquet, .mf4)")
    parser.add_argument("--map", type=Path, metavar="FILE", help=MAP_HELP)
    parser.add_argument("--only", action="append", default=[], metavar="GLOB", help="names to keep")
    parser.add_argument("--step", type=seconds, metavar="SECONDS", help="resample to this step")
    parser.add_argument("--start", type=moment, metavar="T", help="from this time [s], new time 0")
    parser.add_argument("--stop", type=moment, metavar="T", help="up to this time [s]")
    add_loudness(parser, "file, signals and samples")


def _without_units(channels: list[measured.Channel]) -> list[measured.Channel]:
    """Return channels in SI units: CSV has no place for others. Tells which have an unknown one."""
    found, strange = measured.in_si(channels)
    units = sorted({c.unit for c in channels if c.name in strange})
    if units:
        told = f"values in {', '.join(units)} stay as they are: no such unit is known"
        print(f"{told} ({', '.join(strange)})", file=sys.stderr)
    return found


def convert(args: argparse.Namespace) -> int:
    """Write the target; returns 0."""
    formats.require(args.target)
    channels = measured.read(args.source)
    if args.map:
        channels = measured.Mapping.load(args.map).apply(channels)
    names = [c.name for c in channels]
    if args.only:
        channels = [c for c in channels if any(fnmatchcase(c.name, g) for g in args.only)]
    if not channels:
        hint = "".join(did_you_mean(glob, names) for glob in args.only)
        raise ConfigError(f"{args.source}: nothing to convert; see --only and --map.{hint}")
    if not args.map and args.target.suffix.lower() == ".csv":
        channels = _without_units(channels)
    table = measured.common(channels, args.step, args.start, args.stop)
    args.target.parent.mkdir(parents=True, exist_ok=True)
    formats.write(args.target, table)
    count, samples, end = len(table.names) - 1, len(table.rows), float(table.rows[-1, 0])
    say(args, f"{args.target}: {count} signals, {samples} samples to t = {instant(end)} s",
        {"file": str(args.target), "signals": count, "samples": samples, "end": end})  # fmt: skip
    return 0
