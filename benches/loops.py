"""Closed loops by the compiled master: against loops of other masters, on threads, around nothing.

CPU times of paired rounds. Every engine steps the same FMUs over the same seconds; loading and
writing stay out. ecos keeps no signal, so beside it the compiled master keeps none either; runs of
a sweep keep the signals of the KPIs, as `dct-harness sweep` does, and once more every signal; all
others keep every signal of each step, in memory that the process has had before.
"""

from __future__ import annotations

import itertools
import json
import resource
import sys
import time
import zipfile
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import dask_sweep
import fmpy_loop
import in_ecos
import numpy as np
from dct_harness import kpi
from dct_harness.master.master import Run
from dct_harness.master.native import NativeRun
from dct_harness.sweep.cases import Job
from dct_harness.sweep.runs import Prepared, Setup
from dct_harness.sweep.store import Store
from dct_harness.system import system
from measure import ROOT, WORK
from measure import run as measured

LOOP = ROOT / "examples" / "closed_loop" / "torque_tracking_case1.toml"
FMUS = ROOT / "target" / "fmu"
MANY = 20  # runs that are given to threads
BULK = 3  # runs of the quick engine in one measurement
NOTHING = 200_000  # steps around two empty FMUs
SWEPT = 8  # runs on dask; a thousand would be a thousand times the same
HELD = 5.0  # s; the scenario's instant whose values ecos is given
SAME_LOOP = 1e-3  # relative; ecos is a Jacobi master
REPEAT = WORK / "bin" / "repeat"  # by `cargo xtask bench`, from src/master/examples
INPUTS, OUTPUTS = range(5), range(5, 10)  # value references of the empty C FMU


def _cpu(action: Callable[[], Any]) -> float:
    """Return the CPU time of a call [s], of all threads."""
    begun = time.process_time()
    action()
    return time.process_time() - begun


