"""The names that others build on: importers' scripts, system files, CI jobs, spreadsheets.

Nothing here changes without a line in CHANGELOG.md. More variables, options and
keys may be added; what is listed keeps its name, its unit and its meaning.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from fmpy import read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ScalarVariable
from importer_cases import MODELS, ROOT, fmu, started

# Model, causality, type or unit, variability, names. <c> is clutch1 and clutch2, <s> shaft1 and
# shaft2: the odd and the even gears.
VARIABLES = """
DctPlant    input     N.m       continuous  engine.torque brake.torque
DctPlant    input     m         continuous  <c>.position
DctPlant    input     Pa        continuous  <c>.pressure
DctPlant    input     rad       continuous  road.grade
DctPlant    input     Integer   discrete    <s>.gear
DctPlant    output    rad/s     continuous  engine.speed damper.speed <c>.speed output.speed
DctPlant    output    rad/s     continuous  wheel.speed <c>.slip
DctPlant    output    m/s       continuous  vehicle.speed
DctPlant    output    m/s2      continuous  vehicle.acceleration
DctPlant    output    N.m       continuous  damper.torque <c>.torque <s>.torque driveShaft.torque
DctPlant    output    N.m       continuous  load.torque
DctPlant    output    ClutchState discrete  <c>.state
DctPlant    output    W         continuous  <c>.frictionPower
DctPlant    output    J         continuous  <c>.frictionEnergy energy.residual
DctPlant    parameter kg.m2     fixed       engine.inertia damper.inertia <c>.inertia
DctPlant    parameter kg.m2     fixed       output.inertia vehicle.wheelInertia
DctPlant    parameter N.m/rad   fixed       damper.stiffness <s>.stiffness driveShaft.stiffness
DctPlant    parameter N.m.s/rad fixed       damper.damping <s>.damping driveShaft.damping
DctPlant    parameter 1         fixed       <s>.finalDriveRatio <s>.gearRatio[1] <s>.gearRatio[2]
DctPlant    parameter 1         fixed       <s>.gearRatio[3] <s>.gearRatio[4]
DctPlant    parameter 1         fixed       vehicle.dragCoefficient vehicle.rollingResistance
DctPlant    parameter kg        fixed       vehicle.mass
DctPlant    parameter m         fixed       wheel.radius <c>.effectiveRadius <c>.map.position[1]
DctPlant    parameter m2        fixed       vehicle.frontalArea
DctPlant    parameter kg/m3     fixed       air.density
DctPlant    parameter N         fixed       <c>.map.force[1]
DctPlant    parameter Boolean   fixed       transmission.rigid
DctPlant    parameter rad/s     fixed       engine.speed_start
DctPlant    parameter m/s       fixed       vehicle.speed_start
DctPlant    parameter 1         tunable     <c>.kineticFriction <c>.staticFriction
DctObserver input     N.m       continuous  engine.torque brake.torque
DctObserver input     rad/s     continuous  engine.speed <c>.speed wheel.speed
DctObserver input     m         continuous  <c>.position
DctObserver input     Pa        continuous  <c>.pressure
DctObserver input     rad       continuous  road.grade
DctObserver input     Integer   discrete    <s>.gear
DctObserver output    N.m       continuous  <c>.torque driveShaft.torque load.torque
DctObserver output    N.m       continuous  mapBased.clutch1.torque mapBased.clutch2.torque
DctObserver output    N.m       continuous  mapBased.driveShaft.torque calibration.torqueBias
DctObserver output    N/m       continuous  <c>.muF <c>.epsilon
DctObserver output    1         continuous  <c>.friction calibration.torqueScale
DctObserver output    1         continuous  calibration.inertiaError
DctObserver output    rad/s     continuous  innovation.x1 innovation.x2
DctObserver output    rad/s     continuous  calibration.wheelSpeedBias
DctObserver output    1         continuous  calibration.torqueScaleDeviation
DctObserver output    1         continuous  calibration.inertiaErrorDeviation
DctObserver output    N.m       continuous  calibration.torqueBiasDeviation
DctObserver output    rad/s     continuous  calibration.wheelSpeedBiasDeviation
DctObserver output    Boolean   discrete    <c>.engaged status.valid
DctObserver parameter 1/s       tunable     gain.L11 gain.L22
DctObserver parameter -         tunable     gain.Lc1 gain.Lc2 gain.p3
DctObserver parameter 1         tunable     <c>.nominalFriction
DctObserver parameter Boolean   tunable     adaptation.enabled
DctObserver parameter LoadMethod tunable    load.method
DctObserver parameter ObserverMethod fixed  observer.method
DctClutchControl input  N.m     continuous  <c>.torqueRequest
DctClutchControl input  N/m     continuous  <c>.muF
DctClutchControl input  1       continuous  <c>.friction
DctClutchControl input  Boolean discrete    feedback.enabled
DctClutchControl output m       continuous  <c>.position
"""
ENUMERATIONS = {
    "ClutchState": ["disengaged", "slipping", "engaged"],
    "LoadMethod": ["grade", "engine", "momentum"],
    "ObserverMethod": ["paper", "lyapunov", "energy", "kalman", "calibrating"],
}
DISPLAYED = {"rad/s": "rpm", "m": "mm", "rad": "deg", "m/s": "km/h", "Pa": "bar", "W": "kW"}
# Parameters of the plant that no observer needs: it sees shafts as rigid and learns the friction.
PLANT_ONLY = ("shaft1.stiffness", "shaft2.stiffness", "shaft1.damping", "shaft2.damping",
              "transmission.rigid", "engine.speed_start", "vehicle.speed_start",
              "clutch1.kineticFriction", "clutch2.kineticFriction", "clutch1.staticFriction",
              "clutch2.staticFriction")  # fmt: skip
# What one FMU gives another within a closed loop: known from states alone.
COUPLING = {
    "DctPlant": ("engine.speed", "clutch1.speed", "clutch2.speed", "wheel.speed"),
    "DctObserver": ("clutch1.muF", "clutch2.muF", "clutch1.friction", "clutch2.friction",
                    "clutch1.torque", "clutch2.torque", "driveShaft.torque"),
    "DctClutchControl": ("clutch1.position", "clutch2.position"),
}  # fmt: skip
# Columns of a closed loop's results.
KEPT = ("plant.clutch1.torque", "observer.clutch1.torque", "observer.mapBased.clutch1.torque",
        "control.clutch1.position", "scenario.clutch1.torqueRequest")  # fmt: skip
VERBS = ("run", "check", "map", "compare", "report", "sweep", "identify", "convert", "export-ssp",
         "doctor")  # fmt: skip


def _both(name: str) -> list[str]:
    """Return the names for both sides, or the name of what there is one of."""
    sides = [name.replace("<c>", f"clutch{i}").replace("<s>", f"shaft{i}") for i in (1, 2)]
    return sorted(set(sides))


def _listed() -> list[tuple[str, str, str, str, str]]:
    rows = [line.split(maxsplit=4) for line in VARIABLES.strip().splitlines()]
    return [(*row, full) for *row, names in rows for name in names.split() for full in _both(name)]


@cache
def _described(model: str) -> dict[str, ScalarVariable]:
    return {v.name: v for v in read_model_description(str(fmu(model))).modelVariables}


def _unit(variable: ScalarVariable) -> str:
    """Return the unit of a Real, the type's name of an enumeration, else the type."""
    if variable.type == "Enumeration":
        return variable.declaredType.name
    return variable.unit or variable.type


