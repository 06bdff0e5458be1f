"""What a model of one's own forgets to save: `cargo fmu check` finds it in the FMU."""

from __future__ import annotations

from pathlib import Path

from outside import cargo, listing, write_package

LAGS = """
use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

#[derive(Clone, Default)]
pub struct Lags {
    u: f64,
    first: f64,
    y: f64,
}

impl Model for Lags {
    const NAME: &'static str = "Lags";
    const DESCRIPTION: &'static str = "Two lags in series, of which the first one is no variable";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 10.0, 0.1);
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, ""),
        Variable::output("y", Unit::ONE, |m: &mut Self| &mut m.y, "").depends_on(&[]),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        (self.first, self.y) = (0.0, 0.0);
        Ok(())
    }

    fn step(&mut self, _: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.y += step * (self.first - self.y);
        self.first += step * (self.u - self.first);
        Ok(())
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        fields.real(&mut self.first);
    }
}

fmi2_cosim::export!(Lags);
"""
VISIT = "fields.real(&mut self.first);"


def _checked(folder: Path, code: str) -> tuple[int, str]:
    """Build the FMU of `code`; return exit code and words of its check."""
    write_package(folder, listing("Cargo.toml").replace("tank", "lags"), code)
    built = cargo("fmu", "build", "--out", "out", folder=folder)
    assert built.returncode == 0, built.stderr
    done = cargo("fmu", "check", "out/Lags.fmu", folder=folder)
    return done.returncode, done.stdout + done.stderr


def test_a_state_that_is_forgotten_is_found_where_bytes_are_read_back(tmp_path: Path) -> None:
    assert LAGS.count(VISIT) == 1
    code, said = _checked(tmp_path / "whole", LAGS)
    assert code == 0, said
    forgetful = LAGS.replace(VISIT, "let _ = fields;")
    code, said = _checked(tmp_path / "forgetful", forgetful)
    assert code != 0
    assert "step 1 after fmi2SetFMUstate of a serialised state in a new instance: y is" in said
