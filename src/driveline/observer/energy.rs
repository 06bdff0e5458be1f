//! Method `energy`: the physical energy of the estimation error as Lyapunov function.
//!
//! The observer copies the driveline on its three measured speeds, with damper and drive shaft ([`Behind`]), and
//! corrects each speed by its own error, ω̃ = ω − ω̂:
//!
//! ```text
//! ω̂_j' = model_j + l_j ω̃_j,   j = e, o, w;     T̂_s' = k (ω̂_o − ω̂_w)
//! T̂_ci = (μ_i,n + ε̂_i) w_i,    w_i = r_ci N_i F_map,i(θ_mi) sgn(slip_i)
//! ε̂_i' = −L_i w_i (ω̃_e − g_i ω̃_o)
//! ```
//!
//! Take what the error stores, in joule, and the error of the friction:
//!
//! ```text
//! V = ½ (J_ed ω̃_e² + J_out ω̃_o² + J_v ω̃_w² + T̃_s²/k + Σ ε̃_i²/L_i)
//! V̇ = ω̃_e (−Σ T̃_ci) + ω̃_o (Σ g_i T̃_ci − T̃_o) + ω̃_w (T̃_o − T̃_v) + T̃_s (ω̃_o − ω̃_w)
//!     − Σ J_j l_j ω̃_j² − Σ ε̃_i ε̂_i'/L_i
//! ```
//!
//! With T̃_ci = w_i ε̃_i, T̃_o = T̃_s + c (ω̃_o − ω̃_w) and the adaptation above all cross terms cancel:
//!
//! ```text
//! V̇ = −J_ed l_e ω̃_e² − J_out l_o ω̃_o² − J_v l_w ω̃_w² − c (ω̃_o − ω̃_w)² − ω̃_w T̃_v ≤ 0   for T̃_v = 0.
//! ```
//!
//! **Proof: this one**, for any l_j > 0 and L_i > 0, any gears, one clutch or two; every term is a power.
//! All errors vanish where V̇ does: ω̃ = 0 leaves T̃_s = 0 (from ω_w), then Σ w_i ε̃_i = 0 and
//! Σ g_i w_i ε̃_i = 0, so ε̃ = 0 for g1 ≠ g2: the null space of (29) (erratum E5) is gone.
//! Outside the proof: the held innovation; L_i is normalised, L/(w_i² + w_0²), which adds
//! ½ ε̃_i² d(1/L_i)/dt while the force moves; a change of the mode below, where V may jump.
//!
//! With both clutches pressed the one that slips keeps a friction that was learnt: V̇ holds for the other.
//!
//! **Lock-aware.** sgn(slip) says nothing of an engaged clutch. Once the slip has met 0, or stayed below 3 rad/s for
//! 30 ms, ε̂_i is frozen and T_ci is what the damper carries. In this mode V has J_e, J_out + g_i² J_d and
//! T̃_k²/(2 k_d) in place of J_ed and J_out; the cross terms of T̃_d cancel as those of T̃_o do, and
//!
//! ```text
//! ε̂_j' = −L_j w_j (g_i − g_j) ω̃_o,    V̇ = … − c_d (ω̃_e − g_i ω̃_o)² ≤ 0
//! ```
//!
//! Without lock-awareness the sign does harm (259 % error). T̂_d is held to what a learnt friction can carry, static
//! friction included, and a clutch that would carry more slips. In a handover it does so from the kinetic friction on:
//! there the speeds leave the two torques to each other (erratum E5), and a slip that is taken as a twist of the damper
//! runs away in the friction of the other clutch. A clutch that lets go before it was ever seen to slip starts from
//! what it has carried (`breakaway`).

use crate::Params;
use crate::observer::breakaway::BreakAway;
use crate::observer::damper::{Behind, Discrete, SPEEDS, State, Torques};
use crate::observer::friction::Friction;
use crate::observer::instant::Instant;
use crate::observer::load::Load;
use crate::observer::lock::Lock;
use crate::observer::monitor::Monitor;
use crate::observer::schedule::{followed, scaled};
use crate::observer::speeds::output_speed;
use crate::observer::standstill::held;
use crate::observer::{
    Estimate, Observer, Sample, Settings, Visit, brake, made, say_common, visit_switch, within,
};
use nalgebra::Vector3;

