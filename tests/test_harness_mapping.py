"""Mapping files: codings, derived outputs, who sets what, and what is refused with its remedy."""

from __future__ import annotations

from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, run, variable, write_fmu, write_system

CODED = (
    *LAG,
    variable("n", 0, "input", "0", "Integer"),
    variable("m", 1, "output", kind="Integer"),
)
SCENARIO = "time,engine.torque,shaft1.gear\n0,200,1\n0.5,200,3\n10,200,3\n"
GOOD = """
[inputs]
"engine.torque" = { variable = "u", unit = "kN.m" }
"shaft1.gear" = { variable = "n", table = { 0 = 14, 1 = 5, 3 = 7 } }
[outputs]
"vehicle.speed" = { variable = "x", unit = "km/h", factor = -1, offset = 2 }
"wheel.speed" = { derive = "vehicle.speed", radius = 0.25 }
"clutch1.state" = { variable = "m", table = { slipping = [10, 28], engaged = 14, disengaged = 0 } }
[parameters]
"engine.inertia" = { variable = "tau", unit = "kg.m2" }
"""


@pytest.fixture(scope="module")
def supplier(tmp_path_factory: pytest.TempPathFactory, lag_library: Path) -> Path:
    """The lag u -> x and m = 2 n, under names and units that are not ours."""
    return write_fmu(tmp_path_factory.mktemp("supplier") / "S.fmu", lag_library, CODED)


def mapped(
    folder: Path, supplier: Path, text: str, *options: str, parameters: str = ""
) -> CompletedProcess[str]:
    """Run the lag as a mapped plant; returns the finished process."""
    system = write_system(folder, scenario=SCENARIO)
    system.write_text(system.read_text() + f"parameters = {{ {parameters} }}\n")
    (folder / "m.toml").write_text(text)
    return run(system, folder, "--plant", supplier, "--map", folder / "m.toml", *options)


def test_units_signs_codings_and_derived_outputs(tmp_path: Path, supplier: Path) -> None:
    done = mapped(tmp_path, supplier, GOOD, parameters='"engine.inertia" = 0.5')
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    raw = 0.2 * (1 - np.exp(-found.time / 0.5))  # kN.m in; what the FMU gives is km/h
    assert np.allclose(found["plant.vehicle.speed"], 2 - raw / 3.6, rtol=0, atol=1e-12)
    assert np.allclose(found["plant.wheel.speed"], found["plant.vehicle.speed"] / 0.25, rtol=1e-14)
    states = found["plant.clutch1.state"]
    assert [states[0], states[1], states[-1]] == [1, 2, 3]
    assert found.run["parameters"]["plant"]["engine.inertia"] == {"value": 0.5, "unit": "kg.m2"}
    assert found.run["fmus"]["plant"]["mapping"].endswith("m.toml")


def test_command_line_beats_mapping_beats_system(tmp_path: Path, supplier: Path) -> None:
    text = GOOD + "[values.plant]\ntau = 0.3\n"
    for options, tau in (((), 0.3), (("--set", "plant.tau=0.4"), 0.4)):
        assert mapped(tmp_path, supplier, text, *options, parameters="tau = 0.2").returncode == 0
        record = results.load(tmp_path / "out").run
        assert record["parameters"]["plant"]["tau"]["value"] == tau


def test_what_the_plant_has_not_can_be_ignored(tmp_path: Path, supplier: Path) -> None:
    done = mapped(tmp_path, supplier, GOOD, parameters='"vehicle.mass" = 1500.0')
    assert done.returncode == 2
    assert "nothing stands for 'vehicle.mass' = 1500.0 of the system; map it, or" in done.stderr
    text = 'ignore = ["vehicle.mass"]\n' + GOOD
    assert mapped(tmp_path, supplier, text, parameters='"vehicle.mass" = 1500.0').returncode == 0


def test_a_code_without_a_row_ends_the_run_with_its_time(tmp_path: Path, supplier: Path) -> None:
    done = mapped(tmp_path, supplier, GOOD.replace("[10, 28]", "10"))
    assert done.returncode == 0
    done = mapped(tmp_path, supplier, GOOD.replace("engaged = 14", "engaged = 99"))
    assert done.returncode == 4
    assert "plant: m = 14 is in no row of the table for 'clutch1.state' at t = 0.5 s" in done.stderr
    assert results.load(tmp_path / "out").run["reached"] == 0.5


