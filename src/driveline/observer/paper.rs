//! Method `paper`: the adaptive observer (19), (27), (29) as printed.
//!
//! ```text
//! x̂' = A x̂ + B û + E T_v + L (y − C x̂),   y = (x1, x2),   û = (T_e, T̂_c1, T̂_c2)            (19)
//! T̂_ci = (μ_i,n f_i,n + ε̂_i) r_ci N_i θ_mi                                              (23) (24)
//! L12 = c/J_ct2,eq,  L21 = 0,  L31 = 1/J_ct2,eq,  L32 = k − b,  L11 > 0,  L22 ≥ 0             (27)
//! ε̂_i' = L_ci (−a_i x̃1 + h_i x̃2) r_ci N_i θ_mi                                              (29)
//! ```
//!
//! **Proof: there is none for these gains.** (28) does not follow from (26): with L32 as printed, V̇
//! keeps a term c L22 x̃2 x̃3, and V mixes (rad/s)² with (N·m)² (errata E3, E4). The frozen dynamics are
//! stable where they were scanned, which is no proof either.
//!
//! **One sample.** The innovation e = y − C x̂ of the last instant is held over the step: first (29) takes
//! it (adapt), then x̂⁺ = Φ x̂ + Γ_u û + Γ_δ T_v + Γ_L e (predict). Holding y instead of e, or predicting
//! before adapting, diverges with these gains.

use crate::Params;
use crate::observer::friction::Friction;
use crate::observer::load::Load;
use crate::observer::lock::{self, Lock};
use crate::observer::{Estimate, Observer, Sample, Settings, map_based};
use crate::reduced::{Discrete, Reduced};
use nalgebra::{ComplexField, SMatrix, Vector2, Vector3};

/// Gains that (27) leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// L11 [1/s].
    pub l_11: f64,
    /// L22 [1/s].
    pub l_22: f64,
    /// L_c1, L_c2 of (29) with θ in m, shape (2); their unit follows from a V that mixes units.
    pub l_c: [f64; 2],
}

impl Gains {
    /// For a step of 1 ms.
    pub const AT_1_KHZ: Self = Self {
        l_11: 80.0,
        l_22: 4.0,
        l_c: [1200e6, 1200e6],
    };
    /// For a step of 10 ms.
    pub const AT_100_HZ: Self = Self {
        l_11: 24.0,
        l_22: 60.0,
        l_c: [270e6, 270e6],
    };

    /// These gains, given for 1 ms, at a step `h` [s]: each follows the power of h that leads from
    /// [`Self::AT_1_KHZ`] to [`Self::AT_100_HZ`]; below 1 ms they stay.
    ///
    /// Beyond 10 ms what one sample corrects is held, L11 h, L22 h and L_c h²: the same powers of h
    /// would lose stability before 20 ms.
    pub fn at_step(&self, h: f64) -> Self {
        let decades = ComplexField::log10((h / 1e-3).clamp(1.0, 10.0));
        let beyond = (1e-2 / h).min(1.0);
        let [fast, slow] = [Self::AT_1_KHZ, Self::AT_100_HZ];
        let scale = |slow: f64, fast: f64| ComplexField::powf(slow / fast, decades);
        Self {
            l_11: self.l_11 * scale(slow.l_11, fast.l_11) * beyond,
            l_22: self.l_22 * scale(slow.l_22, fast.l_22) * beyond,
            l_c: [0, 1].map(|i| self.l_c[i] * scale(slow.l_c[i], fast.l_c[i]) * beyond * beyond),
        }
    }

    /// L of (19) with the rows that (27) fixes, shape (3, 2).
    pub fn l(&self, model: &Reduced) -> SMatrix<f64, 3, 2> {
        let j = model.j_ct2_eq;
        SMatrix::<f64, 3, 2>::new(
            self.l_11,
            model.c_o_eq / j, //
            0.0,
            self.l_22, //
            1.0 / j,
            model.k_o_eq - model.b_coupling(),
        )
    }
}