/// w_0: lever below which the adaptation is not normalised [N·m].
const LEVER: f64 = 20.0;
/// Factor on L while the other clutch is engaged [1]: only the difference of both ratios shows the friction then.
const HANDOVER: f64 = 3.0;

/// Gains that the proof leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// l_e, l_o, l_w [1/s], shape (3), > 0.
    pub l: [f64; 3],
    /// L of both clutches [N·m/rad], ≥ 0.
    pub l_c: f64,
}

impl Gains {
    /// For a step of 1 ms.
    pub const AT_1_KHZ: Self = Self {
        l: [8.0, 40.0, 30.0],
        l_c: 500.0,
    };
    /// For a step of 10 ms.
    pub const AT_100_HZ: Self = Self {
        l: [8.0, 20.0, 60.0],
        l_c: 800.0,
    };

    /// These gains, given for 1 ms, at a step `h` [s]: see `scaled`.
    pub fn at_step(&self, h: f64) -> Self {
        let [fast, slow] = [Self::AT_1_KHZ, Self::AT_100_HZ];
        Self {
            l: [0, 1, 2].map(|j| scaled(self.l[j], [fast.l[j], slow.l[j]], 1, h)),
            l_c: scaled(self.l_c, [fast.l_c, slow.l_c], 2, h),
        }
    }
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// ω̂_e, ω̂_o, ω̂_w [rad/s], T̂_s and T̂_k [N·m], shape (5).
    pub x_hat: State,
    /// ε̂_1, ε̂_2, in units of μ [1], shape (2).
    pub epsilon: [f64; 2],
    /// What engaged clutches of an unknown friction have carried.
    pub break_away: BreakAway,
    /// ω̃ at the last instant [rad/s], shape (3).
    pub innovation: Vector3<f64>,
    /// Load torque (20).
    pub load: Load,
    /// Engaged clutches.
    pub lock: Lock,
    /// Friction learnt while slipping.
    pub friction: Friction,
    /// What tells that the inputs make no sense.
    pub monitor: Monitor,
    /// g of the last sample.
    pub g: [f64; 2],
    /// Clutches that slipped under force at the last sample, shape (2).
    pub slipping: [bool; 2],
    /// The discrete model and what it was made for: derived, not part of the state.
    cache: Option<(Key, Discrete)>,
}

/// What the discrete model depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    model: Behind,
    l: [f64; SPEEDS],
    h: f64,
}

impl Default for Energy {
    fn default() -> Self {
        Self {
            x_hat: State::zeros(),
            epsilon: [0.0; 2],
            break_away: BreakAway::default(),
            innovation: Vector3::zeros(),
            load: Load::default(),
            lock: Lock::default(),
            friction: Friction::nominal([0.0; 2]),
            monitor: Monitor::default(),
            g: [0.0; 2],
            slipping: [false; 2],
            cache: None,
        }
    }
}

impl Observer for Energy {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        *self = Self {
            friction: Friction::nominal(settings.mu_n),
            ..Self::default()
        };
        if !sample.is_finite() {
            return self.refuse();
        }
        let now = Instant::new(p, sample);
        self.take_speeds(&now);
        self.lock.start(p, sample);
        self.monitor.start(p, sample);
        let t_v = self.load.step(&now, settings.load, &self.lock, 0.0);
        self.estimate(settings, &now, t_v)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        if !sample.may_enter(h) {
            return self.refuse();
        }
        let gains = if settings.scheduled {
            settings.energy.at_step(h)
        } else {
            settings.energy
        };
        let now = Instant::new(p, sample);
        if self.g != now.g {
            self.take_speeds(&now);
        }
        let t_c = self.torques(settings, &now);
        self.lock.step(&now, t_c, h);
        self.find_break_away(&now, t_c, h);
        if settings.adapts {
            self.recall(settings, &now);
            self.adapt(settings, &now, gains.l_c, h);
        }
        let t_v = self.load.step(&now, settings.load, &self.lock, h);
        let t_o = Behind::new(p, sample, None).t_o(&self.x_hat);
        let standing = held(p, sample, self.x_hat[2], t_o, t_v - brake(p, sample));
        let moving = Instant {
            p: standing.as_ref().unwrap_or(p),
            ..now
        };
        self.predict(settings, &moving, t_v, gains.l, h);
        self.innovation = measured(&now) - self.x_hat.fixed_rows::<3>(0);
        let mu_hat = [0, 1].map(|i| (settings.mu_n[i] + self.epsilon[i]) * self.lock.direction[i]);
        let engaged = self.holds();
        self.friction.learn(&now, engaged, mu_hat, h);
        let e = self.innovation_x(now.g);
        self.monitor.step(&now, self.lock.engaged(), e, h);
        self.estimate(settings, &now, t_v)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            x_hat,
            epsilon,
            break_away,
            innovation,
            load,
            lock,
            friction,
            monitor,
            g,
            slipping,
            cache: _,
        } = self;
        x_hat.iter_mut().for_each(&mut *visit);
        epsilon.iter_mut().for_each(&mut *visit);
        break_away.visit(visit);
        innovation.iter_mut().for_each(&mut *visit);
        load.visit(visit);
        lock.visit(visit);
        friction.visit(visit);
        monitor.visit(visit);
        g.iter_mut().for_each(&mut *visit);
        let switches = slipping.iter_mut();
        switches.for_each(|switch| visit_switch(switch, visit));
    }
}

