"""A package outside this workspace that knows `fmi2-cosim` alone: `cargo fmu` makes its FMU."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from outside import BUILT, ROOT, cargo, listing, write_package

LEFT = 5.0  # s, in which a tank empties to 1/e
ROUNDING = 1e-12  # relative: sixty steps of some 1e-16 each

# Whoever panics behind an importer must not take it along, whatever the package wants.
ABORT = '\n[profile.release]\npanic = "abort"\nstrip = false\n'


@pytest.fixture(scope="module")
def tank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU of the page's package, in a folder whose name is no plain one."""
    folder = tmp_path_factory.mktemp("outside") / "a tänk"
    code = listing("src/lib.rs").replace(
        "let full =", 'assert!(self.inflow < 1e3, "burst");\n        let full ='
    )
    write_package(folder, listing("Cargo.toml") + ABORT, code)
    done = cargo("fmu", "build", "--out", "out", folder=folder)
    assert done.returncode == 0, done.stderr
    fmu = folder / "out/Tank.fmu"
    assert done.stdout == f"{fmu}\n"
    return fmu


def test_the_page_and_the_readme_of_the_crate_show_the_same_package() -> None:
    readme = (ROOT / "src/fmi2/README.md").read_text(encoding="utf-8")
    for name in ("src/lib.rs", "Cargo.toml"):
        assert listing(name).rstrip() in readme


def test_its_fmu_is_valid(tank: Path) -> None:
    done = cargo("fmu", "check", tank, folder=tank.parent)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "valid, 1 start values compared" in done.stdout
    assert validate_fmu(str(tank)) == []
    description = read_model_description(str(tank))
    assert (description.modelName, description.version) == ("Tank", "0.1.0")


def test_it_fills_as_on_paper(tank: Path) -> None:
    result = simulate_fmu(
        str(tank), stop_time=60.0, output_interval=1.0, start_values={"inflow": 2e-3}
    )
    volume = 2e-3 * LEFT * (1.0 - np.exp(-result["time"] / LEFT))
    np.testing.assert_allclose(result["volume"], volume, rtol=ROUNDING)


