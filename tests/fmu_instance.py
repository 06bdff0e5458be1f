"""One FMU instance in fmpy, driven by variable names; every refusal raises fmpy's exception."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, NamedTuple

from fmpy import calloc, extract, fmi2, free, read_model_description

Value = float | int | bool


class Message(NamedTuple):
    """One call of the importer's logger."""

    status: int
    category: str
    message: str


class Instance:
    """An instantiated slave; leave it as a context manager to free it."""

    def __init__(self, fmu: Path) -> None:
        self.log: list[Message] = []
        self._folder = extract(str(fmu))
        self.description = read_model_description(self._folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.slave = fmi2.FMU2Slave(
            guid=self.description.guid, unzipDirectory=self._folder, instanceName="one",
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate(callbacks=self._callbacks(), loggingOn=True)

    def __enter__(self) -> Instance:
        return self

    def __exit__(self, *_: object) -> None:
        self.slave.freeInstance()
        shutil.rmtree(self._folder)

    def _callbacks(self) -> Any:
        def logger(_env: Any, _name: Any, status: int, category: bytes, text: bytes) -> None:
            self.log.append(Message(status, category.decode(), text.decode()))

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(logger)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        return callbacks

    def _family(self, name: str) -> tuple[str, list[int]]:
        variable = self.variables[name]
        family = "Integer" if variable.type == "Enumeration" else variable.type
        return family, [variable.valueReference]

    def set(self, name: str, value: Value) -> None:
        """Set a variable [its unit]."""
        family, reference = self._family(name)
        getattr(self.slave, f"set{family}")(reference, [value])

    def get(self, name: str) -> Value:
        """Return a variable [its unit]."""
        family, reference = self._family(name)
        return getattr(self.slave, f"get{family}")(reference)[0]

    def names(self, causality: str) -> list[str]:
        """Return the names of all variables of a causality."""
        return [v.name for v in self.variables.values() if v.causality == causality]

    def outputs(self) -> dict[str, Value]:
        """Return all outputs by name."""
        return {name: self.get(name) for name in self.names("output")}

    def values(self) -> dict[str, Value]:
        """Return every variable by name."""
        return {name: self.get(name) for name in self.variables}

    def start(self, start: float = 0.0, stop: float | None = None) -> None:
        """Initialise at `start` [s] with what was set so far."""
        self.slave.setupExperiment(startTime=start, stopTime=stop)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def step(self, time: float, step: float) -> None:
        """Advance from `time` by `step` [s]."""
        self.slave.doStep(time, step)

    def saved(self) -> bytes:
        """Return the state, serialised."""
        state = self.slave.getFMUstate()
        try:
            return self.slave.serializeFMUstate(state)
        finally:
            self.slave.freeFMUstate(state)

    def restore(self, data: bytes) -> None:
        """Go back to a serialised state."""
        state = self.slave.deSerializeFMUstate(data)
        try:
            self.slave.setFMUstate(state)
        finally:
            self.slave.freeFMUstate(state)
