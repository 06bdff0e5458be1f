//! Torque observers (19)-(31): both clutch torques and the drive-shaft torque from the signals of a
//! production car.
//!
//! ```text
//! Sample (speeds, positions, T_e) ──> load torque (20) ──┐
//!           ├──> lock detection ───> friction learnt      │
//!           ├──> monitor: can it be used?                 │
//!           └──> method: correct, adapt, predict <────────┘──> Estimate
//! ```
//!
//! One file per method: [`paper`], [`lyapunov`], [`energy`], [`kalman`], [`calibrating`]; [`select`] chooses one at run time, and turns
//! counted ticks into speeds first ([`encoder`]). A method is a function of (parameters, state, sample): no clock, no
//! log, no allocation.

pub mod adaptive;
pub mod anchor;
mod begun;
mod breakaway;
pub mod calibrating;
mod calibrating_model;
pub mod calibration;
mod carry;
pub mod damper;
pub mod design;
pub mod encoder;
pub mod energy;
mod filter;
pub mod friction;
pub mod friction_map;
pub mod grip;
pub mod heard;
pub mod instant;
pub mod kalman;
pub mod leap;
pub mod lever;
pub mod load;
pub mod lock;
pub mod lyapunov;
pub mod monitor;
pub mod paper;
pub mod phase;
#[cfg(test)]
mod poles;
pub mod prior;
mod recall;
mod schedule;
pub mod select;
pub mod shift;
pub mod speeds;
mod standstill;
mod swing;
mod ticks;
mod tracker;
pub mod walk;

pub use calibrating::Calibrating;
pub use calibration::Calibration;
pub use energy::Energy;
pub use kalman::Kalman;
pub use load::LoadMethod;
pub use lyapunov::Lyapunov;
pub use monitor::Fault;
pub use paper::{Gains, Paper};
pub use phase::Phase;
pub use select::{Method, Selected};

use crate::Params;
use crate::params::Actuation;
use instant::Instant;
use lever::Lever;

/// ω_e, ω_c1, ω_c2, ω_w: speeds that are measured.
pub const SPEEDS: usize = 4;

/// What a production car measures, at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// T_e: torque the engine control reports [N·m].
    pub t_e: f64,
    /// ω_e [rad/s].
    pub omega_e: f64,
    /// ω_c1, ω_c2 [rad/s], shape (2).
    pub omega_c: [f64; 2],
    /// ω_w [rad/s].
    pub omega_w: f64,
    /// Actuators of the two clutches.
    pub actuation: [Actuation; 2],
    /// Gears preselected on the odd and the even shaft, shape (2).
    pub gear: [i32; 2],
    /// Brake torque at the wheels [N·m], ≥ 0.
    pub t_brake: f64,
    /// φ: road grade [rad].
    pub phi: f64,
    /// T_y: torque of synchronisers at the output [N·m]; not measured but found by [`shift`], 0 until then.
    pub t_y: f64,
}

impl Sample {
    /// ω_e − ω_ci [rad/s], shape (2).
    pub fn slip(&self) -> [f64; 2] {
        self.omega_c.map(|omega_c| self.omega_e - omega_c)
    }

    /// ω_e, ω_c1, ω_c2, ω_w [rad/s].
    pub const fn speeds(&self) -> [f64; SPEEDS] {
        let [one, two] = self.omega_c;
        [self.omega_e, one, two, self.omega_w]
    }

    /// The same with other speeds ω_e, ω_c1, ω_c2, ω_w [rad/s].
    pub const fn with_speeds(self, [omega_e, one, two, omega_w]: [f64; SPEEDS]) -> Self {
        Self {
            omega_e,
            omega_c: [one, two],
            omega_w,
            ..self
        }
    }

    /// Every measurement is a number; only such a sample may enter an observer.
    #[inline(never)] // asked in several places, of which one is in the cache then
    pub fn is_finite(&self) -> bool {
        let [one, two] = self.actuation;
        let pairs = [
            [one.position, one.pressure],
            [two.position, two.pressure],
            [self.t_e, self.omega_e],
            self.omega_c,
            [self.omega_w, self.t_brake],
            [self.phi, self.t_y],
        ];
        // Terms that are too large for a sum of numbers add up to an infinity: they are looked at one by one.
        let sums = pairs.into_iter().fold([0.0; 2], |sums, pair| {
            [sums[0] + pair[0], sums[1] + pair[1]]
        });
        (sums[0] + sums[1]).is_finite() || pairs.iter().flatten().all(|value| value.is_finite())
    }

