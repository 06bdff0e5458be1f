//! What `kalman` and `calibrating` do alike: a belief that starts with the seven states
//! (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v), corrected by what a car measures. How the clutches carry their torques
//! stands in carry.rs.
//!
//! A clutch below its touch point carries nothing: its torque is a measurement of zero. No friction map
//! enters: μ̂ is T̂_c over the force.

use crate::Params;
use crate::observer::filter::{Belief, Terms, along};
use crate::observer::friction::Friction;
use crate::observer::instant::Instant;
use crate::observer::lock::Lock;
use crate::observer::monitor::Monitor;
use crate::observer::speeds::{Speeds, output_speed};
use crate::observer::standstill::{held, stands};
use crate::observer::swing::Swing;
use crate::observer::{Estimate, Sample, Settings, Visit, brake, made, say_common};
use nalgebra::SVector;

/// Index of ω_e [rad/s].
pub const W_E: usize = 0;
/// Index of ω_o [rad/s].
pub const W_O: usize = 1;
/// Index of ω_w [rad/s].
pub const W_W: usize = 2;
/// Index of T_s [N·m].
pub const T_S: usize = 3;
/// Index of T_c1, and T_c2 after it [N·m].
pub const T_C: usize = 4;
/// Index of T_v without a measured brake torque [N·m].
pub const T_V: usize = 6;
/// Number of these states; those after them are the method's own.
pub const SHARED: usize = 7;

/// Deviations at the start: speeds [rad/s], T_s, T_c1, T_c2, T_v [N·m].
pub const START: [f64; SHARED] = [0.5, 0.5, 0.5, 100.0, 20.0, 20.0, 200.0];
/// Deviation of the zero that an open clutch measures [N·m].
pub const OPEN: f64 = 0.1;
/// Deviation of T_s after a change of gear [N·m]: a synchroniser winds the transfer shaft of the other gear by g T_s/K, which no
/// shaft's speed shows, k_o g T_s/K = 5 N·m in second gear of Table 1.
const GIVES: f64 = 5.0;
/// Time constant of the low pass of the normalised innovation [s].
const MEMORY: f64 = 0.5;
/// Smallest lever that tells a friction [N·m].
const LEVER: f64 = 1.0;

/// A belief of N states, and what watches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracker<const N: usize> {
    /// x̂ and P.
    pub belief: Belief<N>,
    /// Innovations of ω_e, ω_o, ω_w at the last instant [rad/s], shape (3).
    pub innovation: [f64; 3],
    /// Clutches that hold, as the slip tells.
    pub lock: Lock,
    /// The clutch that is engaged: its state is T_k, what the damper carries.
    pub engaged: Option<usize>,
    /// T̂_c1, T̂_c2 of the last estimate [N·m], shape (2).
    pub t_c: [f64; 2],
    /// Friction learnt while slipping.
    pub friction: Friction,
    /// What tells that the inputs make no sense.
    pub monitor: Monitor,
    /// g of the last sample.
    pub g: [f64; 2],
    /// Mean over the speeds of innovation² over its variance [1], as with the noise that is believed, through a low pass:
    /// 1 where the filter is right about itself, less where speeds are quieter.
    pub surprise: f64,
    /// The damper while no clutch is engaged: at rest where the method does not let it swing.
    pub swing: Swing,
}

impl<const N: usize> Default for Tracker<N> {
    fn default() -> Self {
        Self {
            belief: Belief::new(SVector::zeros(), SVector::zeros()),
            innovation: [0.0; 3],
            lock: Lock {
                wary: true,
                ..Lock::default()
            },
            engaged: None,
            t_c: [0.0; 2],
            friction: Friction::nominal([0.0; 2]),
            monitor: Monitor::default(),
            g: [0.0; 2],
            surprise: 0.0,
            swing: Swing::default(),
        }
    }
}

impl<const N: usize> Tracker<N> {
    /// Nothing known but the deviations of the states, shape (N).
    pub fn new(settings: &Settings, x: SVector<f64, N>, sigma: SVector<f64, N>) -> Self {
        Self {
            belief: Belief::new(x, sigma),
            friction: Friction::nominal(settings.mu_n),
            ..Self::default()
        }
    }

