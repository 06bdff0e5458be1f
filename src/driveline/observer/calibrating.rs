//! Method `calibrating`: a Kalman filter that also learns what is wrong with its own parameters.
//!
//! Errors of T_e and J_e go straight into T_c of every other method. Here they are states, with those of the
//! gearbox, the drive shaft, the vehicle and the wheel speed; calibrating_model.rs has the equations.
//!
//! ```text
//! sample ─> how each clutch carries its torque (grip) ─> predict ─> correct by speeds ────────────────┐
//! estimates <─ times the common factor (anchor) <─ parameters within what a vehicle can have <────────┘
//! ```
//!
//! An extended filter. The factors of δ and λ are the filter's own accelerations, not differentiated
//! measurements, whose noise would bias what is learnt; while a clutch slips they are smoothed as well. T_s has
//! little noise, so the twist of the drive shaft is what torques are measured against. A slipping clutch moves
//! with its force, an engaged one with the damper ([`grip`], carry.rs). Parameters walk slowly. How noisy the speeds are
//! is heard from the innovations ([`heard`]), how fast T_v walks is seen from T̂_v ([`walk`]); its rate is a state as well.
//!
//! **What can be told apart, phase by phase.** One clutch engaged, the other open: T_c is known twice, from
//! the shaft (J_out ω_o' + T_o = g T_c) and from the engine (J_ed (1+δ) ω_e' = T_e + β − T_c). A steady drive
//! shows one sum of the errors; another torque level parts a scale from β; acceleration, as in tip-in, parts δ
//! from both. Clutches open: J_ed (1+δ) ω_e' = T_e + β. Slipping: the same difference, as the shaft gives T_c.
//! Handover: only the sum of both torques and the sum at the output are seen, so T_c1, T_c2 rest on what was
//! learnt before. w: a twist rate that lasts though T_s does not grow. κ, γ, λ, ν: while the shaft is wound up or
//! swings. In numbers, what is left of a deviation after a phase with nothing known before it (the paper's
//! scenario at 1 kHz; a test computes it from the covariance, the inverse of the observability Gramian):
//!
//! ```text
//!                                       β      δ      w      κ      γ      λ      ν
//! clutches open, idle (1 s)            0.00   0.96   0.04   1.00   1.00   1.00   1.00
//! clutch 1 slips: launch               0.03   0.02   0.07   0.07   0.08   0.23   0.16
//! clutch 1 engages, the shaft swings   0.19   0.12   0.07   0.31   0.18   0.33   0.16
//! clutch 1 engaged: steady drive       0.94   0.32   0.02   0.95   0.98   0.25   0.25
//! handover                             0.18   0.04   0.14   0.43   0.32   0.35   0.17
//! clutch 1 engaged: tip-in             0.56   0.15   0.06   0.28   0.16   0.63   0.17
//! ```
//!
//! **What cannot.** All equations are homogeneous: one common factor on torques, inertias, k and c changes no
//! speed. A filter with such a direction among its states believes to see it as it moves its point of
//! linearisation, so here it is none: torques are in units of the reported T_e, and the factor is found apart,
//! by what each parameter is worth as a witness ([`anchor`]).
//!
//! **Proof: none.** The filter is linearised about its estimate; it is tested, not proven.
//!
//! [`grip`]: crate::observer::grip
//! [`anchor`]: crate::observer::anchor
//! [`heard`]: crate::observer::heard
//! [`walk`]: crate::observer::walk

use crate::Params;
use crate::observer::anchor::{Anchor, WITNESSES};
use crate::observer::calibrating_model::{
    ACTING, BETA, BIAS, DELTA, GAMMA, KAPPA, LAMBDA, LEARNT, N, NU, RATE, Vector, View, bound,
};
use crate::observer::calibration::{Calibration, PARAMETERS};
use crate::observer::filter::{Belief, Terms};
use crate::observer::friction::SETTLING;
use crate::observer::friction_map::{FrictionMap, POINTS};
use crate::observer::grip::{Grip, Hold};
use crate::observer::heard::Heard;
use crate::observer::instant::Instant;
use crate::observer::prior::{MASS, Prior};
use crate::observer::speeds::Speeds;
use crate::observer::standstill::unsure;
use crate::observer::tracker::{SHARED, START, T_C, T_V, Tracker, W_W};
use crate::observer::walk::{Seen, Walk};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit};
use core::ops::Range;
use nalgebra::{ComplexField, SMatrix, SVector};

