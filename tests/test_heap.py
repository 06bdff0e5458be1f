"""Steps of a plant with every option of its clutches and gears on ask nothing of the heap."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from closed_loop_runs import FMUS
from fmu_instance import Instance
from test_abi import HEADERS, ROOT

CURVE = {
    f"clutch1.frictionCurve.{name}[{k}]": value
    for name, points in (("slip", (0, 5, 20, 60, 150)), ("factor", (1.1, 1.0, 0.97, 1.0, 0.8)))
    for k, value in enumerate(points, start=1)
}
HEAT = {"clutch1.thermal.capacity": 60.0, "clutch1.thermal.conductance": 5.0} | {
    f"clutch1.thermal.{name}[{k}]": value
    for name, points in (("temperature", (300, 400, 500, 600)), ("factor", (1, 0.9, 0.7, 0.5)))
    for k, value in enumerate(points, start=1)
}
LOSSES = {"shaft1.gearEfficiency[1]": 0.97, "shaft2.gearEfficiency[1]": 0.97}
OPTIONS = {"none": {}, "curves and heat": CURVE | HEAT, "losses": LOSSES}


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the program that counts."""
    program, driver = tmp_path_factory.mktemp("heap") / "steps", ROOT / "benches" / "driver"
    command = ["cc", "-std=gnu11", "-O1", "-w", f"-I{HEADERS}", f"-I{driver}", "-o", program]
    sources = [ROOT / "tests" / "heap_steps.c", driver / "heap.c"]
    subprocess.run([*command, *sources, "-ldl"], check=True)
    return program


@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_steps_ask_nothing_of_the_heap(host: Path, options: dict[str, float]) -> None:
    with Instance(FMUS / "DctPlant.fmu") as plant:
        known = {name: str(v.valueReference) for name, v in plant.variables.items()}
        ports = (known[n] for n in ("engine.torque", "clutch1.position", "clutch1.temperature"))
        values = {"engine.speed_start": 120.0} | options
        pairs = [word for name, value in values.items() for word in (known[name], str(value))]
        library = f"{plant._folder}/binaries/linux64/DctPlant.so"
        command = [host, library, plant.description.guid, *ports, *pairs]
        said = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    assert said[0] == "0"
    assert (float(said[1]) > 300.0) == (options != {} and "clutch1.thermal.capacity" in options)