    /// Starts from measurements. `wheel`: what the wheel sensor shows of the states.
    pub fn start(&mut self, now: &Instant<'_>, wheel: Terms<'_>) {
        let Instant { p, sample, .. } = *now;
        self.belief.x[T_V] = p.road.load_torque(sample.omega_w, sample.phi);
        self.take_speeds(p, sample, wheel);
        self.lock.start(p, sample);
        self.engage(now);
        self.swing = Swing::rest(p, sample.t_e, 0.0);
        self.monitor.start(p, sample);
    }

    /// Before the prediction: gears that went out or came in, engaged clutches.
    pub fn follow(&mut self, now: &Instant<'_>, h: f64) {
        if self.g != now.g {
            self.take_gear(now);
        }
        self.lock.step(now, self.t_c, h);
        self.engage(now);
    }

    /// The driveline with a wheel that stands, if the brake holds it; `c` of the drive shaft [N·m·s/rad], asked for
    /// where one stands.
    pub fn held(&self, p: &Params, sample: &Sample, c: impl FnOnce() -> f64) -> Option<Params> {
        let x = &self.belief.x;
        if !stands(sample, x[W_W]) {
            return None;
        }
        let t_o = x[T_S] + c() * (x[W_O] - x[W_W]);
        held(p, sample, x[W_W], t_o, x[T_V])
    }

    /// Speeds from measurements.
    fn take_speeds(&mut self, p: &Params, sample: &Sample, wheel: Terms<'_>) {
        self.g = p.g(sample.gear);
        let bias = along(wheel, &self.belief.x) - self.belief.x[W_W];
        let omega_w = sample.omega_w - bias;
        let speeds = [sample.omega_e, output_speed(self.g, sample), omega_w];
        let x = &mut self.belief.x;
        x.fixed_rows_mut::<3>(0).copy_from_slice(&speeds);
    }

    /// Where a gear goes out or comes in: ω_o from the shafts that turn with the output now. T_s goes on, as clutches and
    /// load do, but for what the transfer shafts give.
    fn take_gear(&mut self, now: &Instant<'_>) {
        self.g = now.g;
        let omega_o = output_speed(self.g, now.sample);
        self.belief.forget(W_O, omega_o, START[W_O]);
        self.belief.p[(T_S, T_S)] += GIVES * GIVES;
    }

    /// Corrects by every speed and by clutches that are open, `h` [s] after the last ones. Deviations [rad/s], shape (2):
    /// `sensor` of ω_e, ω_c1, ω_c2 and of ω_w; `believed` of each at most.
    pub fn correct(
        &mut self,
        now: &Instant<'_>,
        sensor: [f64; 2],
        believed: f64,
        wheel: Terms<'_>,
        h: f64,
    ) {
        let (Instant { sample, g, .. }, before) = (*now, self.belief.x);
        let (pressed, omega_e) = (now.pressed(), sample.omega_e - self.swings(now));
        let [r, r_w] = sensor.map(|sigma| sigma * sigma);
        self.innovation = [
            omega_e - before[W_E],
            output_speed(g, sample) - before[W_O],
            sample.omega_w - along(wheel, &before),
        ];
        let mut normalised = self.measure(&[(W_E, 1.0)], omega_e, r);
        let mut count = 2.0;
        for i in (0..2).filter(|i| g[*i] != 0.0) {
            normalised += self.measure(&[(W_O, g[i])], sample.omega_c[i], r);
            count += 1.0;
        }
        normalised += self.measure(wheel, sample.omega_w, r_w) * (r_w / r);
        let expected = normalised * r / (believed * believed * count);
        self.surprise += (expected - self.surprise) * (h / (h + MEMORY));
        for (i, pressed) in pressed.into_iter().enumerate() {
            if !pressed {
                self.measure(&[(T_C + i, 1.0)], 0.0, OPEN * OPEN);
            }
        }
    }