    /// Whether it may enter an observer `h` [s] after the last one.
    fn may_enter(&self, h: f64) -> bool {
        h > 0.0 && h < f64::INFINITY && self.is_finite()
    }
}

/// What an observer knows of its vehicle beside [`Params`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// μ_1,n, μ_2,n of (23), (24): nominal friction coefficients [1].
    pub mu_n: [f64; 2],
    /// How T_v is found.
    pub load: LoadMethod,
    /// Gains of `paper`, (19) and (29), as for 1 kHz.
    pub gains: Gains,
    /// Gains of `lyapunov`, as for 1 kHz.
    pub lyapunov: lyapunov::Gains,
    /// Gains of `energy`, as for 1 kHz.
    pub energy: energy::Gains,
    /// Noises that `kalman` believes in.
    pub kalman: kalman::Gains,
    /// Noises and anchors that `calibrating` believes in.
    pub calibrating: calibrating::Gains,
    /// Gains follow the communication step.
    pub scheduled: bool,
    /// (29) acts; without it the observer keeps the friction it has.
    pub adapts: bool,
    /// Ticks per revolution of the encoders that ω_e, ω_c1, ω_c2, ω_w are counted by [1], shape (4); 0 of a speed
    /// that is not counted, or counted by ticks that it tells itself. [`Selected`] acts on it, with [`encoder`].
    pub encoder: [f64; 4],
}

impl Settings {
    /// Case 1 of the paper: μ_n = (0.4, 0.1).
    pub const CASE_1: Self = Self {
        mu_n: [0.4, 0.1],
        load: LoadMethod::Momentum,
        gains: Gains::AT_1_KHZ,
        lyapunov: lyapunov::Gains::AT_1_KHZ,
        energy: energy::Gains::AT_1_KHZ,
        kalman: kalman::Gains::DEFAULT,
        calibrating: calibrating::Gains::DEFAULT,
        scheduled: true,
        adapts: true,
        encoder: [0.0; 4],
    };
}

/// What an observer says at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// T̂_c1, T̂_c2 [N·m], shape (2).
    pub t_c: [f64; 2],
    /// T̂_o [N·m].
    pub t_o: f64,
    /// Map-based T_c1, T_c2 of Figs. 10 and 12: nominal friction times map [N·m], shape (2).
    pub t_c_map: [f64; 2],
    /// Map-based T_o = g1 T_c1 + g2 T_c2 [N·m].
    pub t_o_map: f64,
    /// T_v as used in (19) [N·m].
    pub t_v: f64,
    /// μ̂·f of Figs. 11 and 13 [N/m], shape (2).
    pub mu_f: [f64; 2],
    /// ε̂ of (23), (24) [N/m], shape (2).
    pub epsilon: [f64; 2],
    /// μ learnt while slipping [1], shape (2).
    pub friction: [f64; 2],
    /// x1 − x̂1 [rad/s] and x2 − x̂2 [rad/s].
    pub innovation: [f64; 2],
    /// Innovation² of the speeds over what a filter expects [1]: 1 where it is right about itself; 0 of methods
    /// that expect nothing.
    pub consistency: f64,
    /// Clutch is taken as fully engaged, shape (2).
    pub engaged: [bool; 2],
    /// Standard deviation of T̂_c1, T̂_c2 where the method has one, otherwise the torque that its
    /// correction injects because the model leaves it unexplained [N·m], shape (2).
    pub t_c_deviation: [f64; 2],
    /// The same for T̂_o [N·m].
    pub t_o_deviation: f64,
    /// How well speeds show the friction of the clutches that slip [1], 0 to 1.
    pub excitation: f64,
    /// What the clutches do.
    pub phase: Phase,
    /// What `calibrating` learnt of its parameters; 0 of other methods.
    pub calibration: Calibration,
    /// The estimate can be used: there is no `fault`.
    pub valid: bool,
    /// Why the estimate cannot be used.
    pub fault: Option<Fault>,
}

impl Estimate {
    /// With μ̂·f and ε̂ of (23), (24) that belong to the torques; 0 below the touch point.
    fn with_friction_terms(mut self, settings: &Settings, now: &Instant<'_>) -> Self {
        for i in [0, 1] {
            let Lever { arm, f_n } = Lever::new(now, i);
            if arm > 0.0 {
                self.mu_f[i] = self.t_c[i] / arm;
                self.epsilon[i] = self.mu_f[i] - settings.mu_n[i] * f_n;
            }
        }
        self
    }