@pytest.mark.parametrize("model", MODELS)
def test_every_listed_variable_is_what_it_was(model: str) -> None:
    listed = [row for row in _listed() if row[0] == model]
    assert len(listed) == len(set(listed)) > 5
    for _, causality, unit, variability, name in listed:
        found = _described(model)[name]
        assert (found.causality, found.variability) == (causality, variability), name
        assert unit in ("-", _unit(found)), name


@pytest.mark.parametrize("model", MODELS)
def test_enumerations_keep_their_numbers_and_units_what_people_read(model: str) -> None:
    for variable in _described(model).values():
        if variable.type == "Enumeration":
            items = {item.name: int(item.value) for item in variable.declaredType.items}
            wanted = ENUMERATIONS.get(variable.declaredType.name, list(items))
            assert items == {name: k for k, name in enumerate(wanted, start=1)}, variable.name
        elif variable.unit in DISPLAYED:
            assert variable.displayUnit == DISPLAYED[variable.unit], variable.name


def test_the_observer_has_the_plants_parameters_under_their_names() -> None:
    listed = {row[4] for row in _listed() if row[:2] == ("DctPlant", "parameter")}
    ours = _described("DctObserver")
    for name in listed.difference(PLANT_ONLY):
        assert _unit(ours[name]) == _unit(_described("DctPlant")[name]), name