/// A friction that is at its bound for this long tells that the inputs do not fit the model [s].
pub const SATURATION: f64 = 0.1;

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paper {
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
    /// Time for which a friction has been at its bound [s].
    pub saturated: f64,
    /// g of the last sample; x1 and x2 are defined by it.
    pub g: [f64; 2],
    /// The discrete model and what it was made for: derived, not part of the state.
    cache: Option<Cache>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cache {
    model: Reduced,
    gains: Gains,
    h: f64,
    discrete: Discrete,
}

impl Default for Paper {
    fn default() -> Self {
        Self {
            x_hat: Vector3::zeros(),
            epsilon: [0.0; 2],
            innovation: Vector2::zeros(),
            load: Load {
                running: -1.0,
                ..Load::default()
            },
            lock: Lock::default(),
            friction: Friction::nominal([0.0; 2]),
            f_n: [0.0; 2],
            saturated: 0.0,
            g: [1.0; 2],
            cache: None,
        }
    }
}

/// Actuator and map of one clutch at an instant, in the terms of (23).
#[derive(Debug, Clone, Copy)]
struct Lever {
    /// r_c N θ_m [m²]; 0 below the touch point.
    arm: f64,
    /// f_n = F_map/θ_m [N/m].
    f_n: f64,
}

impl Lever {
    /// Deviation: below the touch point the clutch transmits nothing and ε̂ is frozen; the paper would
    /// see a phantom torque there. A wet clutch takes the position that gives its force.
    fn new(p: &Params, sample: &Sample, i: usize) -> Self {
        let clutch = &p.clutch[i];
        let force = clutch.force(sample.actuation[i]);
        let theta = clutch.map.position(force);
        if force <= 0.0 || theta <= 0.0 {
            return Self { arm: 0.0, f_n: 0.0 };
        }
        Self {
            arm: clutch.r_c_n * theta,
            f_n: force / theta,
        }
    }
}

impl Observer for Paper {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self {
            friction: Friction::nominal(settings.mu_n),
            g: ratios(p, sample, lowest_ratios(p)),
            ..Self::default()
        };
        if !sample.is_finite() {
            return self.refuse();
        }
        let y = self.measured(p, sample);
        self.x_hat = Vector3::new(y[0], y[1], 0.0);
        self.lock.step(p, sample, 0.0);
        let t_v = self.load.step(p, settings.load, sample, &self.lock, 0.0);
        let levers = [0, 1].map(|i| Lever::new(p, sample, i));
        self.estimate(p, settings, sample, &levers, t_v)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !(sample.is_finite() && h.is_finite() && h > 0.0) {
            return self.refuse();
        }
        self.follow_gears(p, sample);
        let gains = if settings.scheduled {
            settings.gains.at_step(h)
        } else {
            settings.gains
        };
        let model = Reduced::referred_to(p, p.g(sample.gear), self.g[1], p.c_o);
        let levers = [0, 1].map(|i| Lever::new(p, sample, i));
        let engaged = self.lock.engaged();
        self.lock.step(p, sample, h);
        if settings.adapts {
            self.recall(settings, sample, &levers, engaged);
            self.adapt(&model, &gains, &levers, settings.mu_n, h);
        }
        let t_v = self.load.step(p, settings.load, sample, &self.lock, h);
        let (mu_f, t_c) = self.torques(settings, &levers);
        let discrete = self.discrete(&model, &gains, h);
        self.x_hat = discrete.phi * self.x_hat
            + discrete.gamma_u * Vector3::new(sample.t_e, t_c[0], t_c[1])
            + discrete.gamma_delta * t_v
            + discrete.gamma_l * self.innovation;
        self.innovation = self.measured(p, sample) - self.x_hat.fixed_rows::<2>(0);
        let mu_hat = [0, 1].map(|i| {
            if levers[i].f_n > 0.0 {
                mu_f[i] / levers[i].f_n
            } else {
                0.0
            }
        });
        self.friction.learn(p, sample, mu_hat, h);
        self.estimate(p, settings, sample, &levers, t_v)
    }
}

impl Paper {
    /// y = (x1, x2) of (12).
    ///
    /// Deviation: with the even shaft in neutral ω_c1 stands in for ω_c2, and ω_w with both.
    fn measured(&self, p: &Params, sample: &Sample) -> Vector2<f64> {
        let omega_c2 = match p.g(sample.gear) {
            [0.0, 0.0] => sample.omega_w * self.g[1],
            [g1, 0.0] => sample.omega_c[0] * self.g[1] / g1,
            _ => sample.omega_c[1],
        };
        Vector2::new(
            sample.omega_e - omega_c2,
            omega_c2 / self.g[1] - sample.omega_w,
        )
    }

    /// New gears define new x1 and x2: they start from measurements, x̂3 goes on.
    fn follow_gears(&mut self, p: &Params, sample: &Sample) {
        let g = ratios(p, sample, self.g);
        if g != self.g {
            self.g = g;
            let y = self.measured(p, sample);
            self.x_hat.fixed_rows_mut::<2>(0).copy_from(&y);
            self.innovation = Vector2::zeros();
        }
    }