/// J_ed, k_o, c_o, J_out, J_v: witnesses of the common factor.
const RATIOS: [usize; WITNESSES] = [DELTA, KAPPA, GAMMA, LAMBDA, NU];
/// Where these stand among the parameters told.
const TOLD: [usize; WITNESSES] = [2, 4, 5, 6, MASS];
/// Time constant of the accelerations that δ and λ are seen by while a clutch slips [s].
const SMOOTH: f64 = 0.03;
/// Speeds at which a vehicle begins to roll, over V_ε [1]: it stands no more, and tanh(V/V_ε) of (11) is not 1 yet.
const ROLLS: Range<f64> = 0.2..4.0;

/// What the filter believes of its noises and of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// q_T, q_v, q_w, q_s: intensities of the friction of a slipping clutch, relative [1/s], T_v, at most [(N·m)²/s],
    /// speeds [(rad/s)²/s], T_s [(N·m)²/s].
    pub q: [f64; 4],
    /// Intensities of β, δ, w, κ, γ, λ, ν per second, shape (7), where their deviation is not 0.
    pub walk: [f64; LEARNT],
    /// Standard deviations of α [1], β [N·m], δ [1], w [rad/s], κ, γ, λ, ν [1] at the start, shape (8).
    ///
    /// 0 makes an anchor: the parameter is trusted and stays.
    pub sigma: [f64; PARAMETERS],
    /// What an earlier drive learnt.
    pub prior: Prior,
    /// Standard deviation of a measured speed, at most [rad/s]; how much of it there is the filter hears.
    pub sensor: f64,
    /// Standard deviations of the friction over the position at the start [1], shape (2, 5).
    pub friction: [[f64; POINTS]; 2],
}

impl Gains {
    /// Per second, so for every step.
    pub const DEFAULT: Self = Self {
        q: [0.1, 2000.0, 1e-6, 0.5],
        walk: [1e-5, 1e-7, 1e-9, 1e-8, 1e-8, 1e-8, 1e-8],
        sigma: [0.06, 3.0, 0.3, 0.02, 0.1, 0.2, 0.1, 0.2],
        prior: Prior::NONE,
        sensor: 0.1,
        friction: [[0.3; POINTS]; 2],
    };

    /// Intensities of the states, shape (15); an anchor does not walk.
    fn intensities(&self) -> Vector {
        let [q_t, q_v, q_w, q_s] = self.q;
        let mut all = Vector::zeros();
        let motion = [q_w, q_w, q_w, q_s, q_t, q_t, q_v];
        all.fixed_rows_mut::<SHARED>(0).copy_from_slice(&motion);
        for k in (0..LEARNT).filter(|k| self.walks(*k)) {
            all[SHARED + k] = self.walk[k];
        }
        all
    }

    /// Whether parameter k, of β, δ, w, κ, γ, λ, ν, is uncertain at the start; a ratio to T_e is where either is.
    fn walks(&self, k: usize) -> bool {
        let own = self.sigma[1 + k];
        if RATIOS.contains(&(SHARED + k)) {
            return own.abs() + self.sigma[0].abs() > 0.0;
        }
        own > 0.0
    }

    /// Deviations of the states at the start, shape (15). A ratio to T_e is as uncertain as both.
    pub(super) fn start(&self) -> Vector {
        let mut sigma = Vector::zeros();
        sigma.fixed_rows_mut::<SHARED>(0).copy_from_slice(&START);
        sigma
            .fixed_rows_mut::<LEARNT>(SHARED)
            .copy_from_slice(&self.sigma[1..]);
        for j in RATIOS {
            sigma[j] = ComplexField::hypot(sigma[j], self.sigma[0]);
        }
        sigma
    }

    /// Covariance of the ratios at the start by what is common to them: T_e, that they are measured by.
    pub(super) fn correlate(&self, p: &mut SMatrix<f64, N, N>) {
        for (a, b) in RATIOS.into_iter().flat_map(|a| RATIOS.map(|b| (a, b))) {
            if a != b {
                p[(a, b)] = self.sigma[0] * self.sigma[0];
            }
        }
    }

