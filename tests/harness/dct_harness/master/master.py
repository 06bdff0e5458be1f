"""Master: Gauss-Seidel (plant, observer, control) or Jacobi, on an integer step counter."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..errors import ConfigError, FmuRuntimeError, HarnessError, instant
from ..fmu.fmu import Fmu
from ..fmu.isolated import Limits, load
from ..fmu.kept import Kept
from ..fmu.values import Read
from ..supplier.mapped import Mapped, apply_shared
from ..supplier.mapping import Mapping
from ..system import scenario as scenarios
from ..system.system import System
from ..system.transforms import Transform
from . import doubts
from .beside import Measured
from .coupling import algebraic_loops, delayed, ranges
from .initial import Initialization, Member
from .interpolation import Interpolation
from .noise import Noise
from .signals import describe
from .wiring import Wiring, Wirings

Wanted = Callable[[tuple[str, ...]], Collection[str]]  # of the names of all signals those to record
SCENARIO, BUILD = "scenario", "build"  # categories of what is said of them


class Run:
    """One run; after `execute`, also a failed one, `rows` holds the samples so far."""

    def __init__(
        self, system: System, paths: dict[str, Path], mapping: Mapping | None = None,
        limits: Limits | None = None,
    ) -> None:  # fmt: skip
        self.system, self.paths, self.mapping = system, paths, mapping
        self.limits = limits or Limits()
        self.names: list[str] = []
        self.kept: list[str] = []  # names of the columns of `rows`
        self.wanted: Wanted | None = None  # which signals to record; an engine may record all
        self.kept_open: Kept | None = None  # FMUs of earlier runs
        self.rows = np.zeros((0, 0))
        self.fmus: dict[str, Fmu | Mapped] = {}
        self.identities: dict[str, dict[str, str]] = {}
        self.discrete: set[str] = set()
        self._parameters: dict[str, Read] = {}
        self.sources: dict[str, str] = {}
        self.transforms: dict[str, Transform] = {}
        self.times = np.zeros(0)
        self.wirings = Wirings()  # of runs that differ in values only
        self._wiring: Wiring | None = None
        self.measured = Measured(scenarios.load(None), (), self.times)
        self.package: Any = None  # opened .ssp whose FMUs lie in its temporary folder
        self.abort: HarnessError | None = None  # set by a signal or another thread
        self.at_work = True  # an FMU may be within a call
        self.outdated = ""  # what is to be said of FMUs that are older than their sources
        self.ends: dict[str, FmuRuntimeError] = {}  # by FMUs that ask to end it

    def execute(self, progress: Callable[[int, int], None] | None = None) -> None:
        """Run from t = 0 to stop; frees every FMU whatever happens."""
        with ExitStack() as stack:
            for name, path in self.paths.items():
                self.fmus[name] = self._load(name, path)
                stack.callback(self.fmus[name].close)
            self._map()
            self.identities = {name: fmu.identity() for name, fmu in self.fmus.items()}
            self._initialize(self._wire().levels)
            self._loop(progress)

    def _load(self, name: str, path: Path) -> Fmu:
        try:
            fmu = load(name, path, self.limits, self.kept_open)
            fmu.ends = self.ends
            return fmu
        except ConfigError as error:
            if path.name != Path(self.system.components[name].fmu).name:
                raise  # of the command line, not of the file
            where = self.system.at("components", name, "fmu")
            raise ConfigError(f"{where}: {error} (--fmu-dir says where FMUs are)") from error

    def _start(self, name: str, fmu: Fmu | Mapped) -> None:
        """Set a component's values and enter initialisation mode; errors name the line."""
        try:
            fmu.initialize(self.system.stop, self.system.components[name].parameters)
        except ConfigError as error:
            place = self.system.at_parameter(name, error.variable)
            if place is None:
                raise
            raise ConfigError(f"{place}: {error}") from error

    def _map(self) -> None:
        """Let the plant speak by our names, and share what others need to know of it."""
        if self.mapping is None:
            return
        plant = Mapped(cast(Fmu, self.fmus["plant"]), self.mapping)
        self.fmus["plant"] = plant
        given = {n: c.parameters for n, c in self.system.components.items()}
        apply_shared(self.mapping, plant, self.fmus, given)

    def _wire(self) -> Wiring:
        """Lay out scenario signals, noise and outputs in one vector, and where inputs read it."""
        wired = self.wirings.of(self.system, self.fmus)
        self.times, self.sources, self.transforms = wired.times, wired.sources, wired.transforms
        self.measured = Measured(wired.scenario, self.fmus, self.times)
        outputs = wired.outputs
        self.noise = Noise(self.system, self.sources, {n: wired.types[n] for n in outputs})
        self._wiring = wired
        self.script = wired.script
        if self.noise.names:
            self.script = np.hstack([self.script, self.noise.samples(len(self.times))])
        self.names = [*(f"scenario.{s}" for s in wired.used), *self.noise.columns, *outputs]
        self.kept = self.names
        self._jacobi = self.system.coupling == "jacobi"
        self.discrete = {n for n in self.names if wired.types.get(n) == "Integer"}
        self.world, self._zeros = np.zeros((2, len(self.names)))
        self._scripted = self.world[: self.script.shape[1]]
        self._make_room()
        return wired

    @property
    def spacing(self) -> float | None:
        """Step between most communication points [s]; None of a run that was not wired."""
        return None if self._wiring is None else self._wiring.spacing

    def _make_room(self) -> None:
        """Find memory for all samples."""
        self._samples = np.zeros((len(self.times), len(self.names)))

    def _initialize(self, levels: list[list[list[str]]]) -> None:
        """Start all FMUs and pass initial values on, each after those that it depends on."""
        index = {name: k for k, name in enumerate(self.names)}
        members: dict[str, Member] = {}
        first = self.script.shape[1]
        for name, fmu in self.fmus.items():
            fmu.inputs = [v for v in fmu.inputs if f"{name}.{v.name}" in self.sources]
            self._start(name, fmu)
            names = [v.name for v in fmu.inputs]
            where = np.array([index[self.sources[f"{name}.{n}"]] for n in names], dtype=np.intp)
            values = np.zeros(len(where))
            fmu.bind(values, self.world[first : first + len(fmu.outputs)])
            first += len(fmu.outputs)
            convert = self.noise.conversion(name, names, self.transforms, self.sources,
                                            self.world, index)  # fmt: skip
            members[name] = Member(fmu, where, values, convert)
        self._members = list(members.values())
        self._interpolation = None
        self._scripted[:] = self.script[0]
        Initialization(members, levels, self.world).settle()
        if self.system.interpolate:
            count = self.script.shape[1]
            self._interpolation = Interpolation(members, self.world, count)
        for name, fmu in self.fmus.items():
            fmu.exit_initialization()
            fmu.get_outputs()
            self._parameters[name] = fmu.read_parameters()
        self._record(0)

    def _loop(self, progress: Callable[[int, int], None] | None) -> None:
        """Step all components; scenario inputs are those at the start of the step."""
        times = self.times.tolist()
        last = len(times) - 1
        self._steps = [
            (m.fmu, m.where, m.values, m.convert if m.convert.needed else None,
             self.system.components[name].substeps)
            for name, m in zip(self.fmus, self._members, strict=True)
        ]  # fmt: skip
        for k in range(last):
            if self.abort is not None:
                raise self._stopped(self.abort, times[k])
            if self.ends:
                raise next(iter(self.ends.values()))
            t = times[k]
            h = times[k + 1] - t
            if self._interpolation is not None:
                self._step_along(self._interpolation, k, t, h)
            elif self._jacobi:
                self._step_at_once(t, h)
            else:
                for fmu, where, values, convert, parts in self._steps:
                    self.world.take(where, out=values, mode="clip")
                    if convert is not None:
                        convert(values)
                    fmu.step(t, h) if parts == 1 else _in_parts(fmu, t, h, parts)
            self._record(k + 1)
            if progress is not None and ((k + 1) % 100 == 0 or k + 1 == last):
                progress(k + 1, last)

    def _step_along(self, slopes: Interpolation, k: int, t: float, h: float) -> None:
        """Step all components with inputs that go on within the step, where they can follow."""
        slopes.begin(self.script[k], self.script[k + 1], h)
        if self._jacobi:
            for member in self._members:
                slopes.feed(member)
        for member, (fmu, *_, parts) in zip(self._members, self._steps, strict=True):
            if not self._jacobi:
                slopes.feed(member)
            fmu.step(t, h) if parts == 1 else _in_parts(fmu, t, h, parts)
            if not self._jacobi:
                slopes.after(member)

    def _step_at_once(self, t: float, h: float) -> None:
        """Step all components with the inputs of the beginning of the step."""
        for _, where, values, convert, _ in self._steps:
            self.world.take(where, out=values, mode="clip")
            if convert is not None:
                convert(values)
        for fmu, _, _, _, parts in self._steps:
            fmu.step(t, h) if parts == 1 else _in_parts(fmu, t, h, parts)

    @staticmethod
    def _stopped(cause: HarnessError, t: float) -> HarnessError:
        return type(cause)(f"stopped at t = {instant(t)} s: {cause}")

    def remove_directories(self) -> None:
        """Remove the unpacked FMUs, for a process that ends without `execute` returning."""
        for fmu in self.fmus.values():
            fmu.remove_directory()
        if self.package is not None:
            self.package.folder.cleanup()

    def _record(self, k: int) -> None:
        """Bring the scenario to communication point `k` and keep all signals."""
        self._scripted[:] = self.script[k]
        row = self._samples[k]
        row[:] = self.world
        if not math.isfinite(self._zeros.dot(row)):  # 0 · NaN and 0 · inf are NaN
            bad = int(np.argmin(np.isfinite(row)))
            name, value = self.names[bad], float(row[bad])
            raise FmuRuntimeError(f"{name} is {value} at t = {instant(self.times[k])} s")
        self.rows = self._samples[: k + 1]

    def table(self) -> tuple[list[str], np.ndarray]:
        """Return column names and rows, `time` first; what was measured of the plant last."""
        count, beside = len(self.rows), self.measured
        columns = [self.times[:count], self.rows, beside.table[:count]]
        return ["time", *self.kept, *beside.names], np.column_stack(columns)

    def events(self) -> list[dict[str, Any]]:
        """Return each change of an integer or enumeration output."""
        found = []
        for name in sorted(self.discrete.intersection(self.kept)) if len(self.rows) else ():
            column = self.rows[:, self.kept.index(name)]
            component, _, variable = name.partition(".")
            for k in np.flatnonzero(np.diff(column)) + 1:
                found.append({
                    "time": float(self.times[k]), "component": component, "variable": variable,
                    "from": int(column[k - 1]), "to": int(column[k]),
                })  # fmt: skip
        return sorted(found, key=lambda e: e["time"])

    def summary(self, error: HarnessError | None) -> dict[str, Any]:
        """Return the content of `run.json`, without the environment."""
        log = [m for f in self.fmus.values() for m in f.log] + self._out_of_range()
        log += [{"component": "scenario", "time": t, "status": "Warning", "category": SCENARIO,
                 "message": text} for t, text in self._doubts()]  # fmt: skip
        if self.outdated:
            log.append({"component": "fmus", "time": 0.0, "status": "Warning", "category": BUILD,
                        "message": self.outdated})  # fmt: skip
        parameters = {name: self.fmus[name].parameters(r) for name, r in self._parameters.items()}
        return {
            "system": self.system.as_dict(), "step": self.system.step, "stop": self.system.stop,
            "samples": len(self.rows),
            "reached": float(self.times[len(self.rows) - 1]) if len(self.rows) else None,
            "status": "partial" if error else "complete", "error": str(error) if error else None,
            "fmus": self.identities, "parameters": parameters, "events": self.events(),
            "signals": self._signals(),
            "coupling": {
                "order": self.system.coupling, "loops": algebraic_loops(self.fmus, self.sources),
                "delayed": delayed(list(self.fmus), self.sources, self.system.coupling),
            },
            "wiring": self._connections(),
            "log": sorted(log, key=lambda m: m["time"]),
            "wall_time": {n: f.wall_time for n, f in self.fmus.items() if f.wall_time},
        }  # fmt: skip

    def _signals(self) -> dict[str, dict[str, Any]]:
        """Return unit and type of the recorded signals; none of a run that was not wired."""
        if self._wiring is None:
            return {}
        read = {**self.sources, **dict(zip(self.noise.names, self.noise.columns, strict=True))}
        return describe(self.kept, self.fmus, read, self.transforms) | self.measured.told

    def _doubts(self) -> list[tuple[float, str]]:
        """Return since when [s] something is odd about the scenario, and what."""
        if self._wiring is None:
            return []
        script, stop = self._wiring.scenario, self.system.stop
        odd = doubts.of(script, self._wiring.used, stop)
        return [*script.beyond(stop), *odd, *self.measured.doubts]

    def _connections(self) -> list[dict[str, Any]]:
        """Return source and target of each input, and what changes a value on its way."""
        return [{"from": s, "to": t, **self.transforms.get(t, Transform()).as_dict()}
                for t, s in self.sources.items()]  # fmt: skip

    def _out_of_range(self) -> list[dict[str, Any]]:
        """Return a warning for each output that has left its declared min and max."""
        found = []
        known = ((n, r) for n, r in ranges(self.fmus).items() if n in self.kept)
        for name, (low, high) in known if len(self.rows) else ():
            column = self.rows[:, self.kept.index(name)]
            bad = np.flatnonzero((column < low) | (column > high))
            if bad.size:
                component, _, variable = name.partition(".")
                t, value = float(self.times[bad[0]]), float(column[bad[0]])
                text = (f"{variable} = {value!r} is out of its range [{low:g}, {high:g}], "
                        f"{bad.size} times from t = {instant(t)} s on")  # fmt: skip
                found.append({"component": component, "time": t, "status": "Warning",
                              "category": "range", "message": text})  # fmt: skip
        return found


def _in_parts(fmu: Fmu | Mapped, t: float, h: float, parts: int) -> None:
    """Step one component in equal parts with the same inputs, or along their slopes."""
    for k in range(parts):
        if fmu.name in fmu.ends:
            raise fmu.ends[fmu.name]
        fmu.step(t + k * h / parts, h / parts)
        fmu.advance_inputs(h / parts)