@pytest.mark.parametrize("model", MODELS)
def test_what_couples_fmus_depends_on_states_alone(model: str) -> None:
    outputs = read_model_description(str(fmu(model))).outputs
    depends = {unknown.variable.name: unknown.dependencies for unknown in outputs}
    assert [name for name in COUPLING[model] if depends[name] != []] == []


def _begun(more: dict[str, float]) -> dict[str, float]:
    """Return all variables of a plant that was started rolling."""
    values = {"engine.speed_start": 90.0, "vehicle.speed_start": 5.0, **more}
    with started("DctPlant", values) as plant:
        return plant.values()


@pytest.mark.parametrize("rigid", [False, True])
def test_a_run_starts_untwisted_with_engine_and_vehicle_at_their_speeds(rigid: bool) -> None:
    v = _begun({"transmission.rigid": rigid})
    assert v["engine.speed"] == v["damper.speed"] == 90.0
    assert v["wheel.speed"] == v["output.speed"] == v["vehicle.speed"] / v["wheel.radius"]
    assert v["vehicle.speed"] == pytest.approx(5.0, rel=1e-15)
    assert v["damper.torque"] == v["driveShaft.torque"] == 0.0
    assert (v["clutch1.state"], v["clutch2.state"]) == (1, 1)
    for side in (1, 2):
        ratio = v[f"shaft{side}.finalDriveRatio"] * v[f"shaft{side}.gearRatio[1]"]
        assert v[f"clutch{side}.speed"] == pytest.approx(ratio * v["output.speed"], rel=1e-15)


def test_clutches_start_as_the_first_inputs_press_them() -> None:
    slips = _begun({"clutch1.position": 0.006})
    assert (slips["clutch1.state"], slips["clutch2.state"]) == (2, 1)
    held = _begun({"clutch1.position": 0.006, "engine.speed_start": slips["clutch1.speed"]})
    assert (held["clutch1.state"], held["clutch1.slip"]) == (3, 0.0)


def test_a_brake_has_no_negative_torque() -> None:
    with started("DctPlant", {}) as plant:
        with pytest.raises(FMICallException, match="discard"):
            plant.set("brake.torque", -1.0)
        assert plant.get("brake.torque") == 0.0


def _harness(*words: str | Path) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "dct_harness", *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_is_there(verb: str) -> None:
    assert _harness(verb, "--help").returncode == 0


def test_results_are_time_then_component_and_variable_with_every_digit(tmp_path: Path) -> None:
    system = "examples/closed_loop/torque_tracking_case1.toml"
    done = _harness("run", system, "--stop", "1.2", "--out", tmp_path, "--quiet")
    assert done.returncode in (0, 1), done.stderr
    with (tmp_path / "results.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "time"
    components = {name.partition(".")[0] for name in rows[0][1:]}
    assert components == {"plant", "observer", "control", "scenario"}
    assert set(KEPT) <= set(rows[0])
    # 1,200 steps of 1 ms, each number the shortest that reads back to the same bits.
    assert [row[0] for row in rows[1:]] == [repr(k * 0.001) for k in range(1201)]
    assert max(len(cell) for row in rows[1:] for cell in row[1:]) > 16
    assert json.loads((tmp_path / "kpis.json").read_text(encoding="utf-8"))["rows"]
