"""`dct-harness identify`: stiffness and damping of the drive shaft from measurements, (17)-(18)."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict
from pathlib import Path

import numpy as np

from .. import measured, shaft
from ..errors import ConfigError, did_you_mean, instant
from ..kpi.typography import minus
from ..units import find, to_si
from .arguments import Verbs, add_loudness, amount, moment, ratio, say, seconds, verb

EXAMPLES = """identify launch.csv
identify drive.mf4 --map names.toml --ratio 11.52 --start 12.5 --step 0.001
identify target/results/paper_case1 --json"""
MAP_HELP = "TOML: [[signals]] with from, to and unit, as for `convert`"
RATIO_HELP = "total ratio from the clutch speed to the wheel (%(default)s)"
NAME_HELP = "signal, also behind a component's name (%(default)s)"
STEP_HELP = "resample to this step, where signals have times of their own"
LENGTH_HELP = "from the built-up torque on (%(default)s); if long, offsets of the speeds add up"
TORQUE_HELP = "|T_o| [N·m] from which rows count (%(default)s): past the backlash"
NAMES = {"clutch_speed": "clutch2.speed", "wheel_speed": "wheel.speed",
         "torque": "driveShaft.torque"}  # fmt: skip
UNITS = {"clutch_speed": "rad/s", "wheel_speed": "rad/s", "torque": "N.m"}
SHOWN = 8  # signals of a file in a sentence
LARGEST = 1e9  # rad/s, N·m: beyond it a value is no measurement, and its square soon no number
INPUTS = {"clutch_speed": "clutch speed, or a ratio {} too low", "wheel_speed": "wheel speed",
          "torque": "torque"}  # fmt: skip
HIGH = 0.01  # by how much an input is read too high, to see what that does
Moves = dict[str, float]  # stiffness [N·m/rad], damping [N·m·s/rad]
REMARKS = {
    "paper": "(18) as printed: noise draws c towards 0",
    "prefilter": f"(18) behind a low-pass of {shaft.estimates.CUTOFF:g} Hz: less so",
    "iv": "instrumental variables: not drawn by white noise",
}

LATE = 0.1  # of the rows, at their end: over these the twist hardly counts beside the speeds
CERTAIN = 3.0  # standard errors below 0 of a damping that is none; those a stiffness must exceed
TWISTED = 0.5  # R² of a fit that follows the torque, be it with the wrong sign

CODES = "0 found, 2 usage, or the source cannot be read, shows no launch, or does not fit --ratio"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "find stiffness and damping of the drive shaft in measurements of a launch"
    parser = verb(verbs, "identify", identify, text, EXAMPLES, CODES)
    parser.add_argument("source", type=Path, help="result directory or file (.csv, .parquet, .mf4)")
    parser.add_argument("--map", type=Path, metavar="FILE", help=MAP_HELP)
    option = parser.add_argument
    option("--ratio", type=ratio, default=shaft.TABLE_1.ratios[1], metavar="G", help=RATIO_HELP)
    for key, name in NAMES.items():
        option(f"--{key.replace('_', '-')}", default=name, metavar="NAME", help=NAME_HELP)
    option("--step", type=seconds, metavar="SECONDS", help=STEP_HELP)
    window = shaft.Window()
    option("--start", type=moment, default=window.start, metavar="T",
           help="not before this time [s]")  # fmt: skip
    option("--length", type=seconds, default=window.length, metavar="SECONDS", help=LENGTH_HELP)
    option("--built-up", type=amount, default=window.built_up, metavar="TORQUE", help=TORQUE_HELP)
    add_loudness(parser, "what each method finds")


def identify(args: argparse.Namespace) -> int:
    """Print what each method finds; returns 0."""
    channels = measured.read(args.source)
    if args.map:
        channels = measured.Mapping.load(args.map).apply(channels)
    chosen = [_channel(channels, option, getattr(args, option), args.source) for option in NAMES]
    rows = measured.common(chosen, args.step, None, None).rows
    window = shaft.Window(args.built_up, args.length, args.start)
    fits = _fits(rows, args.ratio, window)
    ratios = f"the speeds end there as {_ratio(rows, fits[0]):.4g} : 1, --ratio is {args.ratio:g}"
    _check(fits, ratios)
    moved = _moved(rows, args.ratio, window, fits)
    text = f"{_largest(rows)}\n{table(fits, ratios)}\n\n{_doubt(fits[-1], moved[-1])}"
    told = [asdict(fit) | {"readTooHigh": {"share": HIGH, **moves}}
            for fit, moves in zip(fits, moved, strict=True)]  # fmt: skip
    say(args, text, told)
    return 0


def _fits(rows: np.ndarray, ratio: float, window: shaft.Window) -> list[shaft.Fit]:
    """Return what each method finds in rows of time, ω_c, ω_w and T_o."""
    rate = rows[:, 1] / ratio - rows[:, 2]
    return [shaft.identify(rows[:, 0], rate, rows[:, 3], window, m) for m in shaft.METHODS]


def _moved(
    rows: np.ndarray, ratio: float, window: shaft.Window, fits: list[shaft.Fit]
) -> list[dict[str, Moves]]:
    """Return by method and input how far k_o and c_o go when that input is read too high."""
    found: list[dict[str, Moves]] = [{} for _ in fits]
    for column, name in enumerate(NAMES, 1):
        scale = np.ones(rows.shape[1])
        scale[column] += HIGH
        for moves, was, now in zip(found, fits, _fits(rows * scale, ratio, window), strict=True):
            moves[name] = {"stiffness": now.stiffness.value - was.stiffness.value,
                           "damping": now.damping.value - was.damping.value}  # fmt: skip
    return found


def _largest(rows: np.ndarray) -> str:
    """Return how large the inputs become: nothing else tells the unit of a column without one."""
    clutch, wheel, torque = np.abs(rows[:, 1:]).max(axis=0)
    _, per_minute, _ = to_si("rpm")
    return (
        f"clutch speed up to {clutch / per_minute:.0f} rpm, wheel {wheel / per_minute:.0f} rpm, "
        f"torque {torque:.4g} N·m, where no unit is stated read as rad/s and N·m"
    )


def _doubt(fit: shaft.Fit, moves: dict[str, Moves]) -> str:
    """Return what errors that are no noise would do, a line per input."""
    share = f"{100 * HIGH:g} %"
    lines = [f"± is of white noise alone. An input that is read {share} too high moves what "
             f"{fit.method} finds by"]  # fmt: skip
    whole = {"stiffness": fit.stiffness.value, "damping": fit.damping.value}
    for name, label in INPUTS.items():
        percents = (100 * moves[name][key] / (value or math.nan) for key, value in whole.items())
        k, c = (minus(f"{_two_digits(percent)} %") for percent in percents)
        lines.append(f"  {label.format(share):42} k_o {k:>8}  c_o {c:>8}")
    return "\n".join(lines)


def _two_digits(percent: float) -> str:
    return f"{percent:+.0f}" if abs(percent) >= 99.5 else f"{percent:+.2g}"


def _ratio(rows: np.ndarray, fit: shaft.Fit) -> float:
    """Return ω_c/ω_w over the last tenth of the rows used, where the twist moves least."""
    late = fit.end - LATE * (fit.end - fit.start)
    clutch, wheel = rows[(rows[:, 0] >= late) & (rows[:, 0] <= fit.end), 1:3].sum(axis=0)
    return float(clutch / wheel) if wheel else math.inf


def _check(fits: list[shaft.Fit], ratios: str) -> None:
    """Refuse what no shaft has: a wrong ratio gives it, with an R² near 1 and small errors."""
    best = fits[-1]
    k, c = best.stiffness, best.damping
    if abs(k.value) <= CERTAIN * k.error:
        raise ConfigError(
            f"k_o = {k.value:.5g} ± {k.error:.2g} N·m/rad ({best.method}): noise hides the twist "
            "of the shaft; take a launch whose torque changes more, or a longer --length"
        )
    if k.value < 0 and c.value < 0 and best.r_squared > TWISTED:
        raise ConfigError(
            f"k_o = {k.value:.5g} N·m/rad, c_o = {c.value:.5g} N·m·s/rad ({best.method}), both "
            "below 0: torque and speeds differ in sign; a --map file can say factor = -1"
        )
    for fit in fits:
        k, c = fit.stiffness, fit.damping
        if k.value <= 0 or c.value + CERTAIN * c.error < 0:
            raise ConfigError(
                f"k_o = {k.value:.5g} N·m/rad, c_o = {c.value:.5g} N·m·s/rad ({fit.method}): no "
                f"shaft has that, so clutch, gear or sign are others; {ratios}"
            )


def _channel(
    channels: list[measured.Channel], option: str, name: str, source: Path
) -> measured.Channel:
    """Return the channel of a name, also behind a component's, in its SI unit."""
    names = [channel.name for channel in channels]
    behind = [n for n in names if n.endswith(f".{name}") and n.count(".") == name.count(".") + 1]
    for candidate in (name, f"plant.{name}", *(behind if len(behind) == 1 else ())):
        if names.count(candidate) > 1:
            raise ConfigError(f"{source}: two signals are called '{candidate}'; rename one")
        if candidate in names:
            return _in_si(channels[names.index(candidate)], UNITS[option], source)
    more = ", …" if len(names) > SHOWN else ""
    hint = did_you_mean(name, names) or f" There are {', '.join(names[:SHOWN])}{more}."
    other = f" --{option.replace('_', '-')} names another."
    raise ConfigError(f"{source}: no signal '{name}'.{hint}{other}")