impl Energy {
    /// Speeds from measurements: at the start, and when a gear comes in, which is a shock that no torque
    /// of the model explains. T̂_s, the twist, goes on.
    fn take_speeds(&mut self, now: &Instant<'_>) {
        let y = measured(now);
        self.x_hat.fixed_rows_mut::<3>(0).copy_from(&y);
        self.innovation = Vector3::zeros();
        self.g = now.g;
    }

    /// A clutch that begins to slip has the friction that was learnt in its last slip.
    fn recall(&mut self, settings: &Settings, now: &Instant<'_>) {
        let (engaged, w) = (self.holds(), self.levers(now));
        let slipping = [0, 1].map(|i| w[i] != 0.0 && !engaged[i]);
        for i in (0..2).filter(|i| slipping[*i] && !self.slipping[*i]) {
            if self.friction.known(i) {
                self.epsilon[i] = self.friction.mu[i] - settings.mu_n[i];
            } else if let Some(mu) = self.break_away.friction(i) {
                self.epsilon[i] = mu - settings.mu_n[i];
            }
        }
        self.slipping = slipping;
    }

    /// An engaged clutch of an unknown friction lets go where its slip leaves the model at the most it has carried. What
    /// the speeds have run apart by since then is slip, and no error of theirs.
    fn find_break_away(&mut self, now: &Instant<'_>, t_c: [f64; 2], h: f64) {
        let (w, g, holds) = (self.levers(now).map(f64::abs), now.g, self.holds());
        let apart = g.map(|g| self.innovation[0] - g * self.innovation[1]);
        for i in [0, 1] {
            if !holds[i] || w[i] <= LEVER || self.friction.known(i) {
                self.break_away.rest(i);
            } else if self.break_away.step(i, w[i], t_c[i], apart[i], h) {
                self.lock.let_go(i, t_c[i]);
                self.take_speeds(now);
            }
        }
    }

    /// Clutches that hold both sides together, shape (2): the slip has stayed small, or has just met 0.
    fn holds(&self) -> [bool; 2] {
        [0, 1].map(|i| self.lock.holds(i))
    }

    /// w_i: torque per unit of friction, with the sign of the slip [N·m], shape (2).
    fn levers(&self, now: &Instant<'_>) -> [f64; 2] {
        let levers = now.levers();
        [0, 1].map(|i| levers[i] * self.lock.direction[i])
    }

    /// The adaptation with the innovation held, projected onto friction coefficients that exist.
    fn adapt(&mut self, settings: &Settings, now: &Instant<'_>, l_c: f64, h: f64) {
        let Instant { p, sample, g, .. } = *now;
        let (w, e) = (self.levers(now), self.innovation);
        let engaged = self.lock.harder(now.force);
        let mut bounded = false;
        let holds = [0, 1].map(|i| engaged == Some(i));
        let l_c = engaged.map_or(l_c, |_| HANDOVER * l_c);
        let omega_d = engaged.map_or(e[0], |i| g[i] * e[1]);
        let adapting = self.friction.adapting(w.map(|w| w != 0.0), holds);
        for i in (0..2).filter(|i| adapting[*i] && !holds[*i]) {
            let gain = followed(l_c, p, sample, i, h) / (w[i] * w[i] + LEVER * LEVER);
            let free = self.epsilon[i] - h * gain * w[i] * (omega_d - g[i] * e[1]);
            let mu_n = settings.mu_n[i];
            self.epsilon[i] = within(free, -mu_n, Friction::PHYSICAL - mu_n);
            bounded |= self.epsilon[i] > Friction::PHYSICAL - mu_n - f64::EPSILON;
        }
        let saturated = self.monitor.saturated;
        self.monitor.saturated = if bounded { saturated + h } else { 0.0 };
    }

