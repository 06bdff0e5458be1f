"""`benches/run.py --quick`: the bench runs, and what repeats exactly keeps its limit."""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

# Gates that no machine and no load can change, and that hold in a short run as well.
EXACT = (
    "empty model / empty C FMU",
    "plant at 1 ms / empty C FMU",
    "heap calls in exchanges",
    "heap calls in a first stop",
    "heap calls in new step sizes",
    "heap of an instance",
    "heap of a parameter set",
    "library, stripped (--small)",
)
QUICK = ROOT / "target/bench/quick"


@pytest.fixture(scope="module")
def summary() -> dict:
    """Run the bench over the first seconds of the scenario."""
    done = subprocess.run([sys.executable, "benches/run.py", "--quick"], cwd=ROOT, check=False,
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((QUICK / "summary.json").read_text(encoding="utf-8"))
    assert all(gate["name"] in done.stdout for gate in summary["gates"])
    return summary


def test_every_gate_has_a_value_a_limit_and_a_verdict(summary: dict) -> None:
    gates = [gate for gate in summary["gates"] if gate["limit"] is not None]
    assert (len(gates), len(summary["gates"])) == (31, 33)
    for gate in gates:
        sign = 1 if gate["at_least"] else -1
        assert gate["passed"] == (sign * (gate["value"] - gate["limit"]) >= 0), gate["name"]


def test_missed_gates_are_named(summary: dict) -> None:
    missed = [gate["name"] for gate in summary["gates"] if not gate["passed"]]
    assert summary["missed"] == missed


@pytest.mark.parametrize("name", EXACT)
def test_a_gate_that_repeats_exactly_is_kept(summary: dict, name: str) -> None:
    (gate,) = (gate for gate in summary["gates"] if gate["name"] == name)
    assert gate["passed"], gate


def test_growth_measures_two_points_of_every_axis_and_draws_them() -> None:
    done = subprocess.run([sys.executable, "benches/growth.py", "--quick"], cwd=ROOT, check=False,
                          capture_output=True, text=True)  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    points = json.loads((QUICK / "growth.json").read_text(encoding="utf-8"))
    axes = Counter(point["axis"] for point in points)
    assert len(axes) == 6
    assert all(count >= 2 for count in axes.values())
    assert all(point["cpu"] > 0 and point["wall"] > 0 for point in points)
    drawn = (QUICK / "growth.svg").read_text(encoding="utf-8")
    assert "<svg" in drawn
    assert done.stdout == (QUICK / "growth.md").read_text(encoding="utf-8")
