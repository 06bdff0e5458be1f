"""Run the FMUs in ecos and print all outputs after the last step as JSON.

`python run_in_ecos.py alone STEP` gives each FMU its own inputs, `... loop STEP`
couples the three. It is a program of its own, since ecos ends its process when an FMU crashes.
"""

from __future__ import annotations

import json
import sys

from ecospy import EcosLib, EcosSimulation, EcosSimulationStructure
from fmpy import read_model_description
from importer_cases import CONNECTIONS, LATER, LOOP_STARTS, MODELS, STARTS, fmu


def structure(starts: dict[str, dict], loop: bool) -> EcosSimulationStructure:
    """Return the three FMUs with their start values, coupled or not."""
    parts = EcosSimulationStructure()
    for model in MODELS:
        parts.add_model(model, fmu(model))
    if loop:
        for source, target, name in CONNECTIONS:
            parts.make_real_connection(f"{source}::{name}", f"{target}::{name}")
    values = {f"{m}::{n}": value for m in MODELS for n, value in starts[m].items()}
    parts.add_parameter_set("starts", values)
    return parts


def change(simulation: EcosSimulation) -> None:
    """Set the inputs that change in mid-run."""
    setters = {bool: simulation.set_bool, int: simulation.set_integer, float: simulation.set_real}
    for model in MODELS:
        for name, value in LATER[model].items():
            setters[type(value)](f"{model}::{name}", value)


def outputs(simulation: EcosSimulation, model: str) -> dict[str, float]:
    """Return the outputs of a model by name; ecos offers no enumerations."""
    getters = {
        "Real": simulation.get_real, "Boolean": simulation.get_bool,
        "Integer": simulation.get_integer,
    }  # fmt: skip
    variables = read_model_description(str(fmu(model))).modelVariables
    found = [v for v in variables if v.causality == "output" and v.type in getters]
    return {v.name: getters[v.type](f"{model}::{v.name}") for v in found}


def main(what: str, step: float) -> None:
    """Run `alone` or `loop` for 1 s in steps [s]; in the middle, inputs change."""
    EcosLib.set_log_level("warn")
    loop, steps = what == "loop", round(1.0 / step)
    with structure(LOOP_STARTS if loop else STARTS, loop) as parts:
        simulation = EcosSimulation(step_size=step, structure=parts)
    with simulation:
        simulation.init(parameter_set="starts")
        simulation.step(steps // 2)
        if not loop:
            change(simulation)
        simulation.step(steps - steps // 2)
        print(json.dumps({model: outputs(simulation, model) for model in MODELS}))
        simulation.terminate()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
