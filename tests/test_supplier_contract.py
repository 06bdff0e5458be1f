"""`dct-harness map` and `check --against plant` on the plants of `examples/supplier_plant`."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from closed_loop_runs import FMUS, ROOT
from dct_harness import cli
from dct_harness.contract import plant as contract
from dct_harness.fmu.archive import described
from dct_harness.supplier import against, mapping, skeleton

EXAMPLE = ROOT / "examples/supplier_plant"
FILES = {"antrieb": "Antrieb.fmu", "powertrain": "Powertrain.fmu"}
PARAMETERS_FOUND = {"antrieb": 12, "powertrain": 8}  # at least


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with both plants."""
    folder = tmp_path_factory.mktemp("supplier")
    command = [sys.executable, EXAMPLE / "build.py", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder


def _check(fmu: Path, *options: str | Path) -> int:
    return cli.main(["check", str(fmu), "--against", "plant", *map(str, options)])


@pytest.mark.parametrize("name", FILES)
def test_skeleton_finds_what_a_person_found(built: Path, name: str) -> None:
    description, byhand = described(built / FILES[name]), mapping.load(EXAMPLE / f"{name}.toml")
    for section, causality in (("inputs", "input"), ("outputs", "output")):
        wanted = {n: e.variable for n, e in getattr(byhand, section).items() if e.variable}
        found = skeleton.pairs(contract(), description, causality)
        assert {n: v.name for n, (v, _) in found.items()} == wanted  # all, and nothing wrong
    found = skeleton.pairs(contract(), description, "parameter")
    same = [
        n for n, e in byhand.parameters.items() if n in found and found[n][0].name == e.variable
    ]
    assert len(same) >= PARAMETERS_FOUND[name]
    assert {n for n in found if n in byhand.parameters} == set(same)  # nothing wrong


@pytest.mark.parametrize("name", FILES)
def test_skeleton_is_a_mapping_once_its_question_marks_are_answered(
    built: Path, tmp_path: Path, name: str
) -> None:
    out = tmp_path / "m.toml"
    assert cli.main(["map", str(built / FILES[name]), "--out", str(out)]) == 0
    text = out.read_text()
    loaded = mapping.load(out)
    findings = against.findings(described(built / FILES[name]), loaded, same_names=False)
    faults = {f.name: f.verdict for f in findings if f.fault}
    asked = {n for n, e in loaded.outputs.items() if "?" in e.table.values()}
    asked |= {n for n, e in loaded.inputs.items() if "?" in e.table.values()}
    assert asked >= {"clutch1.state", "clutch2.state"}
    assert all("has no item '?'" in faults[n] for n in asked)
    missing = {n for n, v in faults.items() if v.startswith("missing")}
    assert set(faults) == asked | missing
    assert missing == ({"wheel.speed"} if name == "antrieb" else set())
    assert re.search(r"^# NEEDED by the observer", text, re.MULTILINE) or not missing


def test_check_and_skeleton_name_what_the_observer_keeps_of_table_1(
    built: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A ratio that nobody maps is the paper's: the observer would be wrong, and no signal tells."""
    out, plant = tmp_path / "m.toml", built / "Antrieb.fmu"
    assert cli.main(["map", str(plant), "--out", str(out)]) == 0
    text = out.read_text()
    assert '\n# "shaft1.gearRatio[1]" = 3 # [1] i_t of gear 1\n' in text
    assert '\n# "wheel.speed" = { derive = "vehicle.speed", radius = "?" }\n' in text
    assert _check(plant, "--map", out) == 1
    said = capsys.readouterr().out
    assert "[parameters] and [known] do not say vehicle.mass, " in said
    assert "shaft1.gearRatio, " in said
    assert 'the observer needs it; { derive = "vehicle.speed", radius = … }, if the FMU' in said
    given = mapping.load(EXAMPLE / "antrieb.toml")
    left = ["vehicle.rollingResistanceSpeed", "damper.stiffness", "damper.damping"]
    assert against.untold(given) == left
    assert _check(plant, "--map", EXAMPLE / "antrieb.toml") == 0
    assert f"do not say {', '.join(left)}: the observer keeps" in capsys.readouterr().out
    out.write_text((EXAMPLE / "antrieb.toml").read_text().replace("share", "# share", 1))
    assert _check(plant, "--map", out) == 0
    said = capsys.readouterr().out
    assert 'without share = ["observer"] the observer keeps the vehicle of Table 1: give it' in said


def test_skeleton_keeps_an_existing_file(built: Path, tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text("mine")
    assert cli.main(["map", str(built / "Antrieb.fmu"), "--out", str(tmp_path / "m.toml")]) == 2
    assert (tmp_path / "m.toml").read_text() == "mine"


@pytest.mark.parametrize("name", FILES)
def test_both_plants_keep_the_contract(
    built: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _check(built / FILES[name], "--map", EXAMPLE / f"{name}.toml") == 0
    said = capsys.readouterr().out
    assert "closed clutch1 transmits" in said
    assert said.endswith("verdict: a plant that the observer can use\n")


def test_our_plant_keeps_it_without_a_mapping_and_the_observer_does_not(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert _check(FMUS / "DctPlant.fmu") == 0
    capsys.readouterr()
    assert _check(FMUS / "DctObserver.fmu") == 1
    assert re.search(
        r"engine\.speed +engine\.speed +is of causality input", capsys.readouterr().out
    )


@pytest.mark.parametrize(("old", "new", "said"), [
    ('"engine.speed" = "mot.n" # 1/min\n', "", r"engine\.speed +- +missing: the observer needs it"),
    ('"engine.torque" = "mot.MInd"\n', "", r"engine\.torque +- +missing: nothing drives"),
    ('"clutch2.position" =', '#"clutch2.position" =', r"clutch2\.position +- +missing: nothing"),
    ('= "welle1.n"', '= "rad.r"', r"is of causality parameter, not output"),
    ('= "welle1.n"', '= "fzg.v"', r"'km/h' \(m s-1\) cannot become 'rad/s' \(s-1 rad\)"),
    ('= "welle1.n"', '= "kuppl1.zustand"', r"is Enumeration, ours is Real; say with a table"),
    ('"gelenkwelle.M", factor = -1', '"gelenkwelle.M"', r"drives the shaft.*wrong sign"),
    ('"kuppl1.nDiff", factor = -1', '"kuppl1.nDiff"', r"slip of clutch1.*wrong sign"),
    ('"kuppl1.sAusrueck", factor = -1, offset = 0.010', '"kuppl1.sAusrueck"',
     r"closed clutch1 transmits +clutch1\.torque +no effect to speak of: check unit, factor, "
     r"offset, and those of the inputs \(0 N.m\)"),
    ('"mot.n" # 1/min', '{ variable = "mot.n", unit = "rad/s" }',
     r"engine speed is that of clutch1 and its slip +engine\.speed +1\.44e\+03 rad/s, not 151: "
     r"check their units, clutch1\.slip"),
    ('"fzg.v" # km/h', '{ variable = "fzg.v", unit = "m/s" }',
     r"clutch1 turns as fast as gear and wheel say +clutch1\.speed +151 rad/s, not 544: check its"),
    ('"shaft1.gearRatio[1]" = "getriebe.i1"', '"shaft1.gearRatio[1]" = "getriebe.i3"',
     r"say +clutch1\.speed +151 rad/s, not 79: check its unit, wheel\.speed, ratios of shaft1"),
    ('"wheel.radius" = "rad.r"', '"wheel.radius" = { variable = "rad.r", factor = 2 }',
     r"vehicle is as fast as its wheels +vehicle\.speed +2\.61 m/s, not 5\.21: check its unit"),
    ('"road.grade" = "strasse.neigung"',
     '"road.grade" = { variable = "strasse.neigung", factor = -1 }',
     r"positive road\.grade slows the vehicle +wheel\.speed +wrong sign"),
])  # fmt: skip
def test_a_broken_contract_is_told_and_exits_1(
    built: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    text = (EXAMPLE / "antrieb.toml").read_text()
    assert old in text
    (tmp_path / "m.toml").write_text(text.replace(old, new))
    assert _check(built / "Antrieb.fmu", "--map", tmp_path / "m.toml") == 1
    told = capsys.readouterr().out
    assert re.search(said, told), told
