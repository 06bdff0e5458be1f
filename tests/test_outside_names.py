"""Constants and aliases in a model of one's own: described, checked, and run as importers do it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
from outside import cargo, listing, write_package

STONE = """
use fmi2_cosim::{Alias, Enumeration, Experiment, Failure, Item, Log, Model, StateFields};
use fmi2_cosim::{Unit, Variable};

const ROCK: Enumeration = Enumeration {
    name: "Rock",
    description: "Kinds of rock",
    items: &[
        Item { name: "granite", value: 1, description: "" },
        Item { name: "basalt", value: 2, description: "" },
    ],
};

fmi2_cosim::variables! {
    /// A stone in a hand.
    pub struct Stone {
        force: input("hand.force", Unit::NEWTON, "F").aliases(&[Alias::local("F", "F")]) = 1.0,
        mass: parameter("mass", Unit::KILOGRAM, "m").min(0.1).tunable()
            .aliases(&[Alias::local("stone.mass", "m")]) = 2.0,
        gravity: output("gravity", Unit::METRE_PER_SECOND_SQUARED, "g").constant()
            .aliases(&[Alias::output("planet.gravity", "g"), Alias::local("g", "g")]) = 9.81,
        acceleration: output("acceleration", Unit::METRE_PER_SECOND_SQUARED, "F / m - g")
            .depends_on(&["hand.force"])
            .aliases(&[
                Alias::output("stone.acceleration", "as the stone calls it"),
                Alias::local("a", "for short"),
            ]) = 0.0,
        corners: integer_output("corners", "of the stone").constant() = 7,
        round: boolean_output("round", "no corners").constant().local() = false,
        rock: enumeration_output("rock", &ROCK, "what it is of").constant() = 2,
        owner: string_output("owner", "whose it is").constant().local() = "Sisyphus".into(),
    }
}

impl Model for Stone {
    const NAME: &'static str = "Stone";
    const DESCRIPTION: &'static str = "A stone in a hand";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
    const VARIABLES: &'static [Variable<Self>] = Self::TABLE;

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.acceleration = self.force / self.mass - self.gravity;
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

fmi2_cosim::export!(Stone);
"""
CONSTANTS = {"gravity": "9.81", "planet.gravity": "9.81", "g": "9.81", "corners": "7",
             "round": "false", "rock": "2", "owner": "Sisyphus"}  # fmt: skip
ALIASES = {"F": "hand.force", "stone.mass": "mass", "planet.gravity": "gravity", "g": "gravity",
           "stone.acceleration": "acceleration", "a": "acceleration"}  # fmt: skip


def _manifest() -> str:
    return listing("Cargo.toml").replace("tank", "stone")


@pytest.fixture(scope="module")
def stone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return `Stone.fmu`."""
    folder = write_package(tmp_path_factory.mktemp("names") / "stone", _manifest(), STONE)
    done = cargo("fmu", "build", "--out", "out", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out/Stone.fmu"


def test_validators_find_nothing(stone: Path) -> None:
    done = cargo("fmu", "check", stone, folder=stone.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith(f"valid, {2 + len(CONSTANTS)} start values compared\n")
    assert validate_fmu(str(stone)) == []
    toolbox = Path(sys.executable).with_name("fmutool")
    checked = subprocess.run([toolbox, "-input", stone, "-check"], capture_output=True, text=True,
                             check=False)  # fmt: skip
    assert checked.returncode == 0, checked.stdout + checked.stderr


def test_the_description_tells_them_as_the_standard_wants(stone: Path) -> None:
    description = read_model_description(str(stone))
    variables = {v.name: v for v in description.modelVariables}
    constants = {v.name: v.start for v in variables.values() if v.variability == "constant"}
    assert constants == CONSTANTS
    for name, of in ALIASES.items():
        alias, own = variables[name], variables[of]
        assert alias.valueReference == own.valueReference
        assert (alias.type, alias.unit, alias.min) == (own.type, own.unit, own.min)
        assert alias.causality in ("output", "local")
        assert (alias.start is not None) == (alias.variability == "constant")
    listed = [[u.variable.name for u in unknowns]
              for unknowns in (description.outputs, description.initialUnknowns)]  # fmt: skip
    computed = ["acceleration", "stone.acceleration"]
    assert listed[1] == computed
    assert set(listed[0]) == {*computed, "gravity", "planet.gravity", "corners", "rock"}


def test_one_value_has_all_its_names_in_a_run(stone: Path) -> None:
    names = [*ALIASES, *ALIASES.values(), "corners", "round", "rock"]
    result = simulate_fmu(str(stone), output=names, start_values={"hand.force": 40.0, "mass": 4.0})
    for name, of in ALIASES.items():
        assert (result[name] == result[of]).all()
    assert set(result["stone.acceleration"]) == {10.0 - 9.81}
    assert set(result["g"]) == {9.81}
    assert [set(result[name]) for name in ("corners", "round", "rock")] == [{7}, {False}, {2}]


def test_nobody_sets_a_constant(stone: Path, tmp_path: Path) -> None:
    description = read_model_description(str(stone))
    variables = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(guid=description.guid, modelIdentifier="Stone", instanceName="stone",
                    unzipDirectory=extract(str(stone), str(tmp_path)))  # fmt: skip
    fmu.instantiate()
    stages = (lambda: None, fmu.setupExperiment, fmu.enterInitializationMode,
              fmu.exitInitializationMode)  # fmt: skip
    for stage in stages:
        stage()
        with pytest.raises(FMICallException):
            fmu.setReal([variables["g"]], [1.62])
        with pytest.raises(FMICallException):
            fmu.setString([variables["owner"]], ["Atlas"])
        assert fmu.getReal([variables["gravity"], variables["g"]]) == [9.81, 9.81]
        assert fmu.getString([variables["owner"]]) == [b"Sisyphus"]
    state = fmu.getFMUstate()
    assert b"Sisyphus" not in bytes(fmu.serializeFMUstate(state))
    fmu.freeFMUstate(state)
    fmu.terminate()
    fmu.freeInstance()


@pytest.mark.parametrize(
    ("row", "told"),
    [
        (("", ""), None),
        (('Alias::local("F", "F")', 'Alias::output("F", "F")'), "an alias is local"),
        (('Alias::local("F", "F")', 'Alias::local("g", "F")'), "two variables have the same name"),
        (('"of the stone").constant()', '"of the stone").constant().on_demand()'),
         "a constant depends on nothing"),
        ((".min(0.1).tunable()", ".constant()"), "constant for outputs and local variables"),
    ],
)  # fmt: skip
def test_a_table_that_breaks_the_rules_does_not_compile(
    row: tuple[str, str], told: str | None, tmp_path: Path
) -> None:
    package = write_package(tmp_path / "stone", _manifest(), STONE.replace(*row, 1))
    done = cargo("check", folder=package)
    assert (done.returncode == 0) == (told is None), done.stderr
    assert (told or "") in done.stderr


def test_a_constant_that_the_model_changes_is_found(tmp_path: Path) -> None:
    head, tail = STONE.split("fn step")
    code = f"{head}fn step{tail.replace('Ok(())', 'self.corners -= 1; Ok(())', 1)}"
    package = write_package(tmp_path / "stone", _manifest(), code)
    done = cargo("fmu", "build", "--out", "out", folder=package)
    assert done.returncode == 0, done.stderr
    checked = cargo("fmu", "check", package / "out/Stone.fmu", folder=package)
    assert checked.returncode == 3
    assert "corners is a constant of 7, but -13 after 20 steps" in checked.stdout