    /// What is said of a sample or a step that is no number.
    fn refused() -> Self {
        Self {
            fault: Some(Fault::NotFinite),
            ..Self::default()
        }
    }
}

/// Visits numbers of a state: reads or writes them.
pub type Visit<'a> = &'a mut dyn FnMut(&mut f64);

/// A time [s] that counts as over once the steps counted fall short of it by rounding alone.
///
/// At 10 ms such times are whole numbers of steps, and 0.01 + 0.01 + 0.01, reckoned as differences of times, may be short
/// of 0.03 by the last bit: the decision would come a step later, and the friction that is learnt, and with it a closed
/// loop, would differ visibly.
const fn lasting(time: f64) -> f64 {
    const ROUNDING: f64 = 1e-9; // of all that is counted, and far below any step
    time - ROUNDING
}

/// `value` between `low` and `high`: as [`f64::clamp`], but bounds that are no numbers, or cross, bound nothing and end
/// nothing. An infinite force makes such ones of a friction that is bounded to what it is.
pub(crate) const fn within(value: f64, low: f64, high: f64) -> f64 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// Visits a switch of a state as 0 or 1.
fn visit_switch(switch: &mut bool, visit: Visit<'_>) {
    let mut code = if *switch { 1.0 } else { 0.0 };
    visit(&mut code);
    *switch = code != 0.0;
}

/// A method of estimation. `p` and `settings` may change between calls where they are tunable.
pub trait Observer {
    /// Starts from measurements; the estimate holds for their instant.
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate;

    /// Advances by `h` [s].
    ///
    /// `sample`: speeds at the end of the step; torque, actuators, grade and brake as they acted over
    /// it. The estimate holds for the end of the step. A sample that is not finite, or a step that is
    /// not > 0 and finite, changes nothing: clutch torques of 0 come back, not valid.
    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate;

    /// [`Self::step`], whose estimate is written where the last one stands, that of [`Self::start`] or of a step: it is
    /// large, and to move it takes time.
    fn step_to(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        h: f64,
        y: &mut Estimate,
    ) {
        *y = self.step(p, settings, sample, h);
    }

    /// Visits every number of the state, in a fixed order: saves and restores it.
    fn visit(&mut self, visit: Visit<'_>);
}

/// The estimate that is written to its place.
fn made(write: impl FnOnce(&mut Estimate)) -> Estimate {
    let mut y = Estimate::default();
    write(&mut y);
    y
}

/// What every method says alike: map-based torques, phase, excitation, and whether it can be used.
fn say_common(
    y: &mut Estimate,
    settings: &Settings,
    now: &Instant<'_>,
    engaged: [bool; 2],
    fault: Option<Fault>,
) {
    let pressed = now.pressed();
    (y.t_c_map, y.t_o_map) = torques_of(settings.mu_n, now);
    y.engaged = engaged;
    y.excitation = phase::shown(now, pressed);
    y.phase = Phase::from_clutches(pressed, engaged);
    (y.valid, y.fault) = (fault.is_none(), fault);
}

/// Map-based torque of each clutch, μ_i,n F_map,i r_ci N_i, and its drive-shaft torque [N·m].
///
/// The conventional estimate that Figs. 10 and 12 compare with; it knows no sign of the slip.
pub fn map_based(p: &Params, mu_n: [f64; 2], sample: &Sample) -> ([f64; 2], f64) {
    torques_of(mu_n, &Instant::new(p, sample))
}

fn torques_of(mu_n: [f64; 2], now: &Instant<'_>) -> ([f64; 2], f64) {
    let Instant { p, g, force, .. } = *now;
    let t_c = [0, 1].map(|i| mu_n[i] * force[i] * p.clutch[i].r_c_n);
    (t_c, g[0] * t_c[0] + g[1] * t_c[1])
}

/// F_n of both clutches [N], shape (2).
fn forces(p: &Params, sample: &Sample) -> [f64; 2] {
    [0, 1].map(|i| p.clutch[i].force(sample.actuation[i]))
}

/// T_b: brake torque that is measured, against the motion [N·m].
fn brake(p: &Params, sample: &Sample) -> f64 {
    if sample.t_brake == 0.0 {
        0.0 // mostly; the direction is a tanh
    } else {
        sample.t_brake * p.road.direction(sample.omega_w)
    }
}
