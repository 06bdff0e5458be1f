"""`run --check-step`: the run again at half the communication step, and what changes."""

from __future__ import annotations

import argparse
import copy
import json
from pathlib import Path
from typing import Any

import numpy as np

from .. import results
from .master import Run

FILE = "check_step.json"
SHOWN = 5


def check(loop: Run, out: Path, args: argparse.Namespace) -> bool:
    """Repeat a run at half its step, write and print the changes; returns whether all are small.

    A change is the RMS difference in % of the RMS value, over the times that both runs have.
    """
    model = copy.deepcopy(loop.system)
    model.step = loop.system.step / 2
    fine = Run(model, loop.paths, loop.mapping, loop.limits)
    fine.execute()
    found = changes(loop, fine)
    record = {"step": loop.system.step, "half": model.step, "limit": args.check_step,
              "changes": found}  # fmt: skip
    results.write_text(out / FILE, json.dumps(record, indent=2) + "\n")
    worst = max((c["percent"] for c in found), default=0.0)
    if not (args.quiet or args.json):
        _say(found, model.step, args.check_step)
    return worst <= args.check_step


def changes(coarse: Run, fine: Run) -> list[dict[str, Any]]:
    """Return name and change of each real output, the largest first."""
    both = fine.rows[np.searchsorted(fine.times, coarse.times - fine.system.step / 4)]
    found = []
    for k, name in enumerate(coarse.names):
        if name in coarse.discrete or name.startswith("scenario."):
            continue
        size = float(np.sqrt(np.mean(coarse.rows[:, k] ** 2)))
        change = float(np.sqrt(np.mean((both[:, k] - coarse.rows[:, k]) ** 2)))
        if size > 0:
            found.append({"signal": name, "percent": 100 * change / size})
    return sorted(found, key=lambda c: -c["percent"])


def _say(found: list[dict[str, Any]], step: float, limit: float) -> None:
    print(f"\nchange of the outputs at a step of {step:g} s, RMS (limit {limit:g} %):")
    for change in found[:SHOWN]:
        print(f"  {change['signal']:32} {change['percent']:.3g} %")
    small = all(c["percent"] <= limit for c in found)
    print(f"verdict: {'the step is small enough' if small else 'the step is too long'}")
