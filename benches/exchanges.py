"""What an exchange of the observer and of the clutch control costs, each alone.

The compiled master first runs the loop of all three, every FMU reading what was there at the start
of a step (Jacobi). Then one FMU at a time is played what it read there, and has to answer with the
same bits. So each cost is that of the very steps of the loop, per simulated millisecond, outputs
read and kept. It stands against that of an empty C FMU in the same master, which sets and gets
five Reals.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from gate import Gate
from loops import Loops

OBSERVER, CONTROL, METHOD = "observer", "control", "observer.method"
# Empty exchanges that one may cost: what was reached on the bench, with a third for a machine with
# other caches and divisions.
LIMITS = {"paper": 15.0, "lyapunov": 15.0, "energy": 18.0, "kalman": 27.0, "calibrating": 80.0}
CONTROL_LIMIT = 4.7


def exchanges(made: Loops, empty_c: Path) -> list[Gate]:
    """Judge the observer by each method, and the control."""
    empty = made.nothing(empty_c) / 2
    gates = [
        _gate(f"observer, {method} / empty C FMU", made, _by(made, method), OBSERVER, limit, empty)
        for method, limit in LIMITS.items()
    ]
    plan = json.loads(made.plan)
    gates.append(_gate("control / empty C FMU", made, plan, CONTROL, CONTROL_LIMIT, empty))
    return gates


def _by(made: Loops, method: str) -> dict[str, Any]:
    """Return the loop with another method of the observer."""
    plan = json.loads(made.plan)
    start = _part(plan, OBSERVER)["start"]
    start[:] = [pair for pair in start if pair[0] != METHOD] + [[METHOD, method]]
    return plan


def _part(plan: dict[str, Any], name: str) -> dict[str, Any]:
    return next(part for part in plan["components"] if part["name"] == name)


def _gate(
    name: str, made: Loops, plan: dict[str, Any], part: str, limit: float, empty: float
) -> Gate:
    alone, script = _played(made, plan, part)
    spent = np.median([made.cost(alone, script) for _ in range(made.rounds)]) / made.steps
    return Gate(name, spent / empty, limit, beside=f"{spent * 1e9:.0f} / {empty * 1e9:.0f} ns")


def _played(made: Loops, plan: dict[str, Any], name: str) -> tuple[str, np.ndarray]:
    """Return the plan of one FMU that is played what it reads in the loop, and what that is.

    Raises
    ------
    SystemExit
        It does not answer as in the loop, all bits of it.
    """
    names, rows = made.rows(json.dumps({**plan, "coupling": "jacobi"}), made.script)
    column = {signal: k for k, signal in enumerate(names)}
    part = _part(plan, name)
    read = [column[given["source"]] for given in part["inputs"]]
    played = [{**given, "source": f"scenario.{given['name']}"} for given in part["inputs"]]
    alone = json.dumps({
        "components": [{**part, "inputs": played}],
        "script": [given["name"] for given in part["inputs"]],
    })  # fmt: skip
    script = np.ascontiguousarray(rows[:, read])
    told, answers = made.rows(alone, script)
    answers = answers[:, len(read) :]
    if not np.array_equal(answers, rows[:, [column[signal] for signal in told[len(read) :]]]):
        raise SystemExit(f"{name} alone does not answer as in the loop")
    return alone, script
