"""Presets as parameter files: read into the FMUs, refused where they do not fit, driven."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import FMUS, SYSTEMS, rms, run
from dct_harness import cli
from dct_harness.errors import ConfigError
from dct_harness.fmu.fmu import Fmu
from dct_harness.system import parameters

SETS = SYSTEMS / "parameters"
HEAD = f'<s:ParameterSet xmlns:s="{parameters.VALUES[1:-1]}"><s:Parameters>'
TAIL = "</s:Parameters></s:ParameterSet>"
MODELS = {"plant": "DctPlant", "observer": "DctObserver", "control": "DctClutchControl"}


@pytest.mark.parametrize("path", sorted(SETS.glob("*.ssv")), ids=lambda path: path.stem)
def test_an_fmu_takes_every_value_of_a_parameter_file(path: Path) -> None:
    component = path.stem.split("_")[-1]
    values = parameters.read(path)
    fmu = Fmu(component, FMUS / f"{MODELS[component]}.fmu")
    try:
        fmu.initialize(1.0, values)
        found = fmu.parameters(fmu.read_parameters())
    finally:
        fmu.close()
    assert {name: found[name]["value"] for name in values} == values
    assert len(values) > 40


def test_a_run_that_fails_says_what_the_observer_believes_of_another_vehicle(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A ratio that only the plant was given; a run that passes says nothing of the kind."""
    asked = ["run", str(SYSTEMS / "paper_case1.toml"), "--engine", "native", "--out", str(tmp_path)]
    changed = ["--set", "plant.shaft1.gearRatio[1]=3.5", "--set", "plant.engine.inertia=0.6"]
    told = "observer believes engine.inertia = 0.745 (plant 0.6) kg.m2, shaft1.gearRatio[1] = 3.0 "
    assert cli.main([*asked, *changed]) == 1
    assert f"verdict: fail\n\n{told}(plant 3.5)\n" in capsys.readouterr().out
    same = [word.replace("plant.", "observer.") for word in changed]
    assert cli.main([*asked, *changed, *same]) == 0
    assert "believes" not in capsys.readouterr().out


@pytest.mark.parametrize("name", sorted(p.stem for p in SETS.glob("*_observer.ssv")))
def test_the_plant_has_every_parameter_of_an_observers_file(name: str) -> None:
    """So that one file says a vehicle to both; a control believes what its observer does."""
    believed = parameters.read(SETS / f"{name}.ssv")
    true = parameters.read(SETS / f"{name.replace('observer', 'plant')}.ssv")
    assert {key: true.get(key) for key in believed} == believed
    control = SETS / f"{name.replace('observer', 'control')}.ssv"
    if control.exists():
        its = parameters.read(control)
        assert {key: believed.get(key) for key in its} == its


def test_the_paper_preset_is_where_the_plant_starts() -> None:
    fmu = Fmu("plant", FMUS / "DctPlant.fmu")
    try:
        fmu.initialize(1.0, {})
        found = fmu.parameters(fmu.read_parameters())
    finally:
        fmu.close()
    values = parameters.read(SETS / "paper_plant.ssv")
    assert {name: found[name]["value"] for name in values} == values
    left = set(found) - set(values)
    assert all(name.endswith("_start") for name in left)
    assert {"engine.speed_start", "vehicle.speed_start", "clutch1.temperature_start"} <= left


def test_pressure_starts_the_wet_box_on_a_hill_without_roll_back(tmp_path: Path) -> None:
    signals = run("launch_wet6", (), tmp_path).signals
    time, speed = signals["time"], signals["plant.vehicle.speed"]
    held = signals["plant.wheel.held"] > 0
    assert held[time < 0.5].all()
    assert not held[-1]
    assert (speed[held] == 0).all()
    assert speed.min() > -0.01
    assert speed[-1] > 3
    clutch = signals["plant.clutch1.torque"][np.searchsorted(time, 2.2)]
    expected = 0.3 * 0.52 * (12e5 * 0.001 - 500)  # mu r_c N (p A - spring)
    assert clutch == pytest.approx(expected, rel=1e-3)
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["parameters"]["plant"]["engine.inertia"]["value"] == 0.2


@pytest.mark.parametrize("system", ["methods_wet6", "methods_wet6_fade"])
def test_pressures_are_followed_by_every_method(system: str, tmp_path: Path) -> None:
    """The system file limits energy, kalman and calibrating; the map misses by all it believes."""
    loop = run(system, (), tmp_path)
    truth = loop["plant.clutch1.torque"]
    assert truth.max() > 80
    assert loop["scenario.shaft1.gear"][-1] == 3
    for method in ("observer", "lyapunov", "energy", "kalman", "calibrating"):
        share = rms(loop[f"{method}.clutch1.torque"] - truth) / rms(truth)
        assert share < 0.25, method
        assert (loop[f"{method}.status.valid"] == 1).all(), method
    assert rms(loop["observer.mapBased.clutch1.torque"] - truth) > rms(truth)


@pytest.mark.parametrize(("text", "said"), [
    ("<broken", "is not valid XML"),
    ("<other/>", "its root is <other>"),
    (f'{HEAD}<s:Parameter name="a"/>{TAIL}', "'a' needs exactly one value"),
    (f'{HEAD}<s:Parameter name="a"><s:Real value="x"/></s:Parameter>{TAIL}', "'x' is no Real"),
    (f'{HEAD}<s:Parameter name="a"><s:Real value="1" unit="furlong"/></s:Parameter>{TAIL}',
     "the unit 'furlong' is not known"),
])  # fmt: skip
def test_a_parameter_file_that_makes_no_sense_is_refused(
    tmp_path: Path, text: str, said: str
) -> None:
    path = tmp_path / "x.ssv"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        parameters.read(path)
    assert str(path) in str(caught.value)
    assert said in str(caught.value)


def test_values_come_in_si_and_the_last_one_counts(tmp_path: Path) -> None:
    value = '<s:Parameter name="a"><s:Real value="2" unit="bar"/></s:Parameter>'
    (tmp_path / "x.ssv").write_text(HEAD + value + TAIL)
    system = tmp_path / "system.toml"
    assert parameters.gather(system, "x.ssv") == {"a": 2e5}
    assert parameters.gather(system, ["x.ssv", {"a": 1.0}]) == {"a": 1.0}
    assert parameters.gather(system, [{"a": 1.0, "b": 3}, "x.ssv"]) == {"a": 2e5, "b": 3}
