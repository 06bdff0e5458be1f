//! An oven as an FMU: C dT/dt = P - G (T - T_room). README.md tells the story.
use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit as U, Variable};

const J_PER_K: U = U::new("J/K", [1, 2, -2, 0, -1, 0, 0, 0], &[]); // kg, m, s, A, K, mol, cd, rad
const W_PER_K: U = U::new("W/K", [1, 2, -3, 0, -1, 0, 0, 0], &[]);

fmi2_cosim::variables! {
    /// The oven: field, role, name, unit, meaning, limits, start value.
    pub struct Oven {
        power: input("heater.power", U::WATT, "P").min(0.0) = 0.0,
        room: input("room.temperature", U::KELVIN, "T_room").min(0.0) = 293.15,
        capacity: parameter("body.heatCapacity", J_PER_K, "C").min(1e-3) = 2e4,
        conductance: parameter("wall.conductance", W_PER_K, "G").min(1e-3) = 5.0,
        start: parameter("body.temperature_start", U::KELVIN, "T(0)").min(0.0) = 293.15,
        temperature: output("body.temperature", U::KELVIN, "T").depends_on(&[]) = 293.15,
        loss: output("wall.heatFlow", U::WATT, "G (T - T_room)").depends_on(&["room.temperature"]) = 0.0,
    }
}

impl Model for Oven {
    fmi2_cosim::of_package!();
    const NAME: &'static str = "Oven";
    const DESCRIPTION: &'static str = "A heated body that loses heat to the room";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 7200.0, 10.0);
    const VARIABLES: &'static [Variable<Self>] = Self::TABLE;

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        self.temperature = self.start;
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        let end = self.room + self.power / self.conductance; // exact while inputs are held
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