    /// T̂_c1, T̂_c2 [N·m] at the present state.
    fn torques(&self, settings: &Settings, now: &Instant<'_>) -> [f64; 2] {
        let Instant { p, sample, .. } = *now;
        let w = self.levers(now);
        let mut t_c = [0, 1].map(|i| (settings.mu_n[i] + self.epsilon[i]) * w[i]);
        if let Some(i) = self.lock.harder(now.force) {
            let model = Behind::new(p, sample, Some(i));
            t_c[i] = model.clutch_torque(&self.x_hat, i, t_c[1 - i], sample.t_y);
        }
        t_c
    }

    /// Model copy and correction over one step, the innovation held.
    fn predict(&mut self, settings: &Settings, now: &Instant<'_>, t_v: f64, l: [f64; 3], h: f64) {
        let Instant { p, sample, .. } = *now;
        let key = Key {
            model: Behind::new(p, sample, self.lock.harder(now.force)),
            l,
            h,
        };
        let discrete = match self.cache {
            Some((made_for, discrete)) if made_for == key => discrete,
            _ => key.model.discrete(l, h),
        };
        self.cache = Some((key, discrete));
        let [one, two] = self.torques(settings, now);
        let v = Torques::from([sample.t_e, one, two, t_v, sample.t_y]);
        self.x_hat =
            discrete.phi * self.x_hat + discrete.gamma * v + discrete.gamma_l * self.innovation;
        match key.model.engaged {
            Some(i) => self.bound(settings, now, i),
            None => self.x_hat[4] = one + two,
        }
    }

    /// Projects T̂_k onto what the engaged clutch `i`, of a friction that was learnt, can carry.
    fn bound(&mut self, settings: &Settings, now: &Instant<'_>, i: usize) {
        if self.friction.known(i) {
            let w = self.levers(now);
            let carried = self.torques(settings, now)[i];
            let kinetic = self.friction.mu[i] * w[i].abs();
            let most = Friction::STATIC * kinetic;
            self.x_hat[4] += within(carried, -most, most) - carried;
            let handover = w[1 - i] != 0.0;
            if carried.abs() > if handover { kinetic } else { most } {
                self.lock.let_go(i, carried);
            }
        }
    }

    /// Innovation in the terms of (12), shape (2).
    fn innovation_x(&self, g: [f64; 2]) -> [f64; 2] {
        let [e, o, w]: [f64; 3] = self.innovation.into();
        [e - g[1] * o, o - w]
    }

    /// What is said of a sample that cannot be used.
    fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.x_hat[3],
            friction: self.friction.mu,
            engaged: self.lock.engaged(),
            ..Estimate::refused()
        }
    }

    fn estimate(&self, settings: &Settings, now: &Instant<'_>, t_v: f64) -> Estimate {
        let model = Behind::new(now.p, now.sample, None);
        let [e, o, w]: [f64; 3] = self.innovation.into();
        let l = settings.energy.l;
        let unexplained = (model.speeds.j_ed * l[0] * e).abs();
        let pressed = self.levers(now).map(|w| w != 0.0);
        let (engaged, fault) = (self.lock.engaged(), self.monitor.fault());
        let common = made(|y| say_common(y, settings, now, engaged, fault));
        let said = Estimate {
            t_c: self.torques(settings, now),
            t_o: model.t_o(&self.x_hat),
            t_v,
            friction: self.friction.mu,
            innovation: self.innovation_x(now.g),
            t_c_deviation: pressed.map(|pressed| if pressed { unexplained } else { 0.0 }),
            t_o_deviation: (model.speeds.j_out * l[1] * o).abs()
                + (model.speeds.j_v * l[2] * w).abs(),
            ..common
        };
        said.with_friction_terms(settings, now)
    }
}

/// (ω_e, ω_o, ω_w) [rad/s], shape (3).
fn measured(now: &Instant<'_>) -> Vector3<f64> {
    let sample = now.sample;
    let omega_o = output_speed(now.g, sample);
    Vector3::new(sample.omega_e, omega_o, sample.omega_w)
}