def test_a_panic_ends_in_the_fmu_whatever_its_profile_says(tank: Path) -> None:
    program = (
        "import sys, fmpy\n"
        "try: fmpy.simulate_fmu(sys.argv[1], start_values={'inflow': 2e3})\n"
        "except Exception as error: print('survived', error)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, tank], capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "survived" in done.stdout


def test_its_name_is_all_that_is_told_of_this_machine(tank: Path) -> None:
    """The folders of sources and of cargo are in no member: two machines build the same bytes."""
    text = subprocess.run(["unzip", "-p", tank], capture_output=True, check=True).stdout
    for folder in (tank.parents[1], ROOT, Path.home() / ".cargo"):
        assert str(folder).encode() not in text


@pytest.mark.parametrize(
    ("manifest", "code", "told"),
    [
        (("crate-type = ", "# "), ("", ""), r'is of type \["lib"\]; write crate-type'),
        (("fmi2-cosim", "# "), ("", ""), "tank does not depend on fmi2-cosim"),
        (("", ""), ("fmi2_cosim::export", "// "), "write fmi2_cosim::export"),
        (("", ""), ("pub struct", "struct"), "make the model pub"),
    ],
)
def test_what_is_missing_is_told(
    tmp_path: Path, manifest: tuple[str, str], code: tuple[str, str], told: str
) -> None:
    text, rust = listing("Cargo.toml"), listing("src/lib.rs")
    write_package(tmp_path / "tank", text.replace(*manifest, 1), rust.replace(*code))
    done = cargo("fmu", "build", "--manifest-path", "tank", folder=tmp_path)
    assert done.returncode == 1
    assert re.search(told, done.stderr), done.stderr


def test_a_workspace_gives_the_fmus_of_all_its_packages(tmp_path: Path) -> None:
    (tmp_path / "Cargo.toml").write_text(
        '[workspace]\nresolver = "3"\nmembers = ["tank", "plain"]\n'
    )
    write_package(tmp_path / "tank", listing("Cargo.toml"), listing("src/lib.rs"))
    write_package(tmp_path / "plain", '[package]\nname = "plain"\nversion = "0.1.0"\n', "")
    done = cargo("fmu", "build", "--manifest-path", tmp_path / "Cargo.toml", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{BUILT / 'fmu/Tank.fmu'}\n"
    (tmp_path / "tank/Cargo.toml").unlink()
    write_package(tmp_path / "none", '[package]\nname = "tank"\nversion = "0.1.0"\n', "")
    (tmp_path / "none/Cargo.toml").rename(tmp_path / "tank/Cargo.toml")
    done = cargo("fmu", "build", folder=tmp_path)
    assert done.returncode == 1
    assert "no package of the workspace" in done.stderr


FAN = """
use fmi2_cosim::{Experiment, Failure, LoadError, Log, Model, Resources, StateFields};
use fmi2_cosim::{Unit, Variable};
use std::sync::Arc;

#[derive(Clone, Default)]
pub struct Fan {
    speed: f64,
    power: f64,
    curve: Arc<[f64]>,
}

impl Model for Fan {
    const NAME: &'static str = "Fan";
    const DESCRIPTION: &'static str = "A fan with a curve of its own";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
    const RESOURCES: bool = true;
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("speed", Unit::ONE, |m: &mut Self| &mut m.speed, "").min(0.0).max(2.0),
        Variable::output("power", Unit::WATT, |m: &mut Self| &mut m.power, "")
            .depends_on(&["speed"]),
    ];

    fn load(&mut self, files: Option<&Resources>, _: &mut Log<'_>) -> Result<(), LoadError> {
        let lines = files.ok_or("no fmuResourceLocation")?.text("maps/curve.txt")?;
        let numbers = lines.lines().map(|line| line.trim().parse());
        self.curve = numbers.collect::<Result<_, _>>()?;
        Ok(())
    }

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.power = self.curve.get(self.speed as usize).copied().unwrap_or(f64::NAN);
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

fmi2_cosim::export!(Fan);
"""
CURVE = [0.0, 0.125, 0.75]  # W at 0, 1, 2


def test_files_of_a_model_travel_in_its_fmu(tmp_path: Path) -> None:
    package = write_package(tmp_path / "fan", listing("Cargo.toml").replace("tank", "fan"), FAN)
    missing = cargo("fmu", "build", folder=package)
    assert missing.returncode == 1
    assert "resources: the model reads files of its FMU, but there are none" in missing.stderr
    (package / "resources/maps").mkdir(parents=True)
    (package / "resources/maps/curve.txt").write_text("".join(f"{value}\n" for value in CURVE))
    done = cargo("fmu", "build", "--out", "out", folder=package)
    assert done.returncode == 0, done.stderr
    fmu = package / "out/Fan.fmu"
    checked = cargo("fmu", "check", fmu, folder=package)
    assert checked.returncode == 0, checked.stdout
    shutil.rmtree(package / "resources")  # the FMU has its own
    for speed, power in enumerate(CURVE):
        result = simulate_fmu(str(fmu), start_values={"speed": speed})
        assert set(result["power"]) == {power}


def test_without_its_files_there_is_no_instance_and_the_log_says_why(tmp_path: Path) -> None:
    package = write_package(tmp_path / "fan", listing("Cargo.toml").replace("tank", "fan"), FAN)
    (package / "resources/maps").mkdir(parents=True)
    (package / "resources/maps/curve.txt").write_text("a curve\n")
    done = cargo("fmu", "build", "--out", "out", folder=package)
    assert done.returncode == 0, done.stderr
    checked = cargo("fmu", "check", package / "out/Fan.fmu", folder=package)
    assert checked.returncode == 3
    assert "fmi2Instantiate: invalid float literal" in checked.stdout
