"""`cargo xtask bench growth`: cost of the compiled master as the work grows, table and plot.

Five axes, each varied alone: runs, communication step, recorded signals, instances in a process,
threads. Every point is a process of its own. Writes growth.md, growth.json and growth.svg into
target/bench; the docs hold a copy. Shown is CPU time, which others on the machine disturb least;
growth.json has the time that passed too.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import growth_point
import numpy as np
from growth_plot import draw, table
from loops import LOOP, planned
from measure import ROOT, WORK, results
from measure import run as measured

KEPT = ["plant.vehicle.speed"]
START = {"engine.speed_start": 90.0, "engine.torque": 60.0, "clutch1.position": 0.006}
STIFFNESS = 4000.0  # N·m/rad of the first instance that has parameters of its own
SHORT, LONG = 3.0, 30.0  # s
STEP = 1e-3  # s


@dataclass
class Point:
    """A measured point: `size` along its axis, `units` of work of which one costs so much."""

    axis: str
    size: float
    units: float
    cpu: float
    wall: float
    memory: float


class Growth:
    """The loop of torque tracking; `scale` shortens every axis."""

    def __init__(self, quick: bool) -> None:
        self.quick = quick
        WORK.mkdir(parents=True, exist_ok=True)
        self.short, self.long = (0.1, 1.0) if quick else (SHORT, LONG)

    def _sizes(self, sizes: list[float]) -> list[float]:
        return sizes[:2] if self.quick else sizes

    def _measure(
        self, plan: dict[str, Any], times: np.ndarray, script: np.ndarray,
        runs: int = 1, threads: int = 1,
    ) -> dict[str, float]:  # fmt: skip
        files = {name: str(WORK / f"growth_{name}.npy") for name in ("times", "script")}
        np.save(files["times"], times)
        np.save(files["script"], np.ascontiguousarray(script))
        rounds = 1 if runs * len(times) > 1e6 or self.quick else 3
        work = {"plan": plan, "runs": runs, "threads": threads, "rounds": rounds, **files}
        path = WORK / "growth_work.json"
        path.write_text(json.dumps(work), encoding="utf-8")
        return json.loads(measured(sys.executable, growth_point.__file__, path))

    def _loop(self, step: float, stop: float) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
        run = planned(LOOP, step, stop)
        return json.loads(run.plan), run.times, run.script

    def runs(self) -> Iterator[Point]:
        """Runs of 3 s at 1 ms that keep one signal, on two threads."""
        plan, times, script = self._loop(STEP, self.short)
        plan["record"] = KEPT
        for n in self._sizes([10, 30, 100, 300, 1000, 3000, 10_000]):
            told = self._measure(plan, times, script, runs=int(n), threads=2)
            yield Point("runs", n, n, **told)

    def steps(self) -> Iterator[Point]:
        """One run of 30 s in ever shorter steps that keeps all signals."""
        for steps_per_second in self._sizes([10, 30, 100, 300, 1000, 3000, 10_000]):
            plan, times, script = self._loop(1.0 / steps_per_second, self.long)
            told = self._measure(plan, times, script)
            yield Point("steps per second", steps_per_second, len(times) - 1, **told)

    def signals(self) -> Iterator[Point]:
        """One run of 30 s at 1 ms that keeps some of its signals."""
        plan, times, script = self._loop(STEP, self.long)
        every = planned(LOOP, STEP, self.long).names
        for n in [*self._sizes([0, 1, 3, 10, 30]), len(every)]:
            told = self._measure({**plan, "record": every[: int(n)]}, times, script)
            yield Point("recorded signals", n, len(times) - 1, **told)

    def instances(self, own: bool) -> Iterator[Point]:
        """Plants in one process, 100 steps at 1 ms; with parameters of their own or all alike."""
        fmu = str(ROOT / "target" / "fmu" / "DctPlant.fmu")
        times = STEP * np.arange(101)
        axis = "instances, own parameters" if own else "instances"
        for n in self._sizes([1, 10, 100, 1000, *([] if own else [10_000])]):
            starts = [{**START, **({"driveShaft.stiffness": STIFFNESS + k} if own else {})}
                      for k in range(int(n))]  # fmt: skip
            parts = [{"name": f"plant{k}", "fmu": fmu, "start": list(start.items()), "inputs": []}
                     for k, start in enumerate(starts)]  # fmt: skip
            plan = {"components": parts, "script": [], "record": []}
            told = self._measure(plan, times, np.zeros((len(times), 0)))
            yield Point(axis, n, n, **told)

    def threads(self) -> Iterator[Point]:
        """64 runs of 3 s at 1 ms that keep one signal."""
        plan, times, script = self._loop(STEP, self.short)
        plan["record"] = KEPT
        for n in self._sizes([1, 2, 4, 8, 16, 32, 64]):
            yield Point("threads", n, 64, **self._measure(plan, times, script, 64, int(n)))

    def all(self) -> Iterator[Point]:
        """Every axis."""
        yield from self.runs()
        yield from self.steps()
        yield from self.signals()
        yield from self.instances(own=False)
        yield from self.instances(own=True)
        yield from self.threads()


def main() -> int:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="two short points of each axis")
    quick = parser.parse_args().quick
    folder = results(quick)
    points = list(Growth(quick).all())
    told = [asdict(point) for point in points]
    text = table(told)
    print(text, end="")
    out = {"growth.md": text, "growth.json": json.dumps(told, indent=1) + "\n"}
    for name, content in out.items():
        (folder / name).write_text(content, encoding="utf-8")
    draw(told, folder / "growth.svg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
