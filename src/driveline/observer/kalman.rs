//! Method `kalman`: a Kalman filter whose torques are random walks, the competitor [26], [27] of the paper.
//!
//! ```text
//! x = (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v)
//! J_ed ω_e' = T_e − T_c1 − T_c2   J_out ω_o' = g1 T_c1 + g2 T_c2 + T_y − T_o   J_v ω_w' = T_o − T_v − T_b
//! T_o = T_s + c (ω_o − ω_w)          T_s' = k (ω_o − ω_w)                      T_c1' = T_c2' = T_v' = 0
//! y = (ω_e, ω_c1, ω_c2, ω_w),  ω_ci = g_i ω_o where a gear is in
//! ```
//!
//! with white noise of intensity q on every line: predict x̂⁺ = Φ x̂ + Γ T_e, P⁺ = Φ P Φᵀ + Q, exactly for a
//! step of any length; then correct by each speed in turn. A clutch below its touch point carries
//! nothing: its torque is a measurement of zero. T_v is estimated, so no load method is needed; a brake
//! torque T_b that is measured is an input. No friction map enters: μ̂ is T̂_c over the force.
//!
//! **Proof: of optimality only.** For this model with Gaussian noise no linear filter has less variance,
//! and P says how much is left. Observable: ω_e gives T_c1 + T_c2, ω_o gives g1 T_c1 + g2 T_c2 − T_o, the
//! twist ω_o − ω_w gives T_s' and with it the level of T_o, ω_w gives T_o − T_v; so all seven states for
//! g1 ≠ g2. What the model does not say is not covered: T_e and J_e errors go straight into T_c.

use crate::Params;
use crate::observer::filter::{Flow, Rows, row};
use crate::observer::speeds::Speeds;
use crate::observer::tracker::{SHARED, START, T_C, Tracker, W_W};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, brake};
use nalgebra::{SVector, Vector4};

const N: usize = SHARED;
type Vector = SVector<f64, N>;

/// What the filter believes of its noises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// q_T: intensity of T_c1 and T_c2 [(N·m)²/s].
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
        q_t: 750.0,
        q_v: 550.0,
        q_w: 1e-6,
        q_s: 450.0,
        sigma: 0.1,
    };

    /// Intensities of the states, shape (7).
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
    /// The discrete model and what it was made for: derived, not part of the state.
    cache: Option<(Speeds, f64, Discrete)>,
}

/// The rows of Φ that move, and the effect of T_e, T_b and T_y, over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Discrete {
    rows: Rows<N>,
    gamma_e: Vector4<f64>,
    gamma_b: Vector4<f64>,
    gamma_y: Vector4<f64>,
}

impl Discrete {
    fn new(model: &Speeds, h: f64) -> Self {
        let (flow, b) = (Flow::new(model, h), model.b());
        let mut by = Rows::<N>::zeros();
        by.fixed_columns_mut::<3>(T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        Self {
            rows: flow.rows(&by),
            gamma_e: flow.gamma * b.column(0),
            gamma_b: flow.gamma * b.column(3),
            gamma_y: flow.gamma * b.column(4),
        }
    }
}

impl Observer for Kalman {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self {
            tracker: Tracker::new(settings, Vector::zeros(), Vector::from(START)),
            cache: None,
        };
        if !sample.is_finite() {
            return self.tracker.refuse();
        }
        self.tracker.start(p, sample, &wheel());
        self.tracker.estimate(p, settings, sample, p.c_o)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !(sample.is_finite() && h.is_finite() && h > 0.0) {
            return self.tracker.refuse();
        }
        self.tracker.follow(p, sample, &wheel(), h);
        let standing = self.tracker.held(p, sample, p.c_o);
        self.predict(standing.as_ref().unwrap_or(p), settings, sample, h);
        let sigma = settings.kalman.sigma;
        self.tracker.correct(p, sample, sigma, &wheel(), h);
        self.tracker.watch(p, settings, sample, h);
        self.tracker.estimate(p, settings, sample, p.c_o)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.tracker.visit(visit);
    }
}

impl Kalman {
    fn predict(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) {
        let model = Speeds::new(p, sample.gear);
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
        let belief = &mut self.tracker.belief;
        let known = gamma_e * sample.t_e + gamma_b * brake(p, sample) + gamma_y * sample.t_y;
        let moved = rows * belief.x + known;
        belief.x.fixed_rows_mut::<4>(0).copy_from(&moved);
        belief.spread(&rows, &(settings.kalman.intensities() * h));
    }
}

/// What the wheel sensor shows of the states.
fn wheel() -> Vector {
    row(&[(W_W, 1.0)])
}
