"""What the verbs of the command line share: their parsers, and types of arguments."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeAlias

from ..fmu import sources
from ..fmu.isolated import Limits

Action = Callable[[argparse.Namespace], int]
WEEKS = 2e6  # s; the milliseconds that poll() waits are an int
ADDRESSABLE = 2.0**40  # MiB, 2^60 bytes
Verbs: TypeAlias = "argparse._SubParsersAction[Any]"


def verb(
    verbs: Verbs, name: str, action: Action, text: str, examples: str, codes: str
) -> argparse.ArgumentParser:
    """Add a verb that calls `action`.

    `examples` are lines without `dct-harness` before them, `codes` its exit codes.
    """
    lines = "".join(f"  dct-harness {line}\n" for line in examples.splitlines())
    ends = "".join(f"  {line}\n" for line in codes.splitlines())
    parser = verbs.add_parser(
        name, help=text, description=f"{text[0].upper()}{text[1:]}.",
        epilog=f"examples:\n{lines}\nexit codes:\n{ends}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.set_defaults(action=action)
    return parser


def add_loudness(parser: argparse.ArgumentParser, told: str, verbose: str = "") -> None:
    """Add --quiet and --json, which prints what is `told`; --verbose where there is more to say."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    if verbose:
        group.add_argument("-v", "--verbose", action="store_true", help=verbose)
    group.add_argument("--json", action="store_true", help=f"print {told} as JSON")


def say(args: argparse.Namespace, text: str, data: Any) -> None:
    """Print a text, or its data as one line of JSON, or nothing: what the command line chose."""
    if args.json:
        print(json.dumps(data, allow_nan=False))
    elif not args.quiet:
        print(text)


def say_outdated(args: argparse.Namespace, fmus: Iterable[Path]) -> None:
    """Name FMUs that are older than their sources, beside what the verb prints."""
    told = sources.remark(fmus)
    if told and not (args.quiet or args.json):
        print(told, file=sys.stderr)


def seconds(text: str) -> float:
    """Read a time [s] greater than 0."""
    return _checked(text, lambda value: value > 0, "a time greater than 0 s")


def moment(text: str) -> float:
    """Read a finite time [s]."""
    return _checked(text, lambda _: True, "a time")


def ratio(text: str) -> float:
    """Read a ratio [1] above 0."""
    return _checked(text, lambda value: value > 0, "a ratio above 0")


def patience(text: str) -> float:
    """Read how long [s] to wait for a call; more than three weeks are three weeks."""
    return min(seconds(text), WEEKS)


def mebibytes(text: str) -> float:
    """Read a size [MiB] greater than 0; more than machines can address is what they can."""
    found = _checked(text, lambda value: value > 0, "a size greater than 0 MiB")
    return min(found, ADDRESSABLE)


def amount(text: str) -> float:
    """Read a number of at least 0."""
    return _checked(text, lambda value: value >= 0, "a number of at least 0")


def called(suffix: str) -> Callable[[str], Path]:
    """Return what reads the name of a file to write, which ends with a suffix."""

    def read(text: str) -> Path:
        path = Path(text)
        if path.suffix.lower() != suffix or path.is_dir():
            raise argparse.ArgumentTypeError(f"'{text}' is not the name of an {suffix} file")
        return path

    return read


def _checked(text: str, is_good: Callable[[float], bool], what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        said = f"'{text}' is not {what}: write the number alone, with a decimal point"
        raise argparse.ArgumentTypeError(said) from None
    if not (math.isfinite(value) and is_good(value)):
        raise argparse.ArgumentTypeError(f"'{text}' is not {what}")
    return value


def add_limits(parser: argparse.ArgumentParser) -> None:
    """Add what a foreign FMU may take."""
    told = ("An FMU that this project did not build runs in a process of its own;\n"
            "with --engine native the whole loop does, in one.")  # fmt: skip
    group = parser.add_argument_group("foreign FMUs", told)
    group.add_argument("--isolate", choices=("foreign", "all", "none"), default="foreign",
                       help="which FMUs get a process of their own (foreign)")  # fmt: skip
    longest = "longest time for a call, or for a step of that loop (%(default)g)"
    group.add_argument("--call-timeout", type=patience, default=Limits.seconds, metavar="SECONDS",
                       help=longest)  # fmt: skip
    group.add_argument("--memory", type=mebibytes, default=Limits.memory, metavar="MIB",
                       help="address space that such a process may take (%(default)g)")  # fmt: skip
    group.add_argument(
        "--fmu-log",
        action="store_true",
        help="ask them to log what they do: why they refuse a call; may be slow",
    )


def limits(args: argparse.Namespace) -> Limits:
    """Return the limits of the command line."""
    return Limits(args.call_timeout, args.memory, args.isolate, args.fmu_log)