def _in_si(channel: measured.Channel, wanted: str, source: Path) -> measured.Channel:
    """Return a channel in its SI unit; refuse other units, and values that nobody measured."""
    (found,), strange = measured.in_si([channel])
    unit, plain = find(channel.unit), find(wanted)
    if strange or (channel.unit and unit and plain and unit.exponents != plain.exponents):
        raise ConfigError(
            f"{source}: '{channel.name}' is in '{channel.unit}', which is no unit of [{wanted}]: "
            "a --map file can say unit, or factor and offset"
        )
    bad = np.flatnonzero(~(np.abs(found.values) <= LARGEST))
    if bad.size:
        value, time = found.values[bad[0]], found.time[bad[0]]
        raise ConfigError(
            f"{source}: '{channel.name}' is {value:g} {wanted} at t = {instant(time)} s: leave "
            "such samples empty and give --step"
        )
    return found


def table(fits: list[shaft.Fit], ratios: str) -> str:
    """Return the fits as people read them."""
    head = fits[0]
    lines = [f"{head.samples} rows, t = {head.start:g} s to {head.end:g} s; {ratios}", ""]
    columns = f"{'method':10} {'k_o [N·m/rad]':>18} {'c_o [N·m·s/rad]':>18} {'R²':>9}"
    lines.append(columns)
    for fit in fits:
        k, c = (f"{e.value:.5g} ± {e.error:.2g}" for e in (fit.stiffness, fit.damping))
        lines.append(f"{fit.method:10} {k:>18} {c:>18} {fit.r_squared:9.5f}  {REMARKS[fit.method]}")
    return "\n".join(lines)
