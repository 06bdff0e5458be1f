"""One FMU by hand, for tests: set inputs by name, step, read outputs by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ConfigError, did_you_mean
from ..fmu.fmu import Fmu
from ..supplier.mapped import Mapped
from ..supplier.mapping import Mapping

FOREVER = 1e9  # s; the FMU is told this stop time


class Stepper:
    """An FMU that starts at its first `step`; parameters are set before it, inputs any time.

    with Stepper(Path("target/fmu/DctPlant.fmu")) as plant:
        plant["engine.torque"] = 50.0
        plant.step(0.001)
        speed = plant["engine.speed"]

    `names`: the mapping of a supplier's plant, which then speaks by our names, in SI.
    """

    def __init__(self, path: Path, name: str = "fmu", names: Mapping | None = None) -> None:
        fmu = Fmu(name, path)
        self.fmu: Fmu | Mapped = fmu if names is None else Mapped(fmu, names)
        self.time = 0.0
        self._start: dict[str, Any] = {}
        self._inputs = {v.name: k for k, v in enumerate(self.fmu.inputs)}
        self._outputs = {v.name: k for k, v in enumerate(self.fmu.outputs)}
        self._given, self._read = np.zeros(len(self._inputs)), np.zeros(len(self._outputs))
        self._running = False
        for variable in self.fmu.inputs:
            start = variable.start or 0
            self._given[self._inputs[variable.name]] = _number(start)

    def __setitem__(self, name: str, value: float) -> None:
        """Set an input, or before the first step a parameter or start value, in the FMU's unit."""
        if name in self._inputs:
            self._given[self._inputs[name]] = value
        elif self._running:
            raise ConfigError(f"'{name}' is no input; parameters are set before the first step")
        else:
            self._start[name] = value

    def __getitem__(self, name: str) -> float:
        """Return an output; before the first step the initial one."""
        self._run()
        if name not in self._outputs:
            hint = did_you_mean(name, self._outputs)
            raise ConfigError(f"{self.fmu.path}: has no output '{name}'.{hint}")
        return float(self._read[self._outputs[name]])

    def step(self, h: float, count: int = 1) -> None:
        """Take `count` steps of `h` [s] with the inputs as they are."""
        self._run()
        for _ in range(count):
            self.fmu.step(self.time, h)
            self.time += h

    def _run(self) -> None:
        if self._running:
            return
        self.fmu.initialize(FOREVER, self._start)
        self.fmu.bind(self._given, self._read)
        self.fmu.set_inputs()
        self.fmu.exit_initialization()
        self.fmu.get_outputs()
        self._running = True

    def close(self) -> None:
        """Free the FMU."""
        self.fmu.close()

    def __enter__(self) -> Stepper:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _number(start: Any) -> float:
    """Return a start value of a model description as a number."""
    return float({"true": 1, "false": 0}.get(str(start), start))
