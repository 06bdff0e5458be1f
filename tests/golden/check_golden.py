"""Measure how accurate the golden files are: tighter settings, and a second solution by Radau."""

from __future__ import annotations

import argparse
import json

import numpy as np
from make_golden import CASES, HERE, run_case
from radau_check import SIGN_OF, RadauRun

EVENT_GUARD = 2e-3  # [s] rows this near an event are left out of the torque comparison
SPEEDS, TORQUES = slice(1, 7), slice(7, 12)


def stored(case):
    """Rows and events of the files of `case`."""
    rows = np.loadtxt(HERE / f"{case.name}.csv", delimiter=",", skiprows=1, ndmin=2)
    return rows, json.loads((HERE / f"{case.name}.events.json").read_text())


def report(label, a, b, times, pairs):
    """Print the largest differences of two row tables and of event times."""
    a, b = np.asarray(a)[:, :12], np.asarray(b)[:, :12]
    count = min(len(a), len(b))
    diff = np.abs(a[:count] - b[:count])
    far = np.all(np.abs(a[:count, :1] - np.append(times, -1.0)) > EVENT_GUARD, axis=1)
    event = max((abs(x - y) for x, y in pairs), default=0.0)
    print(f"{label}: {count} rows, speeds {diff[:, SPEEDS].max():.1e} rad/s,", end=" ")
    print(f"torques {diff[far, TORQUES].max():.1e} N·m away from events", end=" ")
    print(f"({diff[:, TORQUES].max():.1e} at any row), event times {event:.1e} s", flush=True)


def check_tight(case, longest, stages):
    """Compare the files with pieces of `longest` [s] and `stages` collocation nodes."""
    rows, events = stored(case)
    tight = run_case(case, longest, stages)
    times = [e["time"] for e in events]
    pairs = list(zip(times, [e["time"] for e in tight.events], strict=True))
    report(f"{case.name} tightened", rows, tight.rows, times, pairs)


def initial_mode(case):
    """Modes of clutches and brake at the start and the way the output turns, one piece later."""
    simulation = case.simulation()
    first = next(iter(case.pieces(simulation.plant.p)))
    simulation.run([first])
    clutches = (SIGN_OF.get(*_state(simulation, i)) for i in range(2))
    return [*clutches, simulation.mode[2], getattr(simulation, "turns", None)]


def _state(simulation, i):
    number = simulation.rows[0][12 + i]
    slip = simulation.plant.slip[i] @ simulation.x
    return {1: "disengaged", 2: "slipping", 3: "engaged"}[number], int(np.sign(slip))


def check_radau(case, stop):
    """Compare the files of a case with `RadauRun`."""
    rows, events = stored(case)
    run = RadauRun(case, events, initial_mode(case)).run(stop)
    times = [e["time"] for e in events]
    report(f"{case.name} against Radau", rows[1:], run.rows, times, run.times)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", nargs="+", help="case names")
    parser.add_argument("--radau", action="store_true", help="second solution instead of tighter")
    parser.add_argument("--stop", type=float, help="compare up to this time [s] (Radau only)")
    parser.add_argument("--longest", type=float, default=2.5e-4, help="longest piece [s]")
    parser.add_argument("--stages", type=int, default=8, help="collocation nodes")
    args = parser.parse_args()
    known = {case.name: case for case in CASES}
    for name in args.case:
        if args.radau:
            check_radau(known[name], args.stop)
        else:
            check_tight(known[name], args.longest, args.stages)


if __name__ == "__main__":
    main()
