"""Command line `dct-harness`: the verbs, each a module of `verbs`, and the exit codes."""

from __future__ import annotations

import argparse
import os
import sys

from .errors import ConfigError, HarnessError, InterruptedRunError
from .verbs import (
    check,
    compare,
    completion,
    convert,
    doctor,
    export_container,
    export_ssp,
    identify,
    report,
    run,
    sweep,
)
from .verbs import map as map_verb
from .verbs.suggesting import Parser

VERBS = (run, check, map_verb, report, compare, convert, identify, sweep, export_ssp,
         export_container, doctor, completion)  # fmt: skip
CLOSED_PIPE = 141  # as a shell reports SIGPIPE
EXIT_CODES = """exit codes:
  0 pass, 1 KPI or regression fails, 2 usage or configuration, 3 FMU invalid,
  4 FMU failed at run time or asked to end the simulation before stop, 5 timeout,
  6 no binary for this platform, 130 interrupted (the samples until then are kept)

`dct-harness VERB --help` shows options and examples.
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    style = argparse.RawDescriptionHelpFormatter
    found = Parser(
        "dct-harness", formatter_class=style, epilog=EXIT_CODES,
        description="Closed loops of FMI 2.0 co-simulation FMUs: run, judge, report.",
    )  # fmt: skip
    verbs = found.add_subparsers(dest="verb", required=True, metavar="VERB")
    for module in VERBS:
        module.add(verbs)
    return found


def main(argv: list[str] | None = None) -> int:
    """Run one verb; returns the documented exit code."""
    args = parser().parse_args(argv)
    try:
        code: int = args.action(args)
        sys.stdout.flush()
        return code
    except HarnessError as error:
        print(f"dct-harness: {error}", file=sys.stderr)
        return error.exit_code
    except MemoryError as error:
        print(f"dct-harness: out of memory: {error or 'fewer steps or signals'}", file=sys.stderr)
        return ConfigError.exit_code
    except BrokenPipeError:  # `| head`: whoever reads has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return CLOSED_PIPE
    except OSError as error:  # a file that cannot be made, a disk that is full
        where = error.filename or getattr(args, "out", None) or getattr(args, "target", None)
        what = error.strerror or error
        print(f"dct-harness: {where}: {what}" if where else f"dct-harness: {what}", file=sys.stderr)
        return ConfigError.exit_code
    except KeyboardInterrupt:
        print("dct-harness: interrupted", file=sys.stderr)
        return InterruptedRunError.exit_code


if __name__ == "__main__":
    sys.exit(main())
