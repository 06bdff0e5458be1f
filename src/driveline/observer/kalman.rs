//! Method `kalman`: a Kalman filter whose torques are random walks, the competitor [26], [27] of the paper.
//!
//! ```text
//! x = (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v)
//! J_ed ω_e' = T_e − T_c1 − T_c2      J_out ω_o' = g1 T_c1 + g2 T_c2 − T_o      J_v ω_w' = T_o − T_v − T_b
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
use crate::observer::filter::{Belief, discretise};
use crate::observer::friction::Friction;
use crate::observer::lock::Lock;
use crate::observer::monitor::Monitor;
use crate::observer::phase::pressed;
use crate::observer::speeds::{Speeds, output_speed};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, brake, common_estimate};
use nalgebra::{SMatrix, SVector};

const N: usize = 7;
/// With T_e as a state that stands.
const AUGMENTED: usize = 8;
type Vector = SVector<f64, N>;

const W_E: usize = 0;
const W_O: usize = 1;
const W_W: usize = 2;
const T_S: usize = 3;
const T_C: usize = 4;
const T_V: usize = 6;

/// Deviation of the zero that an open clutch measures [N·m].
const OPEN: f64 = 0.1;
/// Deviations at the start: speeds [rad/s], T_s, T_c1, T_c2, T_v [N·m].
const START: [f64; N] = [0.5, 0.5, 0.5, 100.0, 20.0, 20.0, 200.0];
/// Smallest μ̂ lever that tells a friction [N·m].
const LEVER: f64 = 1.0;

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
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kalman {
    /// x̂ and P.
    pub belief: Belief<N>,
    /// Innovations of ω_e, ω_o, ω_w at the last instant [rad/s], shape (3).
    pub innovation: [f64; 3],
    /// Engaged clutches.
    pub lock: Lock,
    /// Friction learnt while slipping.
    pub friction: Friction,
    /// What tells that the inputs make no sense.
    pub monitor: Monitor,
    /// g of the last sample.
    pub g: [f64; 2],
    /// The discrete model and what it was made for: derived, not part of the state.
    cache: Option<(Key, Discrete)>,
}

/// What the discrete model depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    model: Speeds,
    gains: Gains,
    h: f64,
}

/// x⁺ = Φ x + Γ_e T_e + Γ_v T_b, with noise Q.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Discrete {
    phi: SMatrix<f64, N, N>,
    q: SMatrix<f64, N, N>,
    gamma_e: Vector,
}

impl Discrete {
    fn new(key: &Key) -> Self {
        let Gains {
            q_t, q_v, q_w, q_s, ..
        } = key.gains;
        let (a, b) = (key.model.a(None), key.model.b(None));
        let mut m = SMatrix::<f64, AUGMENTED, AUGMENTED>::zeros();
        m.fixed_view_mut::<4, 4>(0, 0).copy_from(&a);
        m.fixed_view_mut::<4, 3>(0, T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        m.fixed_view_mut::<4, 1>(0, N).copy_from(&b.column(0));
        let q_c = SVector::<f64, AUGMENTED>::from([q_w, q_w, q_w, q_s, q_t, q_t, q_v, 0.0]);
        let (psi, q) = discretise(&m, &q_c, key.h);
        Self {
            phi: psi.fixed_view::<N, N>(0, 0).into_owned(),
            q: q.fixed_view::<N, N>(0, 0).into_owned(),
            gamma_e: psi.fixed_view::<N, 1>(0, N).into_owned(),
        }
    }
}

impl Default for Kalman {
    fn default() -> Self {
        Self {
            belief: Belief::new(Vector::zeros(), Vector::from(START)),
            innovation: [0.0; 3],
            lock: Lock::default(),
            friction: Friction::nominal([0.0; 2]),
            monitor: Monitor::default(),
            g: [0.0; 2],
            cache: None,
        }
    }
}

impl Observer for Kalman {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self {
            friction: Friction::nominal(settings.mu_n),
            ..Self::default()
        };
        if !sample.is_finite() {
            return self.refuse();
        }
        self.belief.x[T_V] = p.road.load_torque(sample.omega_w, sample.phi);
        self.take_speeds(p, sample);
        self.lock.step(p, sample, 0.0);
        self.monitor.start(p, sample);
        self.estimate(p, settings, sample)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !(sample.is_finite() && h.is_finite() && h > 0.0) {
            return self.refuse();
        }
        if self.g != p.g(sample.gear) {
            self.take_speeds(p, sample);
        }
        self.lock.step(p, sample, h);
        self.predict(p, settings, sample, h);
        self.correct(p, settings, sample);
        if settings.adapts {
            self.friction.learn(p, sample, self.mu_hat(p, sample), h);
        }
        let e = self.innovation_x(p, sample);
        self.monitor.step(p, sample, self.lock.engaged(), e, h);
        self.estimate(p, settings, sample)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.belief.x.iter_mut().for_each(&mut *visit);
        self.belief.p.iter_mut().for_each(&mut *visit);
        self.innovation.iter_mut().for_each(&mut *visit);
        self.lock.since.iter_mut().for_each(&mut *visit);
        self.friction.visit(visit);
        self.monitor.visit(visit);
        self.g.iter_mut().for_each(&mut *visit);
    }
}