    /// Corrects by a measurement `z` of hᵀ x, with variance `r`; returns innovation² over its variance.
    pub fn measure(&mut self, h: Terms<'_>, z: f64, r: f64) -> f64 {
        self.belief.correct(h, z - along(h, &self.belief.x), r)
    }

    /// After the correction: friction, and whether the inputs make sense.
    pub fn watch(&mut self, now: &Instant<'_>, settings: &Settings, model: &Speeds, h: f64) {
        let (engaged, e) = (self.lock.engaged(), self.innovation_x(now.g));
        let x = &self.belief.x;
        let states = x.fixed_rows::<4>(0).into_owned();
        self.t_c = model.clutch_torques(&states, [x[T_C], x[T_C + 1]], now.sample.t_y);
        self.release(now);
        if settings.adapts {
            let mu_hat = self.mu_hat(now);
            self.friction.learn(now, engaged, mu_hat, h);
        }
        self.monitor.step(now, engaged, e, h);
        self.monitor.doubt(self.surprise, h);
    }

    /// μ̂ with the sign of the torque [1], shape (2).
    fn mu_hat(&self, now: &Instant<'_>) -> [f64; 2] {
        let lever = now.levers();
        [0, 1].map(|i| self.t_c[i] / lever[i].max(LEVER))
    }

    /// Innovation in the terms of (12), shape (2).
    fn innovation_x(&self, g: [f64; 2]) -> [f64; 2] {
        let [e, o, w] = self.innovation;
        [e - g[1] * o, o - w]
    }

    /// What is said of a sample that cannot be used.
    pub fn refuse(&self) -> Estimate {
        Estimate {
            t_o: self.belief.x[T_S],
            friction: self.friction.mu,
            engaged: self.lock.engaged(),
            ..Estimate::refused()
        }
    }

    /// What is said after a step, but for the friction that belongs to the torques; `c` of the drive shaft [N·m·s/rad].
    pub fn estimate(&self, now: &Instant<'_>, settings: &Settings, model: &Speeds) -> Estimate {
        let (x, c) = (&self.belief.x, model.c);
        let t_o = [(T_S, 1.0), (W_O, c), (W_W, -c)];
        let (engaged, fault) = (self.lock.engaged(), self.monitor.fault());
        let common = made(|y| say_common(y, settings, now, engaged, fault));
        Estimate {
            t_c: self.t_c,
            t_o: along(&t_o, x),
            t_v: x[T_V] + brake(now.p, now.sample),
            t_c_deviation: [0, 1].map(|i| {
                let other = if self.engaged == Some(i) { -1.0 } else { 0.0 };
                self.belief
                    .deviation(&[(T_C + i, 1.0), (T_C + 1 - i, other)])
            }),
            t_o_deviation: self.belief.deviation(&t_o),
            friction: self.friction.mu,
            innovation: self.innovation_x(now.g),
            consistency: self.surprise,
            ..common
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            belief,
            innovation,
            lock,
            engaged,
            t_c,
            friction,
            monitor,
            g,
            surprise,
            swing,
        } = self;
        belief.x.iter_mut().for_each(&mut *visit);
        belief.p.iter_mut().for_each(&mut *visit);
        innovation.iter_mut().for_each(&mut *visit);
        lock.visit(visit);
        visit_clutch(engaged, visit);
        t_c.iter_mut().for_each(&mut *visit);
        friction.visit(visit);
        monitor.visit(visit);
        g.iter_mut().for_each(&mut *visit);
        visit(surprise);
        swing.visit(visit);
    }
}

/// Visits which clutch, if any, as 0, 1 or 2.
fn visit_clutch(clutch: &mut Option<usize>, visit: Visit<'_>) {
    let codes = [(None, 0.0), (Some(0), 1.0), (Some(1), 2.0)];
    let mut code = codes[clutch.map_or(0, |i| i + 1)].1;
    visit(&mut code);
    *clutch = codes
        .iter()
        .find(|known| known.1 == code)
        .and_then(|known| known.0);
}
