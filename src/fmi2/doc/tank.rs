use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

const FLOW: Unit = Unit::new("m3/s", [0, 3, -1, 0, 0, 0, 0, 0], &[]); // kg, m, s, A, K, mol, cd, rad
const VOLUME: Unit = Unit::new("m3", [0, 3, 0, 0, 0, 0, 0, 0], &[]);

fmi2_cosim::variables! {
    /// A tank with a hole: dV/dt = inflow - V / (5 s).
    pub struct Tank {
        inflow: input("inflow", FLOW, "Inflow").min(0.0) = 0.0,
        volume: output("volume", VOLUME, "V").depends_on(&[]) = 0.0,
    }
}

impl Model for Tank {
    fmi2_cosim::of_package!();
    const NAME: &'static str = "Tank";
    const DESCRIPTION: &'static str = "A tank with a hole";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 60.0, 0.1);
    const VARIABLES: &'static [Variable<Self>] = Self::TABLE;

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        self.volume = 0.0;
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        let full = 5.0 * self.inflow;
        self.volume = full + (self.volume - full) * (-step / 5.0).exp();
        Ok(())
    }

    fn hidden_state(&mut self, _fields: &mut dyn StateFields) {}
}
