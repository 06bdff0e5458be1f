"""Closed loops by the compiled master: against the loop on fmpy, on threads, and around nothing.

CPU times of paired rounds. Every engine steps the same FMUs over the same seconds and keeps every
signal of each step; loading and writing stay out.
"""

from __future__ import annotations

import json
import time
import zipfile
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from dct_harness import system
from dct_harness.master import Run
from dct_harness.native import NativeRun
from measure import ROOT, WORK

LOOP = ROOT / "examples" / "closed_loop" / "torque_tracking_case1.toml"
MANY = 20  # runs that are given to threads
BULK = 3  # runs of the quick engine in one measurement
NOTHING = 200_000  # steps around two empty FMUs
INPUTS, OUTPUTS = range(5), range(5, 10)  # value references of the empty C FMU


def _cpu(action: Callable[[], Any]) -> float:
    """Return the CPU time of a call [s], of all threads."""
    begun = time.process_time()
    action()
    return time.process_time() - begun


class _Timed(Run):
    """A run that notes the CPU time of its loop [s]."""

    spent = 0.0

    def _loop(self, progress: Any) -> None:
        self.spent = _cpu(lambda: super(_Timed, self)._loop(progress))


class _Planned(NativeRun):
    """A run that stops where the compiled master would take over, and keeps the plan."""

    plan = ""

    def _loop(self, progress: Any) -> None:
        self.plan = json.dumps(self._plan())


class Loops:
    """The loop of one system file, over the first `stop` seconds of its scenario."""

    def __init__(self, stop: float, rounds: int) -> None:
        import cosim_native

        self.module = cosim_native
        self.rounds = max(3, rounds // 4)
        self.model = system.load(LOOP)
        self.model.stop = stop
        self.paths = {n: ROOT / "target/fmu" / c.fmu for n, c in self.model.components.items()}

    @cached_property
    def steps(self) -> int:
        """Communication steps of a run."""
        return len(self._planned.times) - 1

    @cached_property
    def _planned(self) -> _Planned:
        run = _Planned(self.model, self.paths)
        run.execute()
        return run

    def native(self, runs: int, threads: int, points: int | None = None) -> float:
        """Return the CPU time of one run by the compiled master [s], over the first `points`."""
        run = self._planned
        script = np.ascontiguousarray(run.script[:points])
        work = ([run.plan] * runs, run.times[:points], script, threads)
        return _cpu(lambda: self.module.run(*work)) / runs

    def compiled(self) -> float:
        """Return the CPU time of the loop by the compiled master [s], without loading."""
        return self.native(BULK, 1) - self.native(BULK, 1, points=2)

    def fmpy(self) -> float:
        """Return the CPU time of the loop on fmpy [s]."""
        run = _Timed(self.model, self.paths)
        run.execute()
        return run.spent

    @cached_property
    def engines(self) -> np.ndarray:
        """CPU time of a loop on fmpy and by the compiled master [s], shape (rounds, 2)."""
        return np.array([(self.fmpy(), self.compiled()) for _ in range(self.rounds)])

    @cached_property
    def threads(self) -> np.ndarray:
        """CPU time of a run among many, on one and on two threads [s], shape (rounds, 2)."""
        return np.array([(self.native(MANY, 1), self.native(MANY, 2)) for _ in range(3)])

    def nothing(self, library: Path) -> float:
        """Return the CPU time of a step of two empty FMUs that feed each other [s]."""
        plan = json.dumps(_pair(_packed(library)))
        times = 1e-3 * np.arange(NOTHING + 1)
        script = np.zeros((len(times), 0))
        spent = [_cpu(lambda: self._whole(plan, times, script)) for _ in range(self.rounds)]
        return float(np.median(spent)) / NOTHING

    def _whole(self, plan: str, times: np.ndarray, script: np.ndarray) -> None:
        ((_, rows, error),) = self.module.run([plan], times, script, 1)
        if error or len(rows) != len(times):
            raise SystemExit(f"two empty FMUs: {error}")


def _packed(library: Path) -> Path:
    """Return the empty C FMU as a file."""
    path = WORK / "Empty.fmu"
    variables = "".join(
        f'<ScalarVariable name="v{k}" valueReference="{k}" causality="{causality}"><Real{start}/>'
        "</ScalarVariable>"
        for group, causality, start in (
            (INPUTS, "input", ' start="0"'),
            (OUTPUTS, "output", ""),
        )
        for k in group
    )
    unknowns = "".join(f'<Unknown index="{k + 1}" dependencies=""/>' for k in OUTPUTS)
    description = (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="Empty" guid="peer">'
        '<CoSimulation modelIdentifier="Empty" canHandleVariableCommunicationStepSize="true"/>'
        f"<ModelVariables>{variables}</ModelVariables>"
        f"<ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, "binaries/linux64/Empty.so")
    return path


def _pair(fmu: Path) -> dict[str, Any]:
    """Return the plan of two components, each of which reads all outputs of the other."""
    names = ("one", "other")
    pairs = list(zip(INPUTS, OUTPUTS, strict=True))
    feeds = [
        [{"name": f"v{i}", "source": f"{giver}.v{o}"} for i, o in pairs]
        for giver in reversed(names)
    ]
    parts = [{"name": n, "fmu": str(fmu), "inputs": f} for n, f in zip(names, feeds, strict=True)]
    return {"components": parts, "script": []}