    /// Deviations of T_e and of the witnesses, shape (6).
    fn trust(&self) -> [f64; WITNESSES + 1] {
        let s = self.sigma;
        [s[0], s[2], s[4], s[5], s[6], s[7]]
    }
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibrating {
    /// The filter and what watches it.
    pub tracker: Tracker<N>,
    /// The common factor.
    pub anchor: Anchor,
    /// How the clutches carry their torque.
    pub grip: Grip,
    /// Smoothed accelerations of ω_e, ω_o [rad/s²], shape (2).
    pub slope: [f64; 2],
    /// Friction over the position of each clutch.
    pub map: [FrictionMap; 2],
    /// The noise of the speeds.
    pub heard: Heard,
    /// How fast T_v walks.
    pub walk: Walk,
    /// What a start with a pressed clutch leaves to be found (begun.rs): time for which torques are, or,
    /// negative, for which the drive shaft may turn out to be wound up [s].
    pub finding: f64,
}

impl Observer for Calibrating {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        self.clear(settings);
        if !sample.is_finite() {
            return self.refuse(settings);
        }
        let (p, sample) = &self.known(p, settings, sample);
        let now = Instant::new(p, sample);
        self.begin(&now, settings);
        self.suspect(&now);
        self.estimate(&now, settings, &self.view(p, sample).model)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !sample.may_enter(h) {
            return self.refuse(settings);
        }
        let (p, sample) = &self.known(p, settings, sample);
        let now = Instant::new(p, sample);
        self.tracker.follow(&now, h);
        let hold = self
            .grip
            .step(&now, &self.tracker.lock, self.tracker.engaged);
        self.tracker.follow_force(hold);
        let standing = self
            .tracker
            .held(p, sample, || self.view(p, sample).model.c);
        let moving = standing.as_ref().unwrap_or(p);
        self.predict(moving, settings, sample, hold, h);
        let believed = settings.calibrating.sensor;
        let sensor = self.heard.sensor(settings, &now, h);
        self.tracker.correct(&now, sensor, believed, WHEEL, h);
        self.heard
            .listen(now.g, self.tracker.innovation, believed, h);
        self.tracker.remember(&now, hold, h);
        let bounded = bound(&mut self.tracker.belief.x);
        let monitor = &mut self.tracker.monitor;
        monitor.saturated = if bounded { monitor.saturated + h } else { 0.0 };
        self.find(&now, settings, h);
        self.vote(settings, h);
        let model = self.view(p, sample).model;
        self.tracker.watch(&now, settings, &model, h);
        if settings.adapts {
            self.learn_friction(p, sample, h);
        }
        self.estimate(&now, settings, &model)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        #[rustfmt::skip] // a list
        let Self { tracker, anchor, grip, slope, map, heard, walk, finding } = self;
        tracker.visit(visit);
        anchor.visit(visit);
        grip.visit(visit);
        slope.iter_mut().for_each(&mut *visit);
        map.iter_mut().for_each(|map| map.visit(visit));
        heard.visit(visit);
        walk.visit(visit);
        visit(finding);
    }
}

impl Calibrating {
    /// Nothing known but the deviations of the states.
    pub(super) fn clear(&mut self, settings: &Settings) {
        let (gains, mu_n) = (&settings.calibrating, settings.mu_n);
        *self = Self {
            tracker: Tracker::new(settings, Vector::zeros(), gains.start()),
            map: [0, 1].map(|i| FrictionMap::new(mu_n[i], gains.friction[i])),
            anchor: Anchor::new(gains.sigma[0]),
            heard: Heard::new(gains.sensor),
            ..Self::default()
        };
        gains.correlate(&mut self.tracker.belief.p);
    }

    /// What is known before a step: by an earlier drive, and of a wheel that may stand.
    fn known(&self, p: &Params, settings: &Settings, sample: &Sample) -> (Params, Sample) {
        let (mut p, sample) = settings.calibrating.prior.correct(p, sample);
        unsure(&mut p, self.tracker.belief.p[(W_W, W_W)]);
        (p, sample)
    }