impl Kalman {
    /// Speeds from measurements: at the start, and when a gear comes in. The torques go on, their
    /// deviation as at the start.
    fn take_speeds(&mut self, p: &Params, sample: &Sample) {
        self.g = p.g(sample.gear);
        let speeds = [sample.omega_e, output_speed(self.g, sample), sample.omega_w];
        self.belief
            .x
            .fixed_rows_mut::<3>(0)
            .copy_from_slice(&speeds);
        self.belief = Belief::new(self.belief.x, Vector::from(START));
    }

    fn predict(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) {
        let key = Key {
            model: Speeds::new(p, sample.gear),
            gains: settings.kalman,
            h,
        };
        let discrete = match self.cache {
            Some((made_for, discrete)) if made_for == key => discrete,
            _ => Discrete::new(&key),
        };
        self.cache = Some((key, discrete));
        let mut x = self.belief.x;
        x[T_V] += brake(p, sample);
        let load = self.belief.x[T_V];
        self.belief.x = discrete.phi * x + discrete.gamma_e * sample.t_e;
        self.belief.x[T_V] = load;
        self.belief.spread(&discrete.phi, &discrete.q);
    }

    fn correct(&mut self, p: &Params, settings: &Settings, sample: &Sample) {
        let (g, r) = (
            p.g(sample.gear),
            settings.kalman.sigma * settings.kalman.sigma,
        );
        let before = self.belief.x;
        self.innovation = [
            sample.omega_e - before[W_E],
            output_speed(g, sample) - before[W_O],
            sample.omega_w - before[W_W],
        ];
        self.measure(W_E, 1.0, sample.omega_e, r);
        for i in (0..2).filter(|i| g[*i] != 0.0) {
            self.measure(W_O, g[i], sample.omega_c[i], r);
        }
        self.measure(W_W, 1.0, sample.omega_w, r);
        for (i, pressed) in pressed(p, sample).into_iter().enumerate() {
            if !pressed {
                self.measure(T_C + i, 1.0, 0.0, OPEN * OPEN);
            }
        }
    }

    /// Corrects by a measurement `z` of `factor` times state `j`, with variance `r`.
    fn measure(&mut self, j: usize, factor: f64, z: f64, r: f64) {
        let mut h = Vector::zeros();
        h[j] = factor;
        self.belief.correct(&h, z - factor * self.belief.x[j], r);
    }

    /// μ̂ with the sign of the torque [1], shape (2).
    fn mu_hat(&self, p: &Params, sample: &Sample) -> [f64; 2] {
        [0, 1].map(|i| {
            let lever = p.clutch[i].force(sample.actuation[i]) * p.clutch[i].r_c_n;
            self.belief.x[T_C + i] / lever.max(LEVER)
        })
    }

    /// Innovation in the terms of (12), shape (2).
    fn innovation_x(&self, p: &Params, sample: &Sample) -> [f64; 2] {
        let [e, o, w] = self.innovation;
        [e - p.g(sample.gear)[1] * o, o - w]
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.belief.x[T_S],
            friction: self.friction.mu,
            engaged: self.lock.engaged(),
            ..Estimate::refused()
        }
    }

    fn estimate(&self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let (x, unit) = (&self.belief.x, |j: usize| {
            let mut h = Vector::zeros();
            h[j] = 1.0;
            h
        });
        let mut t_o = unit(T_S);
        (t_o[W_O], t_o[W_W]) = (p.c_o, -p.c_o);
        let (engaged, fault) = (self.lock.engaged(), self.monitor.fault());
        let common = common_estimate(p, settings, sample, engaged, fault);
        let said = Estimate {
            t_c: [x[T_C], x[T_C + 1]],
            t_o: t_o.dot(x),
            t_v: x[T_V] + brake(p, sample),
            t_c_deviation: [0, 1].map(|i| self.belief.deviation(&unit(T_C + i))),
            t_o_deviation: self.belief.deviation(&t_o),
            friction: self.friction.mu,
            innovation: self.innovation_x(p, sample),
            ..common
        };
        said.with_friction_terms(p, settings, sample)
    }
}
