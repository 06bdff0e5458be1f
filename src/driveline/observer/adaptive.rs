//! The control-oriented observer that `paper` and `lyapunov` share: they differ in their gains only.
//!
//! ```text
//! x̂' = A x̂ + B û + E T_v + L (y − C x̂),   y = (x1, x2),   û = (T_e, T̂_c1, T̂_c2)            (19)
//! T̂_ci = (μ_i,n f_i,n + ε̂_i) r_ci N_i θ_mi                                              (23) (24)
//! ε̂_i' = L_ci (−a_i x̃1 + h_i x̃2) r_ci N_i θ_mi              (29), and other weights of x̃1, x̃2 in `lyapunov`
//! ```
//!
//! **One sample.** The innovation e = y − C x̂ of the last instant is held over the step: first (29) takes
//! it (adapt), then x̂⁺ = Φ x̂ + Γ_u û + Γ_δ T_v + Γ_L e (predict). Predicting before adapting diverges from 5 ms on with
//! the gains of `paper`; holding y instead of e is less exact, at 100 Hz up to five times.

use crate::Params;
use crate::observer::design::{Answers, GAINS, Method, Wanted};
use crate::observer::friction::Friction;
use crate::observer::instant::Instant;
use crate::observer::lever::Lever;
use crate::observer::load::Load;
use crate::observer::lock::Lock;
use crate::observer::monitor::Monitor;
use crate::observer::phase::alone;
use crate::observer::schedule::lowest_ratios;
use crate::observer::standstill::held;
use crate::observer::{Estimate, Sample, Settings, Visit, brake, made, say_common, within};
use nalgebra::{Vector2, Vector3};

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// x̂, shape (3).
    pub x_hat: Vector3<f64>,
    /// ε̂_c1, ε̂_c2 [N/m], shape (2).
    pub epsilon: [f64; 2],
    /// e = y − C x̂ at the last instant, shape (2).
    pub innovation: Vector2<f64>,
    /// Load torque (20).
    pub load: Load,
    /// Engaged clutches.
    pub lock: Lock,
    /// Friction learnt while slipping.
    pub friction: Friction,
    /// f_n of the last instant [N/m], shape (2); 0 below the touch point.
    pub f_n: [f64; 2],
    /// r_c N θ_m of the last instant [m²], shape (2); 0 below the touch point.
    pub arm: [f64; 2],
    /// Slip of the last instant [rad/s], shape (2).
    pub slip: [f64; 2],
    /// Time for which a friction has been at its bound [s].
    pub saturated: f64,
    /// g of the last sample; x1 and x2 are defined by it.
    pub g: [f64; 2],
    /// What tells that the inputs make no sense.
    pub monitor: Monitor,
    /// Gains and models of the last steps: derived, not part of the state.
    pub(super) answers: Answers,
}

/// What one sample brings.
#[derive(Debug, Clone, Copy)]
struct Now {
    levers: [Lever; 2],
    /// J_v, that of a wheel which is held included [kg·m²].
    j_v: f64,
    /// T_v [N·m].
    t_v: f64,
    /// What T_c1, T_c2 of engaged clutches rise by over the step [N·m], shape (2).
    rise: Vector2<f64>,
}

impl Default for Adaptive {
    fn default() -> Self {
        Self {
            x_hat: Vector3::zeros(),
            epsilon: [0.0; 2],
            innovation: Vector2::zeros(),
            load: Load::default(),
            lock: Lock::default(),
            friction: Friction::nominal([0.0; 2]),
            f_n: [0.0; 2],
            arm: [0.0; 2],
            slip: [0.0; 2],
            saturated: 0.0,
            g: [1.0; 2],
            monitor: Monitor::default(),
            answers: Answers::default(),
        }
    }
}

impl Adaptive {
    /// Starts from measurements, with what `design` makes of `gains`; the estimate holds for their instant.
    pub fn start(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        gains: [f64; GAINS],
        design: Method,
    ) -> Estimate {
        *self = Self {
            friction: Friction::nominal(settings.mu_n),
            g: ratios(p.g(sample.gear), lowest_ratios(p)),
            ..Self::default()
        };
        if !sample.is_finite() {
            return self.refuse();
        }
        let at = Instant::new(p, sample);
        let y = self.measured(&at);
        self.x_hat = Vector3::new(y[0], y[1], 0.0);
        self.slip = sample.slip();
        self.lock.start(p, sample);
        self.monitor.start(p, sample);
        let mut now = self.now(&at, 1e-3, gains, design);
        now.t_v = self.load.step(&at, settings.load, &self.lock, 0.0);
        made(|y| self.estimate(settings, &at, &now, y))
    }

