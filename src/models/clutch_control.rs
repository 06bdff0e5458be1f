//! `DctClutchControl`: torque requests become actuator positions, as an FMU.
//!
//! With feedback the friction comes from the observer, and its torque estimates may close two more
//! loops; without it the nominal friction counts alone: the map-based control. Positions are written by a
//! step, so they depend on states only.

mod table;

use crate::step::SCENARIO;
use crate::vehicle::{Vehicle, check_maps, invalid};
use dct_driveline::Params;
use dct_driveline::control::{Demand, Rate, Servo, Tuning};
use dct_driveline::observer::Settings;
use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Variable};

/// The control: what it believes of the clutches, inputs, positions.
#[derive(Clone)]
pub struct ClutchControl {
    p: Params,
    /// μ_n [1].
    nominal_friction: [f64; 2],
    /// Rate, stroke and gains per clutch.
    tuning: [Tuning; 2],
    feedback: bool,
    /// Requested torques [N·m].
    request: [f64; 2],
    /// ω_e [rad/s].
    omega_e: f64,
    /// ω_c1, ω_c2 [rad/s].
    omega_c: [f64; 2],
    estimate: Estimate,
    state: State,
}

/// What the observer says.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    /// μ̂·f [N/m].
    mu_f: [f64; 2],
    /// μ̂ [1].
    friction: [f64; 2],
    /// T̂_c1, T̂_c2 [N·m].
    t_c: [f64; 2],
    /// T̂_o [N·m].
    t_o: f64,
    valid: bool,
}

/// What lasts from step to step.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    servo: [Servo; 2],
    t_o: Rate,
    /// Friction of the last valid estimate [1]; 0: none yet.
    mu: [f64; 2],
}

impl Default for ClutchControl {
    fn default() -> Self {
        let tuning = Tuning {
            rate: 0.2,
            stroke: [0.0, Params::TABLE_1.clutch[0].map.position[9]],
            torque_gain: Tuning::TORQUE_GAIN,
            damping: 0.0,
        };
        Self {
            p: Params::TABLE_1,
            nominal_friction: Settings::CASE_1.mu_n,
            tuning: [tuning; 2],
            feedback: true,
            request: [0.0; 2],
            omega_e: 0.0,
            omega_c: [0.0; 2],
            estimate: Estimate {
                mu_f: [0.0; 2],
                friction: [0.0; 2],
                t_c: [0.0; 2],
                t_o: 0.0,
                valid: true,
            },
            state: State::default(),
        }
    }
}

impl Vehicle for ClutchControl {
    fn params(&mut self) -> &mut Params {
        &mut self.p
    }
}

impl ClutchControl {
    /// Friction coefficient that the observer knows [1].
    ///
    /// An observer that gives no μ̂ (0) is asked for μ̂·f, which the present position turns into one.
    fn learnt(&self, i: usize) -> Option<f64> {
        let (friction, mu_f) = (self.estimate.friction[i], self.estimate.mu_f[i]);
        if friction > 0.0 {
            return Some(friction);
        }
        let theta = self.state.servo[i].position;
        let force = self.p.clutch[i].map.force(theta);
        (force > 0.0 && mu_f > 0.0).then(|| mu_f * theta / force)
    }

    /// Friction coefficient to count on [1]: one that is not valid any more stays the last that was.
    fn mu(&mut self, i: usize) -> f64 {
        if self.estimate.valid {
            self.state.mu[i] = self.learnt(i).unwrap_or(0.0);
        }
        if self.feedback && self.state.mu[i] > 0.0 {
            self.state.mu[i]
        } else {
            self.nominal_friction[i]
        }
    }

    fn demand(&mut self, i: usize, t_o_rate: f64) -> Demand {
        let trusted = self.feedback && self.estimate.valid;
        Demand {
            request: self.request[i],
            slip: self.omega_e - self.omega_c[i],
            mu: self.mu(i),
            torque: trusted.then_some(self.estimate.t_c[i]),
            t_o_rate,
        }
    }

    /// A stroke has a length.
    fn check_stroke(&self) -> Result<(), Failure> {
        for (i, tuning) in self.tuning.iter().enumerate() {
            let [low, high] = tuning.stroke;
            if high <= low {
                let remedy = "must be above strokeMinimum of the same clutch";
                return Err(invalid(table::STROKE_MAXIMUM[i], high, remedy));
            }
        }
        Ok(())
    }
}

impl Model for ClutchControl {
    const NAME: &'static str = "DctClutchControl";
    const DESCRIPTION: &'static str =
        "Clutch control: requested clutch torques and estimates to actuator positions";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [Variable<Self>] = table::VARIABLES;
    const EXPERIMENT: Experiment = SCENARIO;

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        self.consistent()?;
        self.state = State {
            t_o: Rate::at(self.estimate.t_o),
            ..State::default()
        };
        for i in [0, 1] {
            let demand = self.demand(i, 0.0);
            self.state.servo[i] = Servo::start(&self.p.clutch[i], &self.tuning[i], &demand);
        }
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        let rate = self.state.t_o.step(self.estimate.t_o, step);
        for i in [0, 1] {
            let demand = self.demand(i, rate);
            self.state.servo[i].step(&self.p.clutch[i], &self.tuning[i], &demand, step);
        }
        Ok(())
    }

    fn consistent(&self) -> Result<(), Failure> {
        check_maps(&self.p)?;
        self.check_stroke()
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        // All fields by name: one that is added does not compile before somebody has decided what it is.
        let Self {
            state: State { servo, t_o, mu },
            // Variables of the table.
            p: _,
            nominal_friction: _,
            tuning: _,
            feedback: _,
            request: _,
            omega_e: _,
            omega_c: _,
            estimate: _,
        } = self;
        fields.real(t_o.state());
        fields.reals(mu);
        for servo in servo {
            let Servo {
                mu,
                position: _, // variables of the table
                trim: _,
            } = servo;
            fields.real(mu);
        }
    }
}
