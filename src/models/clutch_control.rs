//! `DctClutchControl`: torque requests become actuator positions, as an FMU.
//!
//! With feedback the friction comes from the observer, without it from the nominal value: the
//! map-based control. Positions are written by a step, so they depend on states only.

use crate::ports;
use crate::rows::table;
use crate::vehicle::{Vehicle, actuator, check_maps};
use dct_driveline::Params;
use dct_driveline::control::{limit_rate, position};
use dct_driveline::observer::Settings;
use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Unit as U, Variable};

/// The control: what it believes of the clutches, inputs, positions.
#[derive(Clone)]
pub struct ClutchControl {
    p: Params,
    /// μ_n [1].
    nominal_friction: [f64; 2],
    /// Fastest motion of the actuators [m/s].
    rate_limit: [f64; 2],
    feedback: bool,
    /// Requested torques [N·m].
    request: [f64; 2],
    /// μ̂·f of the observer [N/m].
    mu_f: [f64; 2],
    /// μ̂ of the observer [1].
    friction: [f64; 2],
    /// Positions [m].
    position: [f64; 2],
}

impl Default for ClutchControl {
    fn default() -> Self {
        Self {
            p: Params::TABLE_1,
            nominal_friction: Settings::CASE_1.mu_n,
            rate_limit: [0.2; 2],
            feedback: true,
            request: [0.0; 2],
            mu_f: [0.0; 2],
            friction: [0.0; 2],
            position: [0.0; 2],
        }
    }
}

impl Vehicle for ClutchControl {
    fn params(&mut self) -> &mut Params {
        &mut self.p
    }
}

impl ClutchControl {
    /// Friction coefficient to count on [1].
    ///
    /// An observer that gives no μ̂ (0) is asked for μ̂·f, which the present position turns into one.
    fn mu(&self, i: usize) -> f64 {
        let theta = self.position[i];
        let force = self.p.clutch[i].map.force(theta);
        if !self.feedback {
            self.nominal_friction[i]
        } else if self.friction[i] > 0.0 {
            self.friction[i]
        } else if force > 0.0 && self.mu_f[i] > 0.0 {
            self.mu_f[i] * theta / force
        } else {
            self.nominal_friction[i]
        }
    }

    /// Position of each request [m].
    fn targets(&self) -> [f64; 2] {
        [0, 1].map(|i| position(&self.p.clutch[i], self.request[i], self.mu(i)))
    }
}

impl Model for ClutchControl {
    const NAME: &'static str = "DctClutchControl";
    const DESCRIPTION: &'static str =
        "Clutch control: requested clutch torques and estimated friction to actuator positions";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [Variable<Self>] = table!(ClutchControl:
        FEEDBACK, clutch::<0>(), clutch::<1>(), actuator::<_, 0>(), actuator::<_, 1>(),
    );
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 30.0,
        step: 1e-3,
    };

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        check_maps(&self.p)?;
        self.position = [0.0; 2];
        self.position = self.targets();
        Ok(())
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        let target = self.targets();
        self.position =
            [0, 1].map(|i| limit_rate(self.position[i], target[i], self.rate_limit[i], step));
        Ok(())
    }

    fn hidden_state(&mut self, _fields: &mut dyn StateFields) {}
}

const FEEDBACK: [Variable<ClutchControl>; 1] = [Variable::boolean_input(
    "feedback.enabled",
    |m: &mut ClutchControl| &mut m.feedback,
    "Use the observer's friction; otherwise the nominal one (map-based control)",
)];

const fn clutch<const I: usize>() -> [Variable<ClutchControl>; 6] {
    let rate_limit = ["clutch1.rateLimit", "clutch2.rateLimit"][I];
    [
        Variable::input(
            ports::CLUTCH_TORQUE_REQUEST[I],
            U::NEWTON_METRE,
            |m: &mut ClutchControl| &mut m.request[I],
            "Torque the clutch shall carry when it slips; 0 opens it",
        )
        .min(0.0),
        Variable::input(
            ports::CLUTCH_FRICTION[I],
            U::ONE,
            |m: &mut ClutchControl| &mut m.friction[I],
            "Friction coefficient from the observer; 0: take muF instead",
        ),
        Variable::input(
            ports::CLUTCH_MU_F[I],
            U::NEWTON_PER_METRE,
            |m: &mut ClutchControl| &mut m.mu_f[I],
            "Adapted mu f from the observer, used where it gives no friction",
        ),
        Variable::output(
            ports::CLUTCH_POSITION[I],
            U::METRE,
            |m: &mut ClutchControl| &mut m.position[I],
            "theta_m: actuator position",
        )
        .depends_on(&[]),
        Variable::parameter(
            ports::CLUTCH_NOMINAL_FRICTION[I],
            U::ONE,
            |m: &mut ClutchControl| &mut m.nominal_friction[I],
            "mu_n: friction coefficient without feedback",
        )
        .min(0.02)
        .max(1.0)
        .tunable(),
        Variable::parameter(
            rate_limit,
            U::METRE_PER_SECOND,
            |m: &mut ClutchControl| &mut m.rate_limit[I],
            "Fastest motion of the actuator",
        )
        .min(1e-6),
    ]
}
