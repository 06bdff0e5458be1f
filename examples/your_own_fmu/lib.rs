//! An oven as an FMU: a heated body that loses heat to the room. README.md tells the story.
//!
//! C dT/dt = P - G (T - T_room)

use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit as U, Variable as V};

/// The oven in SI units: parameters, inputs, the state T, outputs.
#[derive(Clone)]
pub struct Oven {
    capacity: f64,
    conductance: f64,
    start: f64,
    power: f64,
    room: f64,
    temperature: f64,
    loss: f64,
}

impl Default for Oven {
    fn default() -> Self {
        let (start, room, temperature) = (293.15, 293.15, 293.15);
        let (capacity, conductance, power, loss) = (2e4, 5.0, 0.0, 0.0);
        Self {
            capacity,
            conductance,
            start,
            power,
            room,
            temperature,
            loss,
        }
    }
}

/// Units that the shell does not know yet; exponents of kg, m, s, A, K, mol, cd, rad.
const J_PER_K: U = U::new("J/K", [1, 2, -2, 0, -1, 0, 0, 0], &[]);
const W_PER_K: U = U::new("W/K", [1, 2, -3, 0, -1, 0, 0, 0], &[]);

#[rustfmt::skip] // one variable, one line
const VARIABLES: &[V<Oven>] = &[
    V::input("heater.power", U::WATT, |m: &mut Oven| &mut m.power, "P").min(0.0),
    V::input("room.temperature", U::KELVIN, |m: &mut Oven| &mut m.room, "T_room").min(0.0),
    V::parameter("body.heatCapacity", J_PER_K, |m: &mut Oven| &mut m.capacity, "C").min(1e-3),
    V::parameter("wall.conductance", W_PER_K, |m: &mut Oven| &mut m.conductance, "G").min(1e-3),
    V::parameter("body.temperature_start", U::KELVIN, |m: &mut Oven| &mut m.start, "T(0)").min(0.0),
    V::output("body.temperature", U::KELVIN, |m: &mut Oven| &mut m.temperature, "T").depends_on(&[]),
    V::output("wall.heatFlow", U::WATT, |m: &mut Oven| &mut m.loss, "G (T - T_room)")
        .depends_on(&["room.temperature"]),
];

impl Model for Oven {
    const NAME: &'static str = "Oven";
    const DESCRIPTION: &'static str = "A heated body that loses heat to the room";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [V<Self>] = VARIABLES;
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 7200.0,
        step: 10.0,
    };

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        self.temperature = self.start;
        self.update_outputs();
        Ok(())
    }

    /// Exact while the inputs are held.
    fn step(&mut self, _time: f64, step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        let end = self.room + self.power / self.conductance;
        let remains = (-step * self.conductance / self.capacity).exp();
        self.temperature = end + (self.temperature - end) * remains;
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.loss = self.conductance * (self.temperature - self.room);
    }

    fn hidden_state(&mut self, _fields: &mut dyn StateFields) {}
}

fmi2_cosim::export!(Oven);