@pytest.mark.parametrize(("old", "new", "said"), [
    ('"engine.torque"', '"engine.tork"', "no 'engine.tork'. Did you mean 'engine.torque'?"),
    ('"vehicle.speed" = {', '"my.own" = {', "Give it under [extra]"),
    ('"tau"', '"tua"', "'engine.inertia' = 'tua': Lag has no such variable. Did you mean 'tau"),
    ('variable = "u"', 'variable = "x"', "is of causality output, not input"),
    ('"kN.m"', '"mm"', "'mm' (m) cannot become 'N.m' (kg m2 s-2)"),
    ('"kN.m"', '"knm"', "unknown unit 'knm'"),
    (', unit = "kN.m"', "", "the FMU states no unit; say unit = … (ours is N.m)"),
    (", table = { slipping = [10, 28], engaged = 14, disengaged = 0 }", "", "say with a table"),
    ("slipping =", "sliping =", "'clutch1.state' has no item 'sliping' (disengaged, slipping"),
    ("[10, 28]", "[10, 14]", "gives one value of theirs two meanings"),
    ('derive = "vehicle.speed"', 'derive = "x"', "outputs.wheel.speed: can be derived:"),
    ("factor = -1", "factr = -1", "m.toml:6:52: outputs.vehicle.speed"),
    ("[inputs]", "[input]", "m.toml:2:1: (top level)"),
    ("[parameters]", 'share = ["observr"]\n[parameters]', "outputs.share"),
    ("\n[inputs]", 'share = ["observr"]\n[inputs]', "no component 'observr'. Did you mean"),
])  # fmt: skip
def test_a_wrong_mapping_is_refused_with_the_remedy(
    tmp_path: Path, supplier: Path, old: str, new: str, said: str
) -> None:
    assert old in GOOD
    done = mapped(tmp_path, supplier, GOOD.replace(old, new, 1))
    assert done.returncode == 2, done.stderr
    assert said in done.stderr


def test_a_scenario_steers_a_tunable_parameter_of_the_supplier(
    tmp_path: Path, lag_library: Path
) -> None:
    fixed = variable("nanAt", 4, "parameter", "1e9")
    tunable = tuple(fixed.replace("fixed", "tunable") if v == fixed else v for v in CODED)
    supplier = write_fmu(tmp_path / "T.fmu", lag_library, tunable)
    old = '"engine.inertia" = { variable = "tau", unit = "kg.m2" }'
    new = '"clutch1.kineticFriction" = { variable = "nanAt", factor = 0.5 }'
    head = "time,engine.torque,shaft1.gear,clutch1.kineticFriction\n"
    system = write_system(tmp_path, scenario=f"{head}0,200,1,0.25\n9,200,1,0.25\n")
    text = GOOD.replace(old, new)
    (tmp_path / "m.toml").write_text(text)
    done = run(system, tmp_path, "--plant", supplier, "--map", tmp_path / "m.toml")
    assert done.returncode == 4
    assert "plant.vehicle.speed is nan at t = 0.501 s" in done.stderr  # nanAt is 0.25 / 0.5 s


@pytest.mark.parametrize(("entry", "said"), [
    ('"n"', "1.5 would be 1.5 there, which is Integer; give a value that is a whole number there"),
    ('{ variable = "n", table = { 1 = 5, 3 = 7 } }', "1.5 is in no row of its table"),
])  # fmt: skip
@pytest.mark.parametrize("engine", ["fmpy", "native"])
def test_a_start_value_that_the_supplier_cannot_hold_is_refused_not_cut(
    tmp_path: Path, supplier: Path, engine: str, entry: str, said: str
) -> None:
    coded = '{ variable = "n", table = { 0 = 14, 1 = 5, 3 = 7 } }'
    text = GOOD.replace(coded, entry)
    options = ("--set", "plant.shaft1.gear=1.5", "--engine", engine)
    done = mapped(tmp_path, supplier, text, *options)
    assert done.returncode == 2, done.stderr
    assert f"m.toml: 'shaft1.gear' = 'n': {said}" in done.stderr


def test_an_input_given_twice_is_refused(tmp_path: Path, supplier: Path) -> None:
    text = GOOD.replace("[outputs]", '"brake.torque" = { variable = "u", unit = "N.m" }\n[outputs]')
    done = mapped(tmp_path, supplier, text)
    assert done.returncode == 2
    assert "'u' of the FMU is given twice" in done.stderr


def test_a_mapping_needs_a_plant(tmp_path: Path, supplier: Path) -> None:
    system = write_system(tmp_path)
    system.write_text(system.read_text().replace("components.plant", "components.engine"))
    (tmp_path / "m.toml").write_text(GOOD)
    done = run(system, tmp_path, "--map", tmp_path / "m.toml")
    assert done.returncode == 2
    assert "--map: " in done.stderr
