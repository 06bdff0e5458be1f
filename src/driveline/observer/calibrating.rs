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
use crate::observer::filter::{Flow, Rows, row};
use crate::observer::speeds::Speeds;
use crate::observer::tracker::{SHARED, START, T_C, T_S, T_V, Tracker, W_E, W_O, W_W};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, brake};
use nalgebra::{SVector, Vector4};

const N: usize = SHARED + PARAMETERS;
type Vector = SVector<f64, N>;

const ALPHA: usize = SHARED;
const BETA: usize = 8;
const DELTA: usize = 9;
const BIAS: usize = 10;
const KAPPA: usize = 11;
const GAMMA: usize = 12;
const LAMBDA: usize = 13;

/// Number of parameters learnt: α, β, δ, w, κ, γ, λ.
pub const PARAMETERS: usize = 7;
/// Largest |α|, |β|, |δ|, |w|, |κ|, |γ|, |λ| that a vehicle can have.
const LARGEST: [f64; PARAMETERS] = [0.5, 30.0, 0.7, 0.5, 0.5, 0.7, 0.7];

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

    /// Intensities of the states, shape (14); an anchor does not walk.
    fn intensities(&self) -> Vector {
        let [q_t, q_v, q_w, q_s] = self.q;
        let mut all = Vector::zeros();
        let motion = [q_w, q_w, q_w, q_s, q_t, q_t, q_v];
        all.fixed_rows_mut::<SHARED>(0).copy_from_slice(&motion);
        for k in (0..PARAMETERS).filter(|k| self.sigma[*k] > 0.0) {
            all[ALPHA + k] = self.walk[k];
        }
        all
    }
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
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibrating {
    /// The filter and what watches it.
    pub tracker: Tracker<N>,
}

impl Observer for Calibrating {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let mut sigma = Vector::zeros();
        sigma.fixed_rows_mut::<SHARED>(0).copy_from_slice(&START);
        sigma
            .fixed_rows_mut::<PARAMETERS>(ALPHA)
            .copy_from_slice(&settings.calibrating.sigma);
        self.tracker = Tracker::new(settings, Vector::zeros(), sigma);
        if !sample.is_finite() {
            return self.refuse();
        }
        self.tracker.start(p, sample, &wheel());
        self.estimate(p, settings, sample)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !(sample.is_finite() && h.is_finite() && h > 0.0) {
            return self.refuse();
        }
        self.tracker.follow(p, sample, &wheel(), h);
        self.predict(p, settings, sample, h);
        let sensor = settings.calibrating.sensor;
        self.tracker.correct(p, sample, sensor, &wheel());
        let bounded = self.project();
        let monitor = &mut self.tracker.monitor;
        monitor.saturated = if bounded { monitor.saturated + h } else { 0.0 };
        self.tracker.watch(p, settings, sample, h);
        self.estimate(p, settings, sample)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.tracker.visit(visit);
    }
}

impl Calibrating {
    /// The model with what was learnt.
    fn model(&self, p: &Params, sample: &Sample) -> Speeds {
        let (nominal, x) = (Speeds::new(p, sample.gear), &self.tracker.belief.x);
        Speeds {
            j_ed: nominal.j_ed * (1.0 + x[DELTA]),
            j_out: nominal.j_out * (1.0 + x[LAMBDA]),
            k: nominal.k * (1.0 + x[KAPPA]),
            c: nominal.c * (1.0 + x[GAMMA]),
            ..nominal
        }
    }

    /// The slope of the states that move, shape (4).
    fn slope(&self, model: &Speeds, p: &Params, sample: &Sample) -> Vector4<f64> {
        let x = &self.tracker.belief.x;
        let torque = (1.0 + x[ALPHA]) * sample.t_e + x[BETA];
        let load = x[T_V] + brake(p, sample);
        let torques = Vector4::new(torque, x[T_C], x[T_C + 1], load);
        model.a(None) * x.fixed_rows::<4>(0) + model.b(None) * torques
    }