    /// Advances by `h` [s] with what a design makes of gains; `y` becomes the estimate, but for what these
    /// methods never tell: consistency and calibration stay 0.
    pub fn step(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        h: f64,
        (gains, design): ([f64; GAINS], Method),
        y: &mut Estimate,
    ) {
        if !sample.may_enter(h) {
            *y = self.refuse();
            return;
        }
        let at = Instant::new(p, sample);
        self.follow_gears(&at);
        let mut now = self.now(&at, h, gains, design);
        let engaged = self.lock.engaged();
        let t_c = self.torques(settings, &now.levers).1;
        self.lock.step(&at, t_c, h);
        if settings.adapts {
            now.rise = self.recall(p, settings.mu_n, sample, &now.levers, engaged, h);
            self.adapt(&now, settings.mu_n, h);
        }
        now.t_v = self.load.step(&at, settings.load, &self.lock, h);
        let measured = self.measured(&at);
        now.j_v = self.j_v(p, sample, measured, now.t_v);
        self.predict(settings, sample, &now);
        self.innovation = measured - self.x_hat.fixed_rows::<2>(0);
        let mu_hat = self.mu_hat(settings, &now.levers);
        let (engaged, e) = (self.lock.engaged(), self.innovation.into());
        self.friction.learn(&at, engaged, mu_hat, h);
        self.monitor.step(&at, engaged, e, h);
        self.monitor.saturated = self.saturated;
        self.estimate(settings, &at, &now, y);
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            x_hat,
            epsilon,
            innovation,
            load,
            lock,
            friction,
            f_n,
            arm,
            slip,
            saturated,
            g,
            monitor,
            answers: _,
        } = self;
        x_hat.iter_mut().for_each(&mut *visit);
        epsilon.iter_mut().for_each(&mut *visit);
        innovation.iter_mut().for_each(&mut *visit);
        load.visit(visit);
        lock.visit(visit);
        friction.visit(visit);
        f_n.iter_mut().for_each(&mut *visit);
        arm.iter_mut().for_each(&mut *visit);
        slip.iter_mut().for_each(&mut *visit);
        visit(saturated);
        g.iter_mut().for_each(&mut *visit);
        monitor.visit(visit);
    }

    fn now(&mut self, now: &Instant<'_>, h: f64, gains: [f64; GAINS], design: Method) -> Now {
        let wanted = Wanted {
            g_ref: self.g[1],
            told: alone(now).filter(|i| self.friction.known(*i) || self.friction.taken(*i)),
            h,
            gains,
            design,
        };
        self.answers.find(now, &wanted);
        Now {
            levers: [0, 1].map(|i| Lever::new(now, i)),
            j_v: now.p.j_v,
            t_v: 0.0,
            rise: Vector2::zeros(),
        }
    }

    /// y = (x1, x2) of (12).
    ///
    /// Deviation: with the even shaft in neutral ω_c1 stands in for ω_c2, and ω_w with both.
    fn measured(&self, now: &Instant<'_>) -> Vector2<f64> {
        let sample = now.sample;
        let omega_c2 = match now.g {
            [0.0, 0.0] => sample.omega_w * self.g[1],
            [g1, 0.0] => sample.omega_c[0] * self.g[1] / g1,
            _ => sample.omega_c[1],
        };
        Vector2::new(
            sample.omega_e - omega_c2,
            omega_c2 / self.g[1] - sample.omega_w,
        )
    }

    /// New gears define new x1 and x2: they start from measurements, and x̂3 follows the jump of x2 as
    /// (15) says, ẋ3 = k x2 + c ẋ2.
    fn follow_gears(&mut self, now: &Instant<'_>) {
        let g = ratios(now.g, self.g);
        if g != self.g {
            self.g = g;
            let y = self.measured(now);
            self.x_hat[2] += now.p.c_o * (y[1] - self.x_hat[1]);
            self.x_hat.fixed_rows_mut::<2>(0).copy_from(&y);
            self.innovation = Vector2::zeros();
        }
    }

    /// (29) with the innovation held, projected onto friction coefficients that exist.
    ///
    /// Deviation: the paper has no projection; it is a safety and does not act on its scenario. In a handover a
    /// clutch that slips keeps a friction that was learnt ([`Friction::adapting`]).
    fn adapt(&mut self, now: &Now, mu_n: [f64; 2], h: f64) {
        let by = self.answers.last().design.adaptation * self.innovation;
        let mut bounded = false;
        let pressed = now.levers.map(|lever| lever.arm > 0.0);
        let adapting = self.friction.adapting(pressed, self.lock.engaged());
        for i in (0..2).filter(|i| adapting[*i]) {
            let Lever { arm, f_n } = now.levers[i];
            let bound = |mu: f64| (mu - mu_n[i]) * f_n;
            let (low, high) = (bound(-Friction::PHYSICAL), bound(Friction::PHYSICAL));
            let free = self.epsilon[i] + h * by[i] * arm;
            self.epsilon[i] = within(free, low, high);
            bounded |= self.epsilon[i] != free;
        }
        self.saturated = if bounded { self.saturated + h } else { 0.0 };
    }

    /// J_v of (14), (15): that of a wheel which nothing moves while the brake holds it [kg·m²].
    ///
    /// ω̂_w is ω_o less x̂2: what x̂2 averages, one sample of ω_w does not.
    fn j_v(&self, p: &Params, sample: &Sample, y: Vector2<f64>, t_v: f64) -> f64 {
        let omega_w = sample.omega_w + y[1] - self.x_hat[1];
        let t_v = t_v - brake(p, sample);
        held(p, sample, omega_w, self.x_hat[2], t_v).map_or(p.j_v, |standing| standing.j_v)
    }

    /// (19) over one step with the innovation held.
    fn predict(&mut self, settings: &Settings, sample: &Sample, now: &Now) {
        let end = self.torques(settings, &now.levers).1;
        let begin = [0, 1].map(|i| end[i] - now.rise[i]);
        let (x_hat, innovation) = (self.x_hat, self.innovation);
        let discrete = self.answers.last_mut().discrete(now.j_v);
        self.x_hat = discrete.phi * x_hat
            + discrete.gamma_u * Vector3::new(sample.t_e, begin[0], begin[1])
            + discrete.gamma_delta * now.t_v
            + discrete.gamma_rise * now.rise
            + discrete.gamma_y * sample.t_y
            + discrete.gamma_l * innovation;
    }

    /// μ̂·f [N/m] and T̂_c [N·m] of (23), (24).
    fn torques(&self, settings: &Settings, levers: &[Lever; 2]) -> ([f64; 2], [f64; 2]) {
        let mu_f = [0, 1].map(|i| settings.mu_n[i] * levers[i].f_n + self.epsilon[i]);
        (mu_f, [0, 1].map(|i| mu_f[i] * levers[i].arm))
    }

    /// μ̂ of each clutch with the sign of its torque [1], shape (2); 0 below the touch point.
    fn mu_hat(&self, settings: &Settings, levers: &[Lever; 2]) -> [f64; 2] {
        let mu_f = self.torques(settings, levers).0;
        [0, 1].map(|i| {
            if levers[i].f_n > 0.0 {
                mu_f[i] / levers[i].f_n
            } else {
                0.0
            }
        })
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.x_hat[2],
            epsilon: self.epsilon,
            friction: self.friction.mu,
            innovation: self.innovation.into(),
            engaged: self.lock.engaged(),
            ..Estimate::refused()
        }
    }

    fn estimate(&self, settings: &Settings, at: &Instant<'_>, now: &Now, y: &mut Estimate) {
        let (mu_f, t_c) = self.torques(settings, &now.levers);
        let (t_c_deviation, t_o_deviation) = self.unexplained(now);
        let (engaged, fault) = (self.lock.engaged(), self.monitor.fault());
        say_common(y, settings, at, engaged, fault);
        (y.t_c, y.t_c_deviation) = (t_c, t_c_deviation);
        (y.t_o, y.t_o_deviation) = (self.x_hat[2], t_o_deviation);
        y.t_v = now.t_v;
        (y.mu_f, y.epsilon) = (mu_f, self.epsilon);
        y.friction = self.friction.mu;
        y.innovation = self.innovation.into();
    }

    /// Torques that L injects where the model leaves the motion unexplained [N·m]: an error of T_ci
    /// that lasts shows as L11 x̃1 = a_i T̃_ci, one of T_o as L22 x̃2 = b T̃_o.
    fn unexplained(&self, now: &Now) -> ([f64; 2], f64) {
        let [e1, e2]: [f64; 2] = self.innovation.into();
        let answer = self.answers.last();
        let (a, l, model) = (&answer.a, &answer.design.l, answer.model(now.j_v));
        let t_c = [0, 1].map(|i| {
            if now.levers[i].arm > 0.0 {
                (l[(0, 0)] * e1 / a[i]).abs()
            } else {
                0.0
            }
        });
        (t_c, (l[(1, 1)] * e2 / model.b_coupling()).abs())
    }
}

/// g1, g2 of the gears that are in, `g`; a shaft in neutral keeps its last ratio.
fn ratios(g: [f64; 2], last: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| if g[i] == 0.0 { last[i] } else { g[i] })
}
