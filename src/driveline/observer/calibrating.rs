//! Method `calibrating`: a Kalman filter that also learns what is wrong with its own parameters.
//!
//! Errors of T_e and J_e go straight into T_c of every other method. Here they are states:
//!
//! ```text
//! x = (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v, α, β, δ, w, κ, γ, λ)
//! J_ed (1+δ) ω_e' = (1+α) T_e + β − T_c1 − T_c2             α [1], β [N·m]: engine torque; δ [1]: inertia
//! J_out (1+λ) ω_o' = g1 T_c1 + g2 T_c2 − T_o                λ [1]: gearbox inertia
//! J_v ω_w' = T_o − T_v − T_b                                T_v free: needs no load model
//! T_o = T_s + c (1+γ) (ω_o − ω_w),  T_s' = k (1+κ) (ω_o − ω_w)       κ, γ [1]: drive shaft
//! y = (ω_e, ω_c1, ω_c2, ω_w + w)                            w [rad/s]: bias of the wheel speed
//! ```
//!
//! An extended filter: the factors of α, δ, λ, κ, γ are the filter's own accelerations and twists, not
//! differentiated measurements, whose noise would bias what is learnt. T_s has little noise, so the twist of
//! the drive shaft is what torques are measured against. Parameters walk slowly; projection keeps them
//! within what a vehicle can have.
//!
//! **What can be told apart, phase by phase.** One clutch engaged, the other open: T_c is known twice, from
//! the shaft (J_out ω_o' + T_o = g T_c) and from the engine (J_ed (1+δ) ω_e' = (1+α) T_e + β − T_c); their
//! difference α T_e + β − δ J_ed ω_e' is seen. A steady drive shows one sum of α T_e and β; another torque level
//! parts α from β; acceleration, as in tip-in, parts δ from both. Clutches open: J_ed (1+δ) ω_e' = (1+α) T_e + β,
//! so δ against α. Slipping: the same difference, as the shaft gives T_c. Handover: only the sum of both torques
//! and the sum at the output are seen, so T_c1, T_c2 rest on what was learnt before. w: a twist rate that lasts
//! though T_s does not grow. κ, γ, λ: while the shaft swings after an engagement.
//!
//! **What cannot.** All equations are homogeneous: one common factor on torques, inertias, k and c changes no
//! speed. Something must be trusted, by a small deviation at the start ([`Gains`]): a parameter whose
//! deviation is 0 is an anchor and stays.
//!
//! **Proof: none.** The filter is linearised about its estimate; it is tested, not proven.

use crate::Params;
use crate::observer::filter::Belief;
use crate::observer::friction::Friction;
use crate::observer::lock::Lock;
use crate::observer::monitor::Monitor;
use crate::observer::phase::pressed;
use crate::observer::speeds::{Speeds, output_speed};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, brake, common_estimate};
use crate::reduced::exponential;
use nalgebra::{SMatrix, SVector};

const N: usize = 14;
type Vector = SVector<f64, N>;
type Square = SMatrix<f64, N, N>;

const W_E: usize = 0;
const W_O: usize = 1;
const W_W: usize = 2;
const T_S: usize = 3;
const T_C: usize = 4;
const T_V: usize = 6;
const ALPHA: usize = 7;
const BETA: usize = 8;
const DELTA: usize = 9;
const BIAS: usize = 10;
const KAPPA: usize = 11;
const GAMMA: usize = 12;
const LAMBDA: usize = 13;

/// Number of parameters learnt: α, β, δ, w, κ, γ, λ.
pub const PARAMETERS: usize = 7;
/// Deviation of the zero that an open clutch measures [N·m].
const OPEN: f64 = 0.1;
/// Deviations of speeds [rad/s] and torques [N·m] at the start.
const START: [f64; ALPHA] = [0.5, 0.5, 0.5, 100.0, 20.0, 20.0, 200.0];
/// Largest |α|, |β|, |δ|, |w|, |κ|, |γ|, |λ| that a vehicle can have.
const LARGEST: [f64; PARAMETERS] = [0.5, 30.0, 0.7, 0.5, 0.5, 0.7, 0.7];
/// Smallest lever that tells a friction [N·m].
const LEVER: f64 = 1.0;

/// What the filter believes of its noises and of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// q_T, q_v, q_w, q_s: intensities of T_c, T_v [(N·m)²/s], speeds [(rad/s)²/s], T_s [(N·m)²/s].
    pub q: [f64; 4],
    /// Intensities of α, β, δ, w, κ, γ, λ per second, shape (7), where their deviation is not 0.
    pub walk: [f64; PARAMETERS],
    /// Standard deviations of α [1], β [N·m], δ [1], w [rad/s], κ, γ, λ [1] at the start, shape (7).
    ///
    /// 0 makes an anchor: the parameter is trusted and stays.
    pub sigma: [f64; PARAMETERS],
    /// Standard deviation of a measured speed [rad/s].
    pub sensor: f64,
}