def _children() -> float:
    """Return the CPU time of all programs that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


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
        self.script = np.ascontiguousarray(self.script)


def planned(file: Path, step: float, stop: float) -> _Planned:
    """Return the loop of a system file, ready for the compiled master."""
    model = system.load(file)
    model.step, model.stop = step, stop
    run = _Planned(model, {n: FMUS / c.fmu for n, c in model.components.items()})
    run.execute()
    return run


class Loops:
    """The loop of one system file, over the first `stop` seconds of its scenario."""

    def __init__(self, stop: float, rounds: int) -> None:
        import cosim_native

        self.module = cosim_native
        self.rounds = max(3, rounds // 4)
        self._memory: list[np.ndarray] = []  # for the rows of runs, one per thread
        self.model = system.load(LOOP)
        self.model.stop = stop
        self.paths = {n: FMUS / c.fmu for n, c in self.model.components.items()}

    @cached_property
    def steps(self) -> int:
        """Communication steps of a run."""
        return len(self._planned.times) - 1

    @cached_property
    def _planned(self) -> _Planned:
        return planned(LOOP, self.model.step, self.model.stop)

    @property
    def plan(self) -> str:
        """The loop as `cosim_master::Plan` in JSON."""
        return self._planned.plan

    @property
    def script(self) -> np.ndarray:
        """The scenario's signals, shape (samples, signals)."""
        return self._planned.script

    def rows(self, plan: str, script: np.ndarray) -> tuple[list[str], np.ndarray]:
        """Return the names of all signals of a plan, and what the compiled master makes of them."""
        ((names, rows, error, _),) = self.module.run([plan], self._planned.times, script, 1)
        if error:
            raise SystemExit(f"compiled master: {error}")
        return names, rows

    def cost(self, plan: str, script: np.ndarray) -> float:
        """Return the CPU time of a plan by the compiled master [s], without loading."""
        whole, start = (self._bulk(plan, script, BULK, 1, points) for points in (None, 2))
        return whole - start

    def native(self, runs: int, threads: int, plan: str | None = None) -> float:
        """Return the CPU time of one run by the compiled master [s]; of another `plan`."""
        return self._bulk(plan or self.plan, self.script, runs, threads, None)

    def _bulk(
        self, plan: str, script: np.ndarray, runs: int, threads: int, points: int | None
    ) -> float:
        times, rows = self._planned.times[:points], np.ascontiguousarray(script[:points])
        ((names, *_),) = self.module.run([plan], times[:2], rows[:2])
        out = self._arrays(threads, len(times), len(names))

        def calls() -> None:
            fmus = self.module.Fmus()
            for _ in range(runs // threads):
                self.module.run([plan] * threads, times, rows, threads, out=out, fmus=fmus)

        return _cpu(calls) / runs

    def _arrays(self, count: int, rows: int, columns: int) -> list[np.ndarray]:
        """Return arrays in memory that this process has had: new one can cost more than a run."""
        size = rows * columns
        for k in range(count):
            if k == len(self._memory):
                self._memory.append(np.ones(0))
            if self._memory[k].size < size:
                self._memory[k] = np.ones(size)
        return [memory[:size].reshape(rows, columns) for memory in self._memory[:count]]

    def compiled(self) -> float:
        """Return the CPU time of the loop by the compiled master [s], without loading."""
        return self.cost(self.plan, self.script)

    def alone(self) -> float:
        """Return the CPU time of the loop by the compiled master without Python [s]."""
        return self._program(BULK, None) - self._program(BULK, 2)

    def _program(self, runs: int, points: int | None) -> float:
        run = self._planned
        for name, values in (("times", run.times), ("script", run.script)):
            np.ascontiguousarray(values[:points]).tofile(WORK / f"loop_{name}.bin")
        (WORK / "loop_plan.json").write_text(run.plan, encoding="utf-8")
        files = [WORK / f"loop_{name}" for name in ("plan.json", "times.bin", "script.bin")]
        before = _children()
        text = measured(REPEAT, *files, runs, 1)
        if text:
            raise SystemExit(text)
        return (_children() - before) / runs

    @cached_property
    def bulk(self) -> np.ndarray:
        """CPU time of a loop from Python and without it [s], shape (rounds, 2)."""
        return np.array([(self.compiled(), self.alone()) for _ in range(self.rounds)])

    @cached_property
    def judged(self) -> str:
        """The plan that records what the row of a study needs: the signals that its KPIs read."""
        names, _ = self.rows(self.plan, self.script)
        read = kpi.reads(names, {"system": self.model.as_dict()})
        return json.dumps({**json.loads(self.plan), "record": [n for n in names if n in read]})

    def plain(self, plan: str | None = None) -> float:
        """Return the CPU time of the loop, or of another `plan`, by `fmpy_loop` [s].

        Raises
        ------
        SystemExit
            It does not give the numbers of the compiled master, all bits of them.
        """
        run, plan = self._planned, plan or self.plan
        times, script = run.times.tolist(), run.script.tolist()
        loop = fmpy_loop.Loop(json.loads(plan), times[-1], script)
        rows: list[Sequence[float]] = []
        try:
            spent = _cpu(lambda: rows.extend(loop.steps(times)))
        finally:
            loop.close()
        _, ours = self.rows(plan, run.script)
        if not np.array_equal(ours, rows):
            raise SystemExit("the plain loop and the compiled master differ")
        return spent

    @cached_property
    def in_ecos(self) -> np.ndarray:
        """CPU time of a loop with constant inputs by ecos and by us [s], shape (rounds, 2).

        Neither keeps a signal.
        """
        return np.array([(self._ecos(), self._held()) for _ in range(self.rounds)])

    @cached_property
    def _hold(self) -> np.ndarray:
        """The scenario's signals at `HELD`, when clutch 1 takes up torque."""
        run = self._planned
        return run.script[min(round(HELD / self.model.step), self.steps)]

    def _ecos(self) -> float:
        plan = json.loads(self._planned.plan)
        plan["hold"] = dict(zip(plan["script"], self._hold.tolist(), strict=True))
        path = WORK / "ecos_plan.json"
        path.write_text(json.dumps(plan), encoding="utf-8")
        text = measured(sys.executable, in_ecos.__file__, path, self.model.step, self.steps)
        told = json.loads(text.splitlines()[-1])
        ours = self._ended(in_ecos.SEEN)
        if not np.allclose(told["seen"], ours, rtol=SAME_LOOP):
            raise SystemExit(f"ecos ends at {told['seen']}, the compiled master at {ours}")
        return told["cpu"]

    def _ended(self, names: tuple[str, ...]) -> np.ndarray:
        plan = json.dumps({**json.loads(self._planned.plan), "record": names})
        return self.rows(plan, self._held_script)[1][-1]

    @cached_property
    def _held_script(self) -> np.ndarray:
        return np.tile(self._hold, (self.steps + 1, 1))

    def _held(self) -> float:
        plan = json.dumps({**json.loads(self.plan), "record": []})
        return self.cost(plan, self._held_script)

    @cached_property
    def sweeps(self) -> np.ndarray:
        """CPU time of a run of a sweep, by dask with the plain loop and by us [s], shape (2, 2).

        First with what a row of a study needs recorded, then with every signal. A run is whole:
        it opens the FMUs or takes opened ones, starts, steps and frees. Either has made runs
        before, which are not counted: the cluster has been started, and the machine has given the
        memory that rows take. The rows of one run per worker or thread are there at a time.
        """
        self.plain(self.judged)  # which tells whether both make the same rows
        return np.array([(self._on_dask(plan), self._swept(plan))
                         for plan in (self.judged, self.plan)])  # fmt: skip

    def _on_dask(self, plan: str) -> float:
        run = self._planned
        return dask_sweep.cpu(SWEPT, (json.loads(plan), run.times.tolist(), run.script.tolist()))

    def _swept(self, plan: str) -> float:
        _, *native = [self.native(MANY, 2, plan) for _ in range(4)]
        return float(np.median(native))

    @cached_property
    def rows_of_a_sweep(self) -> np.ndarray:
        """CPU time of a run of `dct-harness sweep`, and of its loop alone [s], shape (rounds, 2).

        A run is whole, from what is chosen for it to its row in the store; FMUs are open.
        """
        words = ("run", LOOP, "--fmu-dir", FMUS, "--engine", "native",
                 "--stop", repr(self.model.stop))  # fmt: skip
        folder = WORK / "sweep"
        prepared, store = Prepared(Setup(words, folder)), Store(folder, {}, resume=False)
        numbers = itertools.count(1)

        def runs() -> None:
            for number in itertools.islice(numbers, BULK):
                drawn = 0.01 + 1e-5 * number
                job = Job(number, {"x": drawn}, (), (f"plant.vehicle.rollingResistance={drawn}",))
                store.add(prepared.run_one(job))

        runs()  # opens the FMUs
        return np.array([(_cpu(runs) / BULK, self.native(BULK, 1, self.judged))
                         for _ in range(self.rounds)])  # fmt: skip

    def fmpy(self) -> float:
        """Return the CPU time of the loop on fmpy [s]."""
        run = _Timed(self.model, self.paths)
        run.execute()
        return run.spent

    @cached_property
    def engines(self) -> np.ndarray:
        """CPU time of a loop on fmpy, compiled, plain on fmpy, and compiled but not kept [s].

        Shape (rounds, 4).
        """
        bare = json.dumps({**json.loads(self.plan), "record": []})
        rounds = range(self.rounds)
        return np.array(
            [
                (self.fmpy(), self.compiled(), self.plain(), self.cost(bare, self.script))
                for _ in rounds
            ]
        )

    @cached_property
    def threads(self) -> np.ndarray:
        """CPU time of a run among many, on one and on two threads [s], shape (rounds, 2)."""
        return np.array([(self.native(MANY, 1), self.native(MANY, 2)) for _ in range(3)])

    def nothing(self, library: Path) -> float:
        """Return the CPU time of a step of two empty FMUs that feed each other [s]."""
        plan = json.dumps(_pair(_packed(library)))
        times = 1e-3 * np.arange(NOTHING + 1)
        script = np.zeros((len(times), 0))
        out = self._arrays(1, len(times), 2 * len(OUTPUTS))
        spent = [_cpu(lambda: self._whole(plan, times, script, out)) for _ in range(self.rounds)]
        return float(np.median(spent)) / NOTHING

    def _whole(
        self, plan: str, times: np.ndarray, script: np.ndarray, out: list[np.ndarray]
    ) -> None:
        ((_, rows, error, _),) = self.module.run([plan], times, script, 1, out=out)
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
