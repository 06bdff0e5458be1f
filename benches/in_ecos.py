"""Run a plan in ecos; print CPU time and time of its steps [s] and two outputs as JSON.

`python in_ecos.py PLAN STEP STEPS`: PLAN is JSON of `cosim_master::Plan`, with `hold`, the values
that the scenario keeps. A program of its own, since ecos ends its process when an FMU crashes.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

from ecospy import EcosLib, EcosSimulation, EcosSimulationStructure
from fmpy import read_model_description

SEEN = ("plant.engine.speed", "plant.vehicle.speed")
KINDS = {"Real": "real", "Integer": "int", "Boolean": "bool"}


def structure(plan: dict[str, Any]) -> EcosSimulationStructure:
    """Return the coupled FMUs with their values; ecos has no connections of enumerations."""
    parts, values = EcosSimulationStructure(), {}
    for component in plan["components"]:
        name = component["name"]
        parts.add_model(name, component["fmu"])
        variables = read_model_description(component["fmu"]).modelVariables
        types = {v.name: v.type for v in variables}
        values |= {f"{name}::{n}": value for n, value in component["start"]}
        for given in component["inputs"]:
            giver, _, output = given["source"].partition(".")
            kind, target = types[given["name"]], f"{name}::{given['name']}"
            if giver == "scenario":
                value = plan["hold"][output]
                values[target] = value if kind == "Real" else int(value)
            else:
                connect = getattr(parts, f"make_{KINDS[kind]}_connection")
                connect(f"{giver}::{output}", target)
    parts.add_parameter_set("plan", values)
    return parts


def main(plan: Path, step: float, steps: int) -> None:
    """Initialise, then time all steps in one call."""
    EcosLib.set_log_level("warn")
    with structure(json.loads(plan.read_text("utf-8"))) as parts:
        simulation = EcosSimulation(step_size=step, structure=parts)
    with simulation:
        simulation.init(parameter_set="plan")
        begun = time.process_time(), time.perf_counter()
        simulation.step(steps)
        ended = time.process_time(), time.perf_counter()
        seen = [simulation.get_real(name.replace(".", "::", 1)) for name in SEEN]
        simulation.terminate()
    cpu, wall = (end - begin for begin, end in zip(begun, ended, strict=True))
    print(json.dumps({"cpu": cpu, "wall": wall, "seen": seen}))


if __name__ == "__main__":
    main(Path(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3]))