    /// How all other states change the slope, shape (4, 14), of which the last 10 columns count.
    ///
    /// `slope` and `twist` ω_o − ω_w: their means over the step, which makes Φ exact to h³.
    fn effects(&self, model: &Speeds, t_e: f64, slope: &Vector4<f64>, twist: f64) -> Rows<N> {
        let (x, b) = (&self.tracker.belief.x, model.b(None));
        let mut by = Rows::<N>::zeros();
        by.fixed_columns_mut::<3>(T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        by.set_column(ALPHA, &(b.column(0) * t_e));
        by.set_column(BETA, &b.column(0));
        by[(W_E, DELTA)] = -slope[W_E] / (1.0 + x[DELTA]);
        by[(W_O, LAMBDA)] = -slope[W_O] / (1.0 + x[LAMBDA]);
        by[(T_S, KAPPA)] = slope[T_S] / (1.0 + x[KAPPA]);
        let damping = model.c * twist / (1.0 + x[GAMMA]);
        by[(W_O, GAMMA)] = -damping / model.j_out;
        by[(W_W, GAMMA)] = damping / model.j_v;
        by
    }

    /// x̂⁺ of the states that move, with the parameters held, and the rows of Φ, shape (4, 14).
    fn motion(&self, p: &Params, sample: &Sample, h: f64) -> (Vector4<f64>, Rows<N>) {
        let (model, x) = (self.model(p, sample), &self.tracker.belief.x);
        let flow = Flow::new(&model, h);
        let change = flow.gamma * self.slope(&model, p, sample);
        let moved = x.fixed_rows::<4>(0) + change;
        let twist = 0.5 * (x[W_O] - x[W_W] + moved[W_O] - moved[W_W]);
        let by = self.effects(&model, sample.t_e, &(change / h), twist);
        (moved, flow.rows(&by))
    }

    fn predict(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) {
        let (moved, rows) = self.motion(p, sample, h);
        let belief = &mut self.tracker.belief;
        belief.x.fixed_rows_mut::<4>(0).copy_from(&moved);
        belief.spread(&rows, &(settings.calibrating.intensities() * h));
    }

    /// Keeps the parameters within what a vehicle can have; tells whether that was needed.
    fn project(&mut self) -> bool {
        let mut bounded = false;
        for (k, largest) in LARGEST.into_iter().enumerate() {
            let x = &mut self.tracker.belief.x[ALPHA + k];
            let free = *x;
            *x = free.clamp(-largest, largest);
            bounded |= *x != free;
        }
        bounded
    }

    /// What was learnt, with deviations.
    fn calibration(&self) -> Calibration {
        let (index, belief): ([usize; PARAMETERS], _) =
            (core::array::from_fn(|k| ALPHA + k), &self.tracker.belief);
        Calibration {
            value: index.map(|j| belief.x[j]),
            deviation: index.map(|j| belief.deviation(&row(&[(j, 1.0)]))),
        }
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            calibration: self.calibration(),
            ..self.tracker.refuse()
        }
    }

    fn estimate(&self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let c = self.model(p, sample).c;
        Estimate {
            calibration: self.calibration(),
            ..self.tracker.estimate(p, settings, sample, c)
        }
    }
}

/// What the wheel sensor shows of the states.
fn wheel() -> Vector {
    row(&[(W_W, 1.0), (BIAS, 1.0)])
}

#[cfg(test)]
mod tests {
    use super::{Calibrating, N, Vector};
    use crate::Params;
    use crate::observer::{Observer, Sample, Settings};
    use nalgebra::Vector4;

    /// Central differences of the motion itself against the rows of Φ, in every state; the rows leave out h³.
    #[test]
    fn rows_of_phi_are_the_derivative_of_the_motion() {
        const STEP: f64 = 1e-4;
        let units = Vector4::new(1.0, 1.0, 1.0, 500.0);
        let (p, settings) = (Params::TABLE_1, Settings::CASE_1);
        let sample = Sample {
            t_e: 60.0,
            omega_e: 180.0,
            omega_c: [170.0, 110.0],
            omega_w: 9.3,
            gear: [1, 2],
            t_brake: 40.0,
            ..Sample::default()
        };
        let mut observer = Calibrating::default();
        observer.start(&p, &settings, &sample);
        observer.tracker.belief.x = Vector::from([
            181.0, 9.5, 9.3, 700.0, 42.0, -11.0, 260.0, 0.04, 1.5, -0.1, 0.01, 0.07, -0.15, 0.1,
        ]);
        for (h, tolerance) in [(1e-3, 1e-4), (1e-2, 1e-2)] {
            let rows = observer.motion(&p, &sample, h).1;
            for j in 0..N {
                let [up, down] = [STEP, -STEP].map(|step| {
                    let mut moved = observer;
                    moved.tracker.belief.x[j] += step;
                    moved.motion(&p, &sample, h).0
                });
                let slope = (up - down) / (2.0 * STEP);
                let in_units = |column: Vector4<f64>| column.component_div(&units);
                let (truth, ours) = (in_units(slope), in_units(rows.column(j).into_owned()));
                let error = (truth - ours).amax() / truth.amax().max(h);
                assert!(error < tolerance, "h = {h} s, state {j}: {truth} {ours}");
            }
        }
    }
}
