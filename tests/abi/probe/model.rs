//! An integrator that panics when its input is above 100.

use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

/// x' = u.
#[derive(Clone, Default)]
pub struct Probe {
    initial: f64,
    u: f64,
    x: f64,
}

impl Model for Probe {
    const NAME: &'static str = "Probe";
    const DESCRIPTION: &'static str = "An integrator that panics when its input is above 100";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 1.0,
        step: 0.001,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, "Input").min(0.0),
        Variable::output("x", Unit::ONE, |m: &mut Self| &mut m.x, "Integral").depends_on(&[]),
        Variable::parameter("initial", Unit::ONE, |m: &mut Self| &mut m.initial, "x(0)"),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.x = self.initial;
        Ok(())
    }

    fn step(&mut self, _: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        assert!(self.u <= 100.0, "100 % of what the probe bears");
        self.x += step * self.u;
        Ok(())
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}
