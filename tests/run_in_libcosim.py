"""Run the FMUs in libcosim and print all outputs after the last step as JSON.

`python run_in_libcosim.py alone STEP` gives each FMU its own inputs, `... loop STEP`
couples the three. It is a program of its own, since libcosim ends its process when an FMU does not
load.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from importer_cases import CONNECTIONS, LATER, LOOP_STARTS, MODELS, STARTS, fmu
from libcosimpy.CosimConstants import success as SUCCESS
from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

TYPES = {
    CosimVariableType.REAL.value: "real", CosimVariableType.INTEGER.value: "integer",
    CosimVariableType.BOOLEAN.value: "boolean",
}  # fmt: skip


class Simulation:
    """The three FMUs in one execution; variables are found by model and name."""

    def __init__(self, step: float) -> None:
        self.execution = CosimExecution.from_step_size(step * 1e9)
        self.slaves = [CosimLocalSlave(fmu_path=str(fmu(m)), instance_name=m) for m in MODELS]
        self.index = {m: self.execution.add_local_slave(s)
                      for m, s in zip(MODELS, self.slaves, strict=True)}  # fmt: skip
        self.variables = {(m, v.name.decode()): v for m in MODELS
                          for v in self.execution.slave_variables(self.index[m])}  # fmt: skip
        self.observer = CosimObserver.create_last_value()
        self.override = CosimManipulator.create_override()
        done(self.execution.add_observer(self.observer))
        done(self.execution.add_manipulator(self.override))

    def _locate(self, model: str, name: str) -> tuple[str, int, int]:
        variable = self.variables[model, name]
        return TYPES[variable.type], self.index[model], variable.reference

    def start_with(self, model: str, name: str, value: Any) -> None:
        """Set an initial value."""
        kind, slave, reference = self._locate(model, name)
        done(getattr(self.execution, f"{kind}_initial_value")(slave, reference, value))

    def set(self, model: str, name: str, value: Any) -> None:
        """Override an input from the next step on."""
        kind, slave, reference = self._locate(model, name)
        done(getattr(self.override, f"slave_{kind}_values")(slave, [reference], [value]))

    def get(self, model: str, name: str) -> Any:
        """Return a value as of the last step."""
        kind, slave, reference = self._locate(model, name)
        return getattr(self.observer, f"last_{kind}_values")(slave, [reference])[0]

    def connect(self, source: str, target: str, name: str) -> None:
        """Connect an output to the input of equal name."""
        _, first, output = self._locate(source, name)
        _, second, entry = self._locate(target, name)
        done(self.execution.connect_real_variables(first, output, second, entry) == SUCCESS)

    def outputs(self, model: str) -> dict[str, Any]:
        """Return all outputs of a model by name."""
        wanted = CosimVariableCausality.OUTPUT.value
        found = [n for (m, n), v in self.variables.items() if m == model and v.causality == wanted]
        return {name: self.get(model, name) for name in found}


def done(success: bool) -> None:
    """Stop at a call that libcosim refuses."""
    if not success:
        raise RuntimeError("libcosim refused a call")


def main(what: str, step: float) -> None:
    """Run `alone` or `loop` for 1 s in steps [s]; in the middle, inputs change."""
    log_output_level(CosimLogLevel.WARNING)
    loop, steps = what == "loop", round(1.0 / step)
    simulation = Simulation(step)
    for model, values in (LOOP_STARTS if loop else STARTS).items():
        for name, value in values.items():
            simulation.start_with(model, name, value)
    for connection in CONNECTIONS if loop else ():
        simulation.connect(*connection)
    done(simulation.execution.step(steps // 2))
    for model, values in ({} if loop else LATER).items():
        for name, value in values.items():
            simulation.set(model, name, value)
    done(simulation.execution.step(steps - steps // 2))
    print(json.dumps({model: simulation.outputs(model) for model in MODELS}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
