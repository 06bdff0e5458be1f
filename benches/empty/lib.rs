//! The FMU library `BenchEmpty`: five inputs, five outputs, and a step that does nothing.

use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

/// Five inputs and five outputs without a connection.
#[derive(Clone, Default)]
pub struct Empty {
    u: [f64; 5],
    y: [f64; 5],
}

const fn input<const K: usize>() -> Variable<Empty> {
    let name = ["u1", "u2", "u3", "u4", "u5"][K];
    Variable::input(name, Unit::ONE, |m: &mut Empty| &mut m.u[K], "Not used")
}

const fn output<const K: usize>() -> Variable<Empty> {
    let name = ["y1", "y2", "y3", "y4", "y5"][K];
    Variable::output(name, Unit::ONE, |m: &mut Empty| &mut m.y[K], "Always 0").depends_on(&[])
}

impl Model for Empty {
    const NAME: &'static str = "BenchEmpty";
    const DESCRIPTION: &'static str = "An FMU without a model";
    const VARIABLES: &'static [Variable<Self>] = &[
        input::<0>(),
        input::<1>(),
        input::<2>(),
        input::<3>(),
        input::<4>(),
        output::<0>(),
        output::<1>(),
        output::<2>(),
        output::<3>(),
        output::<4>(),
    ];
    const STEPS_STAY_FINITE: bool = true;
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 30.0,
        step: 1e-3,
    };

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _time: f64, _step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn hidden_state(&mut self, _fields: &mut dyn StateFields) {}
}

fmi2_cosim::export!(Empty);
