"""A closed loop as one writes it with fmpy: `FMU2Slave`, lists of references, lists of values.

References and sources are looked up once, each step sets all inputs of an FMU in one call per
type, steps it and gets its outputs in one call per type: all of them, or those that are read or
recorded where the plan names the signals to record. Functions of this file travel to dask.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from operator import itemgetter
from typing import Any

TYPES = ("Real", "Integer", "Boolean")  # in this order lie signals in a row


class Part:
    """One FMU, what it reads, and where its outputs lie in a row."""

    def __init__(self, component: dict[str, Any], first: int, wanted: set[str] | None) -> None:
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        self.folder = extract(component["fmu"])
        description = read_model_description(component["fmu"])
        self.variables = {v.name: v for v in description.modelVariables}
        self.slave = FMU2Slave(
            instanceName=component["name"], guid=description.guid, unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate()
        for name, value in component["start"]:
            self._set(name, value)
        outputs = [v for v in description.modelVariables if v.causality == "output"
                   and (wanted is None or f"{component['name']}.{v.name}" in wanted)]  # fmt: skip
        self.names = [f"{component['name']}.{v.name}" for t in TYPES
                      for v in outputs if _type(v) == t]  # fmt: skip
        self.getters = []
        for kind in TYPES:
            references = [v.valueReference for v in outputs if _type(v) == kind]
            if references:
                places = slice(first, first + len(references))
                self.getters.append((getattr(self.slave, f"get{kind}"), references, places))
            first += len(references)

    def _set(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        getattr(self.slave, f"set{_type(variable)}")([variable.valueReference], [value])

    def connect(self, inputs: list[dict[str, Any]], places: dict[str, int]) -> None:
        """Note where each input is read; the loop of the bench has no factors and no tables."""
        self.setters = []
        for kind in TYPES:
            chosen = [i for i in inputs if _type(self.variables[i["name"]]) == kind]
            references = [self.variables[i["name"]].valueReference for i in chosen]
            sources = [places[i["source"]] for i in chosen]
            if chosen:
                call = getattr(self.slave, f"set{kind}")
                self.setters.append((call, references, sources, kind != "Real"))

    def set(self, world: list[float]) -> None:
        """Set all inputs."""
        for call, references, sources, whole in self.setters:
            values = [world[k] for k in sources]
            call(references, [int(value) for value in values] if whole else values)

    def get(self, world: list[float]) -> None:
        """Read all outputs."""
        for call, references, places in self.getters:
            world[places] = call(references)

    def close(self) -> None:
        """Free it."""
        self.slave.terminate()
        self.slave.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def _type(variable: Any) -> str:
    return "Integer" if variable.type == "Enumeration" else variable.type


class Loop:
    """The FMUs of a plan (`cosim_master::Plan`), initialised."""

    def __init__(self, plan: dict[str, Any], stop: float, script: list[list[float]]) -> None:
        self.script = script
        names = [f"scenario.{name}" for name in plan["script"]]
        self.parts = []
        record = plan.get("record")  # two signals at least, or None: all
        read = {i["source"] for c in plan["components"] for i in c["inputs"]}
        wanted = None if record is None else read | set(record)
        for component in plan["components"]:
            self.parts.append(Part(component, len(names), wanted))
            names += self.parts[-1].names
        places = {name: k for k, name in enumerate(names)}
        self.row = list if record is None else itemgetter(*(places[name] for name in record))
        self.world = [0.0] * len(names)
        self._play(0)
        for part, component in zip(self.parts, plan["components"], strict=True):
            part.connect(component["inputs"], places)
            part.slave.setupExperiment(stopTime=stop)
            part.slave.enterInitializationMode()
            part.get(self.world)
        for _ in self.parts:
            for part in self.parts:
                part.set(self.world)
                part.get(self.world)
        for part in self.parts:
            part.slave.exitInitializationMode()
            part.get(self.world)

    def _play(self, k: int) -> None:
        row = self.script[k]
        self.world[: len(row)] = row

    def steps(self, times: list[float]) -> list[Sequence[float]]:
        """Step all FMUs along the communication points [s]; returns a row for each."""
        rows = [self.row(self.world)]
        for k in range(len(times) - 1):
            for part in self.parts:
                part.set(self.world)
                part.slave.doStep(times[k], times[k + 1] - times[k])
                part.get(self.world)
            self._play(k + 1)
            rows.append(self.row(self.world))
        return rows

    def close(self) -> None:
        """Free all FMUs."""
        for part in self.parts:
            part.close()


def whole(plan: dict[str, Any], times: list[float], script: list[list[float]]) -> int:
    """Make one run, as a task of a sweep does; returns how many rows it has."""
    loop = Loop(plan, times[-1], script)
    try:
        return len(loop.steps(times))
    finally:
        loop.close()