impl Gains {
    /// Per second, so for every step.
    pub const DEFAULT: Self = Self {
        q: [750.0, 3000.0, 1e-6, 0.5],
        walk: [1e-8, 1e-5, 1e-7, 1e-9, 1e-8, 1e-8, 1e-8],
        sigma: [0.06, 3.0, 0.3, 0.02, 0.0, 0.0, 0.0],
        sensor: 0.1,
    };
}

/// What was learnt of the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibration {
    /// α [1], β [N·m], δ [1], w [rad/s], κ, γ, λ [1], shape (7).
    pub value: [f64; PARAMETERS],
    /// Their standard deviations, shape (7).
    pub deviation: [f64; PARAMETERS],
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibrating {
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
}

impl Default for Calibrating {
    fn default() -> Self {
        Self {
            belief: Belief::new(Vector::zeros(), Vector::zeros()),
            innovation: [0.0; 3],
            lock: Lock::default(),
            friction: Friction::nominal([0.0; 2]),
            monitor: Monitor::default(),
            g: [0.0; 2],
        }
    }
}

impl Observer for Calibrating {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let mut sigma = Vector::zeros();
        sigma.fixed_rows_mut::<ALPHA>(0).copy_from_slice(&START);
        let learnt = &settings.calibrating.sigma;
        sigma
            .fixed_rows_mut::<PARAMETERS>(ALPHA)
            .copy_from_slice(learnt);
        *self = Self {
            belief: Belief::new(Vector::zeros(), sigma),
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
        let bounded = self.project();
        self.monitor.saturated = if bounded {
            self.monitor.saturated + h
        } else {
            0.0
        };
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

impl Calibrating {
    /// Speeds from measurements: at the start, and when a gear comes in. What was learnt of the parameters
    /// goes on; speeds and torques are as uncertain as at the start.
    fn take_speeds(&mut self, p: &Params, sample: &Sample) {
        self.g = p.g(sample.gear);
        let omega_w = sample.omega_w - self.belief.x[BIAS];
        let speeds = [sample.omega_e, output_speed(self.g, sample), omega_w];
        self.belief
            .x
            .fixed_rows_mut::<3>(0)
            .copy_from_slice(&speeds);
        for (j, sigma) in START.into_iter().enumerate() {
            self.belief.p.row_mut(j).fill(0.0);
            self.belief.p.column_mut(j).fill(0.0);
            self.belief.p[(j, j)] = sigma * sigma;
        }
    }

    /// The model with what was learnt.
    fn model(&self, p: &Params, sample: &Sample) -> Speeds {
        let (nominal, x) = (Speeds::new(p, sample.gear), &self.belief.x);
        Speeds {
            j_ed: nominal.j_ed * (1.0 + x[DELTA]),
            j_out: nominal.j_out * (1.0 + x[LAMBDA]),
            k: nominal.k * (1.0 + x[KAPPA]),
            c: nominal.c * (1.0 + x[GAMMA]),
            ..nominal
        }
    }

    /// The derivative of the motion by all states, shape (4, 14), and by a constant: T_e and T_b [SI].
    fn jacobian(&self, p: &Params, sample: &Sample) -> (SMatrix<f64, 4, N>, SVector<f64, 4>) {
        let (model, x) = (self.model(p, sample), &self.belief.x);
        let (a, b) = (model.a(None), model.b(None));
        let mut f = SMatrix::<f64, 4, N>::zeros();
        f.fixed_view_mut::<4, 4>(0, 0).copy_from(&a);
        f.fixed_view_mut::<4, 3>(0, T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        let constant = b.column(0) * sample.t_e + b.column(3) * brake(p, sample);
        let x_dot = f * x + constant + b.column(0) * (x[ALPHA] * sample.t_e + x[BETA]);
        f.set_column(ALPHA, &(b.column(0) * sample.t_e));
        f.set_column(BETA, &b.column(0));
        f[(W_E, DELTA)] = -x_dot[W_E] / (1.0 + x[DELTA]);
        f[(W_O, LAMBDA)] = -x_dot[W_O] / (1.0 + x[LAMBDA]);
        f[(T_S, KAPPA)] = x_dot[T_S] / (1.0 + x[KAPPA]);
        let damping = p.c_o * (x[W_O] - x[W_W]);
        f[(W_O, GAMMA)] = -damping / model.j_out;
        f[(W_W, GAMMA)] = damping / model.j_v;
        (f, constant)
    }

    /// x̂⁺ with the parameters held, exactly; P⁺ with the motion linearised about x̂.
    fn predict(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) {
        let (f, constant) = self.jacobian(p, sample);
        let mut m = SMatrix::<f64, { N + 1 }, { N + 1 }>::zeros();
        m.fixed_view_mut::<4, N>(0, 0).copy_from(&f);
        m.fixed_view_mut::<4, 1>(0, N).copy_from(&constant);
        let psi = exponential(&(m * h));
        let phi = psi.fixed_view::<N, N>(0, 0).into_owned();
        let mut held = self.belief.x;
        for j in [DELTA, KAPPA, GAMMA, LAMBDA] {
            held[j] = 0.0; // they are in the matrices already
        }
        let learnt = self.belief.x;
        self.belief.x = phi * held + psi.fixed_view::<N, 1>(0, N);
        for j in [DELTA, KAPPA, GAMMA, LAMBDA] {
            self.belief.x[j] = learnt[j];
        }
        let noise = noise(settings) * (0.5 * h);
        self.belief.p += noise;
        self.belief.spread(&phi, &noise);
    }

    fn correct(&mut self, p: &Params, settings: &Settings, sample: &Sample) {
        let (g, sensor) = (p.g(sample.gear), settings.calibrating.sensor);
        let (r, before) = (sensor * sensor, self.belief.x);
        self.innovation = [
            sample.omega_e - before[W_E],
            output_speed(g, sample) - before[W_O],
            sample.omega_w - before[W_W] - before[BIAS],
        ];
        self.measure(&[(W_E, 1.0)], sample.omega_e, r);
        for i in (0..2).filter(|i| g[*i] != 0.0) {
            self.measure(&[(W_O, g[i])], sample.omega_c[i], r);
        }
        self.measure(&[(W_W, 1.0), (BIAS, 1.0)], sample.omega_w, r);
        for (i, pressed) in pressed(p, sample).into_iter().enumerate() {
            if !pressed {
                self.measure(&[(T_C + i, 1.0)], 0.0, OPEN * OPEN);
            }
        }
    }

    /// Corrects by a measurement `z` of a sum of states with factors, with variance `r`.
    fn measure(&mut self, terms: &[(usize, f64)], z: f64, r: f64) {
        let h = row(terms);
        self.belief.correct(&h, z - h.dot(&self.belief.x), r);
    }

    /// Keeps the parameters within what a vehicle can have; tells whether that was needed.
    fn project(&mut self) -> bool {
        let mut bounded = false;
        for (k, largest) in LARGEST.into_iter().enumerate() {
            let free = self.belief.x[ALPHA + k];
            self.belief.x[ALPHA + k] = free.clamp(-largest, largest);
            bounded |= self.belief.x[ALPHA + k] != free;
        }
        bounded
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

    /// What was learnt, with deviations.
    fn calibration(&self) -> Calibration {
        let index: [usize; PARAMETERS] = core::array::from_fn(|k| ALPHA + k);
        Calibration {
            value: index.map(|j| self.belief.x[j]),
            deviation: index.map(|j| self.belief.deviation(&row(&[(j, 1.0)]))),
        }
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.belief.x[T_S],
            friction: self.friction.mu,
            engaged: self.lock.engaged(),
            calibration: self.calibration(),
            ..Estimate::refused()
        }
    }

    fn estimate(&self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let (x, c) = (&self.belief.x, self.model(p, sample).c);
        let t_o = row(&[(T_S, 1.0), (W_O, c), (W_W, -c)]);
        let (engaged, fault) = (self.lock.engaged(), self.monitor.fault());
        let common = common_estimate(p, settings, sample, engaged, fault);
        let said = Estimate {
            t_c: [x[T_C], x[T_C + 1]],
            t_o: t_o.dot(x),
            t_v: x[T_V] + brake(p, sample),
            t_c_deviation: [0, 1].map(|i| self.belief.deviation(&row(&[(T_C + i, 1.0)]))),
            t_o_deviation: self.belief.deviation(&t_o),
            friction: self.friction.mu,
            innovation: self.innovation_x(p, sample),
            calibration: self.calibration(),
            ..common
        };
        said.with_friction_terms(p, settings, sample)
    }
}

/// A row of zeros with these entries.
fn row(terms: &[(usize, f64)]) -> Vector {
    let mut row = Vector::zeros();
    for (j, factor) in terms {
        row[*j] = *factor;
    }
    row
}

/// Intensities per second, shape (14, 14); an anchor does not walk.
fn noise(settings: &Settings) -> Square {
    let Gains { q, walk, sigma, .. } = settings.calibrating;
    let [q_t, q_v, q_w, q_s] = q;
    let mut all = Vector::zeros();
    let motion = [q_w, q_w, q_w, q_s, q_t, q_t, q_v];
    all.fixed_rows_mut::<ALPHA>(0).copy_from_slice(&motion);
    for k in (0..PARAMETERS).filter(|k| sigma[*k] > 0.0) {
        all[ALPHA + k] = walk[k];
    }
    Square::from_diagonal(&all)
}
