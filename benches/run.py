"""`cargo xtask bench`: every performance gate in one table, and in target/bench/summary.json."""

from __future__ import annotations

import argparse
import json
import sys

from gates import measured, table
from measure import Bench, results

# Seconds of the scenario and rounds of a measurement: its launch with one lock-up, or all of it.
QUICK, FULL = (3.0, 3), (30.0, 21)


def main() -> int:
    """Measure, print, write; 1 when a gate is missed, but for `--quick`, which judges nothing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a short run that fails on no gate")
    quick = parser.parse_args().quick
    stop, rounds = QUICK if quick else FULL
    gates = measured(Bench(stop, rounds))
    print(table(gates))
    missed = [gate.name for gate in gates if not gate.passed]
    summary = {"quick": quick, "missed": missed, "gates": [gate.summary() for gate in gates]}
    text = json.dumps(summary, indent=1) + "\n"
    (results(quick) / "summary.json").write_text(text, encoding="utf-8")
    if missed:
        print("missed: " + ", ".join(missed), file=sys.stderr)
    return int(bool(missed) and not quick)


if __name__ == "__main__":
    sys.exit(main())