    /// (29) with the innovation held, projected onto friction coefficients that exist.
    ///
    /// Deviation: the paper has no projection; it is a safety and does not act on its scenario.
    fn adapt(
        &mut self,
        model: &Reduced,
        gains: &Gains,
        levers: &[Lever; 2],
        mu_n: [f64; 2],
        h: f64,
    ) {
        let (a, h_twist, e) = (model.a_slip(), model.h_twist(), self.innovation);
        let mut bounded = false;
        for i in (0..2).filter(|i| levers[*i].arm > 0.0) {
            let rate = gains.l_c[i] * (-a[i] * e[0] + h_twist[i] * e[1]) * levers[i].arm;
            let bound = |mu: f64| (mu - mu_n[i]) * levers[i].f_n;
            let (low, high) = (bound(-Friction::PHYSICAL), bound(Friction::PHYSICAL));
            let free = self.epsilon[i] + h * rate;
            self.epsilon[i] = free.clamp(low, high);
            bounded |= self.epsilon[i] != free;
        }
        self.saturated = if bounded { self.saturated + h } else { 0.0 };
    }

    /// ε̂ of slipping clutches whose friction is known: μ̂, not ε̂, is what stays while the actuator moves.
    ///
    /// A clutch that begins to slip takes the friction learnt in its last slip, against the slip.
    ///
    /// Deviation: the paper takes ε̂ as slow (ε̇ ≈ 0), but f_n changes with the position, so ε̂ of a wrong
    /// friction does too; and it lets (29) find each slip anew, from what it adapted in the engaged
    /// clutch, with the wrong sign where the slip is negative (erratum E8).
    fn recall(
        &mut self,
        settings: &Settings,
        sample: &Sample,
        levers: &[Lever; 2],
        engaged: [bool; 2],
    ) {
        for (i, slip) in sample.slip().into_iter().enumerate() {
            let (before, now) = (self.f_n[i], levers[i].f_n);
            let slips = now > 0.0 && slip.abs() > lock::SLIP && self.friction.known(i);
            if slips && (before == 0.0 || engaged[i]) {
                let mu = self.friction.mu[i] * slip.signum();
                self.epsilon[i] = (mu - settings.mu_n[i]) * now;
            } else if slips {
                self.epsilon[i] *= now / before;
            }
            self.f_n[i] = now;
        }
    }

    fn discrete(&mut self, model: &Reduced, gains: &Gains, h: f64) -> Discrete {
        match self.cache {
            Some(cache) if (cache.model, cache.gains, cache.h) == (*model, *gains, h) => {
                cache.discrete
            }
            _ => {
                let discrete = model.discrete(&gains.l(model), h);
                self.cache = Some(Cache {
                    model: *model,
                    gains: *gains,
                    h,
                    discrete,
                });
                discrete
            }
        }
    }

    /// μ̂·f [N/m] and T̂_c [N·m] of (23), (24).
    fn torques(&self, settings: &Settings, levers: &[Lever; 2]) -> ([f64; 2], [f64; 2]) {
        let mu_f = [0, 1].map(|i| settings.mu_n[i] * levers[i].f_n + self.epsilon[i]);
        (mu_f, [0, 1].map(|i| mu_f[i] * levers[i].arm))
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.x_hat[2],
            epsilon: self.epsilon,
            friction: self.friction.mu,
            innovation: self.innovation.into(),
            engaged: self.lock.engaged(),
            valid: false,
            ..Estimate::default()
        }
    }

    fn estimate(
        &self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        levers: &[Lever; 2],
        t_v: f64,
    ) -> Estimate {
        let (t_c_map, t_o_map) = map_based(p, settings.mu_n, sample);
        let (mu_f, t_c) = self.torques(settings, levers);
        Estimate {
            t_c,
            t_o: self.x_hat[2],
            t_c_map,
            t_o_map,
            t_v,
            mu_f,
            epsilon: self.epsilon,
            friction: self.friction.mu,
            innovation: self.innovation.into(),
            engaged: self.lock.engaged(),
            valid: self.saturated < SATURATION,
        }
    }
}

/// Ratio of each shaft's lowest gear, which stands in until a shaft has had a gear; 1 without any.
fn lowest_ratios(p: &Params) -> [f64; 2] {
    [0, 1].map(|i| {
        let lowest = p.i_t[i].iter().find(|i_t| **i_t != 0.0);
        lowest.map_or(1.0, |i_t| i_t * p.i_f[i])
    })
}

/// g1, g2 of the gears preselected; a shaft in neutral keeps its last ratio.
fn ratios(p: &Params, sample: &Sample, last: [f64; 2]) -> [f64; 2] {
    let g = p.g(sample.gear);
    [0, 1].map(|i| if g[i] == 0.0 { last[i] } else { g[i] })
}
