"""The two plants of `examples/supplier_plant`: the observer on each, and their mappings."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import FMUS, ROOT, SYSTEMS, rms
from dct_harness import cli, results
from dct_harness.fmu.fmu import Fmu
from dct_harness.supplier import mapping
from dct_harness.supplier.mapped import Mapped

EXAMPLE = ROOT / "examples/supplier_plant"
PLANTS = {"antrieb": "Antrieb.fmu", "powertrain": "Powertrain.fmu"}
CASES = ("paper_case1", "paper_case2")
RADIUS = {"antrieb": 0.310, "powertrain": 0.295}  # m
ENGINE_INERTIA = {"antrieb": 0.70, "powertrain": 0.78}  # kg.m2
FRICTION = {"antrieb": (0.26, 0.22), "powertrain": (0.27, 0.21)}
LEVER = {"antrieb": 0.098, "powertrain": 0.096}  # m
ROUNDING = 1e-12  # relative
HALF = 0.6  # of a unit of the last printed digit: rounding, and another C compiler's libm


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with both plants."""
    folder = tmp_path_factory.mktemp("supplier")
    command = [sys.executable, EXAMPLE / "build.py", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def loops(built: Path) -> dict[tuple[str, str], results.Results]:
    """Closed loops by plant and case; each meets the limits of its system file."""
    found = {}
    for name in PLANTS:
        for case in CASES:
            out = built / f"{name}_{case}"
            command = ["run", str(SYSTEMS / f"{case}.toml"), "--plant", str(built / PLANTS[name])]
            command += ["--map", str(EXAMPLE / f"{name}.toml"), "--fmu-dir", str(FMUS)]
            assert cli.main([*command, "--out", str(out), "--quiet"]) == 0, (name, case)
            found[name, case] = results.load(out)
    return found


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("case", CASES)
def test_observer_beats_the_map_on_both_plants(
    loops: dict[tuple[str, str], results.Results], name: str, case: str
) -> None:
    loop = loops[name, case]
    for torque in ("clutch1.torque", "clutch2.torque", "driveShaft.torque"):
        truth = loop[f"plant.{torque}"]
        errors = [rms(loop[f"observer.{p}{torque}"] - truth) for p in ("", "mapBased.")]
        assert errors[0] < errors[1] / 10, torque  # by 16 at the least, measured


@pytest.mark.parametrize("name", PLANTS)
@pytest.mark.parametrize("case", CASES)
def test_readme_tells_the_errors_that_these_runs_have(
    loops: dict[tuple[str, str], results.Results], name: str, case: str
) -> None:
    text = (EXAMPLE / "README.md").read_text(encoding="utf-8")
    table = text.partition("| friction assumed |")[2]
    plants = table.partition("\n")[0].strip("| ").split(" | ")
    row = re.search(rf"^\| case {case[-1]} \| (.*) \|$", table, re.MULTILINE)
    cell = row[1].split(" | ")[plants.index(PLANTS[name])]
    loop, torques = loops[name, case], ("clutch1.torque", "clutch2.torque", "driveShaft.torque")
    found = [100 * rms(loop[f"observer.{p}{t}"] - loop[f"plant.{t}"]) / rms(loop[f"plant.{t}"])
             for p in ("", "mapBased.") for t in torques]  # fmt: skip
    told = re.findall(r"[\d.]+", cell)
    units = [10.0 ** -len(number.partition(".")[2]) for number in told]
    for number, value, unit in zip(told, found, units, strict=True):
        assert abs(float(number) - value) <= HALF * unit, (number, value)


@pytest.mark.parametrize("name", PLANTS)
def test_signals_arrive_in_si_under_our_names(
    loops: dict[tuple[str, str], results.Results], name: str
) -> None:
    loop = loops[name, "paper_case1"]
    assert loop["plant.engine.speed"][0] == pytest.approx(90, rel=ROUNDING)  # of the system file
    wheel, vehicle = loop["plant.wheel.speed"], loop["plant.vehicle.speed"]
    assert np.allclose(wheel * RADIUS[name], vehicle, rtol=ROUNDING, atol=ROUNDING)
    assert 5 < vehicle.max() < 15  # m/s, over the paper's launch and shift
    assert set(loop["plant.clutch1.state"]) == {1, 2, 3}
    assert 290 < loop["plant.clutch1.temperature"][0] < 340  # K
    rising = loop["plant.clutch1.torque"] > 20  # N.m; the drive shaft drives with clutch 1
    assert np.mean(loop["plant.driveShaft.torque"][rising] > 0) > 0.95


@pytest.mark.parametrize("name", PLANTS)
def test_observer_is_told_the_plants_parameters(
    loops: dict[tuple[str, str], results.Results], name: str
) -> None:
    told = loops[name, "paper_case1"].run["parameters"]["observer"]
    assert told["engine.inertia"]["value"] == ENGINE_INERTIA[name]
    assert told["wheel.radius"]["value"] == pytest.approx(RADIUS[name], rel=ROUNDING)
    assert told["clutch1.nominalFriction"]["value"] == 0.4  # of the system file


@pytest.mark.parametrize("name", PLANTS)
def test_clutch_curves_of_the_mapping_are_those_of_the_plant(built: Path, name: str) -> None:
    """A clutch that slips at an engine speed of 90 rad/s carries mu F r of the data sheet."""
    known = mapping.load(EXAMPLE / f"{name}.toml").known
    for clutch in (1, 2):
        for k in range(1, 11):
            position = known[f"clutch{clutch}.map.position[{k}]"]
            torque = _slipping(built / PLANTS[name], name, clutch, position)
            force = known[f"clutch{clutch}.map.force[{k}]"]
            expected = FRICTION[name][clutch - 1] * force * LEVER[name]
            assert math.isclose(torque, expected, rel_tol=1e-3, abs_tol=1e-9), (clutch, position)


def _slipping(path: Path, name: str, clutch: int, position: float) -> float:
    """Return the torque of a clutch that has slipped for 1 ms."""
    plant = Mapped(Fmu("plant", path), mapping.load(EXAMPLE / f"{name}.toml"))
    try:
        plant.initialize(1.0, {"engine.speed_start": 90.0})
        inputs, outputs = np.zeros(len(plant.inputs)), np.zeros(len(plant.outputs))
        plant.bind(inputs, outputs)
        start = {f"clutch{clutch}.position": position, "shaft1.gear": 1, "shaft2.gear": 2}
        for k, variable in enumerate(plant.inputs):
            inputs[k] = start.get(variable.name, 0)
        plant.exit_initialization()
        plant.step(0.0, 0.001)
        return float(outputs[[v.name for v in plant.outputs].index(f"clutch{clutch}.torque")])
    finally:
        plant.close()
