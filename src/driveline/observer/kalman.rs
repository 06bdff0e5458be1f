//! Method `kalman`: a Kalman filter of the torques, the competitor [26], [27] of the paper.
//!
//! ```text
//! x = (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v)
//! J_ed ω_e' = T_e − T_c1 − T_c2   J_out ω_o' = g1 T_c1 + g2 T_c2 + T_y − T_o   J_v ω_w' = T_o − T_v − T_b
//! T_o = T_s + c (ω_o − ω_w)          T_s' = k (ω_o − ω_w)                      T_v' = 0
//! y = (ω_e, ω_c1, ω_c2, ω_w),  ω_ci = g_i ω_o where a gear is in
//! ```
//!
//! with white noise of intensity q on every line: predict x̂⁺ = Φ x̂ + Γ T_e, P⁺ = Φ P Φᵀ + Q, exactly for a
//! step of any length but for the damper (second order); then correct by each speed in turn. T_c1 and T_c2 move as
//! carry.rs has it: with the force of a clutch that slips, with the damper behind one that is engaged. The competitor
//! takes both for random walks, which lag by 5-6 % of RMS in a handover and a gear change.
//! A clutch below its touch point carries nothing: its torque is a measurement of zero. T_v is estimated, so no load
//! method is needed; a brake torque T_b that is measured is an input. No friction map enters: μ̂ is T̂_c over the force.
//!
//! **Proof: of optimality only.** For this model with Gaussian noise, while the clutches stay as they are, no linear
//! filter has less variance, and P says how much is left. Observable: ω_e gives T_c1 + T_c2, ω_o gives
//! g1 T_c1 + g2 T_c2 − T_o, the twist ω_o − ω_w gives T_s' and with it the level of T_o, ω_w gives T_o − T_v; so all
//! seven states for g1 ≠ g2. What the model does not say is not covered: T_e and J_e errors go straight into T_c.

use crate::Params;
use crate::observer::filter::{Flow, Motion, Rows, Terms, with_damper};
use crate::observer::grip::{Grip, Hold};
use crate::observer::instant::Instant;
use crate::observer::speeds::Speeds;
use crate::observer::tracker::{SHARED, START, T_C, Tracker, W_W};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, brake};
use nalgebra::{SVector, Vector6};

const N: usize = SHARED;
type Vector = SVector<f64, N>;

/// What the filter believes of its noises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// q_T: intensity of the friction of a slipping clutch, relative [1/s].
    pub q_t: f64,
    /// q_v: intensity of T_v [(N·m)²/s].
    pub q_v: f64,
    /// q_w: intensity of the speeds [(rad/s)²/s].
    pub q_w: f64,
    /// q_s: intensity of T_s [(N·m)²/s].
    pub q_s: f64,
    /// Standard deviation of a measured speed [rad/s].
    pub sigma: f64,
}

impl Gains {
    /// Per second, so for every step.
    pub const DEFAULT: Self = Self {
        q_t: 0.1,
        q_v: 550.0,
        q_w: 1e-6,
        q_s: 20.0,
        sigma: 0.1,
    };

    /// Intensities of the states, shape (7); those of T_c1, T_c2 are relative.
    fn intensities(&self) -> Vector {
        let Self {
            q_t, q_v, q_w, q_s, ..
        } = *self;
        Vector::from([q_w, q_w, q_w, q_s, q_t, q_t, q_v])
    }
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Kalman {
    /// The filter and what watches it.
    pub tracker: Tracker<N>,
    /// How the clutches carry their torque.
    pub grip: Grip,
    /// The discrete model and what it was made for: derived, not part of the state.
    cache: Option<(Speeds, f64, Discrete)>,
}

/// The rows of Φ that move, and the effect of T_e, T_b and T_y, over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Discrete {
    rows: Rows<N>,
    gamma_e: Vector6<f64>,
    gamma_b: Vector6<f64>,
    gamma_y: Vector6<f64>,
}

impl Discrete {
    fn new(model: &Speeds, h: f64) -> Self {
        let (flow, b) = (Flow::new(model, h), model.b());
        let mut by = Motion::<N>::zeros();
        by.fixed_columns_mut::<3>(T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        let known = |j: usize| {
            let moved = flow.gamma * b.column(j);
            let mut all = Vector6::zeros();
            all.fixed_rows_mut::<4>(0).copy_from(&moved);
            if let Some(i) = model.engaged {
                let [e, o] = model.twist();
                all[T_C + i] = 0.5 * h * (e * moved[0] + o * moved[1]);
            }
            all
        };
        Self {
            rows: with_damper(&flow.rows(&by), model, h),
            gamma_e: known(0),
            gamma_b: known(3),
            gamma_y: known(4),
        }
    }
}

impl Observer for Kalman {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self {
            tracker: Tracker::new(settings, Vector::zeros(), Vector::from(START)),
            ..Self::default()
        };
        if !sample.is_finite() {
            return self.tracker.refuse();
        }
        let now = Instant::new(p, sample);
        self.tracker.start(&now, WHEEL);
        self.estimate(&now, settings, &self.model(p, sample))
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !sample.may_enter(h) {
            return self.tracker.refuse();
        }
        let now = Instant::new(p, sample);
        self.tracker.follow(&now, h);
        let hold = self
            .grip
            .step(&now, &self.tracker.lock, self.tracker.engaged);
        self.tracker.follow_force(hold);
        let standing = self.tracker.held(p, sample, || p.c_o);
        self.predict(standing.as_ref().unwrap_or(p), settings, sample, hold, h);
        let sigma = settings.kalman.sigma;
        self.tracker.correct(&now, [sigma; 2], sigma, WHEEL, h);
        self.tracker.remember(&now, hold, h);
        let model = self.model(p, sample);
        self.tracker.watch(&now, settings, &model, h);
        self.estimate(&now, settings, &model)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            tracker,
            grip,
            cache: _,
        } = self;
        tracker.visit(visit);
        grip.visit(visit);
    }
}

impl Kalman {
    fn estimate(&self, now: &Instant<'_>, settings: &Settings, model: &Speeds) -> Estimate {
        let said = self.tracker.estimate(now, settings, model);
        said.with_friction_terms(settings, now)
    }

    fn model(&self, p: &Params, sample: &Sample) -> Speeds {
        Speeds::new(p, sample.gear).behind(p, self.tracker.engaged, 1.0)
    }

    fn predict(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        hold: [Hold; 2],
        h: f64,
    ) {
        let model = self.model(p, sample);
        let discrete = match self.cache {
            Some((of, step, discrete)) if (of, step) == (model, h) => discrete,
            _ => Discrete::new(&model, h),
        };
        self.cache = Some((model, h, discrete));
        let Discrete {
            rows,
            gamma_e,
            gamma_b,
            gamma_y,
        } = discrete;
        let mut q = settings.kalman.intensities();
        self.tracker.noise(&model, hold, &mut q);
        let belief = &mut self.tracker.belief;
        let known = gamma_e * sample.t_e + gamma_b * brake(p, sample) + gamma_y * sample.t_y;
        let moved = rows * belief.x + known;
        belief.x.fixed_rows_mut::<6>(0).copy_from(&moved);
        belief.spread(&rows, &[0, 1, 2, 3, 4, 5, 6], &(q * h));
    }
}

/// What the wheel sensor shows of the states.
const WHEEL: Terms<'_> = &[(W_W, 1.0)];