    /// A sample seen with what is known.
    pub(super) fn view<'a>(&'a self, p: &'a Params, sample: &'a Sample) -> View<'a> {
        let Tracker {
            belief, engaged, ..
        } = &self.tracker;
        View::new(p, sample, &belief.x, *engaged, 1.0 / self.anchor.factor())
    }

    /// Intensities of T_v [(N·m)²/s] and of its rate [(N·m/s)²/s]; of counted speeds, whose noise is not white, none of a rate.
    ///
    /// `pull`: what accelerates the vehicle [N·m]. All of it while the vehicle begins to roll: no standstill shows its
    /// rolling resistance.
    fn pace(&mut self, p: &Params, settings: &Settings, pull: f64, h: f64) -> [f64; 2] {
        let gains = &settings.calibrating;
        let Belief { x, p: variance } = &self.tracker.belief;
        let v = p.road.r_w * x[W_W];
        let seen = Seen {
            t_v: x[T_V],
            t_a: pull,
            sigma_nu: ComplexField::sqrt(variance[(NU, NU)]),
        };
        let (quiet, [_, most, ..]) = (self.heard.quiet(gains.sensor), gains.q);
        let mut pace = self.walk.intensity(&seen, quiet, most, h);
        if ROLLS.contains(&(v.abs() / p.road.v_eps)) {
            pace = most;
        }
        Walk::shares(pace, quiet, settings.encoder != [0.0; 4])
    }

    /// x̂⁺ with the parameters held, exactly; P⁺ with the motion linearised about x̂.
    fn predict(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        hold: [Hold; 2],
        h: f64,
    ) {
        let (last, engaged) = (self.slope, hold.contains(&Hold::Engaged));
        let forget = if engaged { 0.0 } else { SMOOTH / (h + SMOOTH) };
        let smoothed = |now: [f64; 2]| [0, 1].map(|j| now[j] + (last[j] - now[j]) * forget);
        let view = self.view(p, sample);
        let (motion, model, t_e) = (view.motion(h, smoothed), view.model, view.engine_torque());
        let pull = view.pull();
        self.slope = smoothed(motion.slope);
        self.tracker.swing(p, &model, t_e, h);
        let gains = &settings.calibrating;
        let mut q = gains.intensities();
        [q[T_V], q[RATE]] = self.pace(p, settings, pull, h);
        self.tracker.noise(&model, hold, &mut q);
        let q = q * h;
        let belief = &mut self.tracker.belief;
        belief.x.fixed_rows_mut::<6>(0).copy_from(&motion.moved);
        Walk::roll(belief, [T_V, RATE], h);
        belief.spread(&motion.rows, &ACTING, &q);
    }

    /// Friction over the position, of a clutch that slips while the other one is open.
    fn learn_friction(&mut self, p: &Params, sample: &Sample, h: f64) {
        let (lever, slipping) = (self.grip.lever, self.tracker.friction.slipping);
        for i in (0..2).filter(|i| slipping[*i] >= SETTLING && lever[1 - i] <= 0.0) {
            let torque = self.tracker.t_c[i] * sample.slip()[i].signum();
            let deviation = self.tracker.belief.deviation(&[(T_C + i, 1.0)]) / lever[i];
            let theta = p.clutch[i].reached(sample.actuation[i]);
            let mu = torque / lever[i];
            self.map[i].learn(&p.clutch[i].map, theta, mu, deviation * deviation, h);
        }
    }

    /// The common factor by its witnesses.
    fn vote(&mut self, settings: &Settings, h: f64) {
        let belief = &self.tracker.belief;
        let ratio = SVector::from(RATIOS.map(|j| ComplexField::ln(1.0 + belief.x[j])));
        let p = SMatrix::from_fn(|a, b| belief.p[(RATIOS[a], RATIOS[b])]);
        self.anchor
            .step(&ratio, &p, settings.calibrating.trust(), h);
    }

    /// What was learnt, with deviations; `factor`: the common one.
    fn calibration(&self, factor: f64) -> Calibration {
        let Belief { x, p } = &self.tracker.belief;
        let mut said = Calibration::default();
        (said.value[0], said.deviation[0]) =
            (factor - 1.0, ComplexField::sqrt(self.anchor.variance));
        (said.value[1], said.deviation[1]) =
            (x[BETA] * factor, ComplexField::sqrt(p[(BETA, BETA)]));
        (said.value[3], said.deviation[3]) = (x[BIAS], ComplexField::sqrt(p[(BIAS, BIAS)]));
        for (k, j) in TOLD.into_iter().zip(RATIOS) {
            said.value[k] = (1.0 + x[j]) * factor - 1.0;
            said.deviation[k] = ComplexField::sqrt(p[(j, j)] + self.anchor.variance);
        }
        said.friction = self.map.map(|map| map.mu().map(|mu| mu * factor));
        said.friction_deviation = self.map.map(|map| map.deviation().map(|s| s * factor));
        said
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self, settings: &Settings) -> Estimate {
        let learnt = self.calibration(self.anchor.factor());
        Estimate {
            calibration: settings.calibrating.prior.with(&learnt),
            ..self.tracker.refuse()
        }
    }

    /// What is said after a step; `model`: the driveline with what was learnt.
    fn estimate(&self, now: &Instant<'_>, settings: &Settings, model: &Speeds) -> Estimate {
        let (prior, factor) = (&settings.calibrating.prior, self.anchor.factor());
        let resistance = now.p.road.load_torque(self.tracker.belief.x[W_W], 0.0);
        let own = self.tracker.estimate(now, settings, model);
        let uncertain = |torque: f64, deviation: f64| {
            ComplexField::sqrt(deviation * deviation + torque * torque * self.anchor.variance)
        };
        let said = Estimate {
            t_c: own.t_c.map(|torque| torque * factor),
            t_o: own.t_o * factor,
            t_v: (own.t_v + resistance) * factor,
            t_c_deviation: [0, 1].map(|i| uncertain(own.t_c[i], own.t_c_deviation[i])),
            t_o_deviation: uncertain(own.t_o, own.t_o_deviation),
            friction: own.friction.map(|mu| mu * factor),
            calibration: prior.weigh(now.p, &self.calibration(factor)),
            ..own
        };
        said.with_friction_terms(settings, now)
    }
}

/// What the wheel sensor shows of the states.
pub(super) const WHEEL: Terms<'_> = &[(W_W, 1.0), (BIAS, 1.0)];
