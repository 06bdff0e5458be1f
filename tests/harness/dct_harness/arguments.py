"""What the verbs of the command line share: their parsers, and types of arguments."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

Action = Callable[[argparse.Namespace], int]
Verbs = argparse._SubParsersAction


def verb(
    verbs: Verbs, name: str, action: Action, text: str, examples: str
) -> argparse.ArgumentParser:
    """Add a verb that calls `action`; `examples` are lines without `dct-harness` before them."""
    lines = "".join(f"  dct-harness {line}\n" for line in examples.splitlines())
    parser = verbs.add_parser(
        name, help=text, description=f"{text[0].upper()}{text[1:]}.",
        epilog=f"examples:\n{lines}", formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.set_defaults(action=action)
    return parser


def seconds(text: str) -> float:
    """Read a time [s] greater than 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a time greater than 0 s")
    return value


def amount(text: str) -> float:
    """Read a number of at least 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0):
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of at least 0")
    return value
