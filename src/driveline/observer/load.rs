//! Load torque T_v: from the grade (11), from the engine (20), or from momentum.
//!
//! (20) holds while one clutch is engaged and the other open. Through launch and shifts T_v keeps its
//! last value; before the first engagement it is that of (11). With E(t) the momentum seen at the
//! wheels,
//!
//! ```text
//! T_v = g T_e + T_y − dE/dt,   engine (20): E = J_v,eq ω_w,   momentum: E = g J_ed ω_e + J_out ω_o + J_v ω_w
//! ```
//!
//! The momentum form needs no rigid drive shaft, so it stays right while the driveline oscillates. Both
//! sides go through the same first-order filter. T_e acts over a whole step, over which E, known at its end, runs
//! straight: so the filtered derivative is (E − E_f) (e^{h/τ} − 1)/h, of which (E − E_f)/τ is short by h/(2τ), 5 % at
//! 10 ms. The filters begin at the load that was known before. Of the derivative, white noise
//! of the speeds passes with J_v σ/τ, 135 N·m for 0.1 rad/s. An observer averages that as long as it flows; what is
//! held through a shift has passed a second filter of the same τ, which leaves J_v σ √(h/4τ³), 7 N·m at 1 kHz.
//!
//! A gear that goes out or comes in takes its shaft's momentum with it at the speed it has, so the filtered one
//! moves by as much; T_y is what synchronisers do meanwhile.
//!
//! A brake torque that is measured is kept apart: it counts at once, also while the rest is held.
//!
//! Who takes the grade for T_v vouches for it, with (11): see [`LoadMethod::vouched`].

use crate::Params;
use crate::kept::Kept;
use crate::observer::instant::Instant;
use crate::observer::lock::Lock;
use crate::observer::{Sample, Visit, brake, lasting, visit_switch};
use nalgebra::ComplexField;

/// How the load torque is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadMethod {
    /// (11) with the measured grade and brake torque.
    Grade,
    /// (20).
    Engine,
    /// (20) with the momentum of every inertia.
    Momentum,
}

/// Share of T_v of (11) that is not known where the grade is vouched for [1]: mass, drag, rolling resistance.
const SHARE: f64 = 0.1;
/// Deviation of a grade that is vouched for [rad].
const SLOPE: f64 = 5e-3;

impl LoadMethod {
    /// Variance [(N·m)²] of `t_v`, T_v of (11) without a brake torque [N·m], where it is vouched for.
    pub fn vouched(self, p: &Params, t_v: f64) -> Option<f64> {
        let (share, slope) = (SHARE * t_v, SLOPE * p.road.weight() * p.road.r_w);
        (self == Self::Grade).then_some(share * share + slope * slope)
    }
}

/// τ: time constant of the filter on both sides of (20) [s].
const TAU: f64 = 0.1;
/// Time the filter settles after a clutch engaged before its output counts [s].
const SETTLING: f64 = lasting(3.0 * TAU);

/// The filter of (20) and the load it found last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Filtered momentum [N·m·s].
    pub momentum: f64,
    /// Filtered g T_e + T_y less the brake torque, at first less the derivative as well [N·m].
    pub torque: f64,
    /// J_out of the last sample [kg·m²].
    pub j_out: f64,
    /// Time since the filter was started [s]; negative while it does not run.
    pub running: f64,
    /// T_v without the brake torque [N·m]; meaningful when `found`.
    pub t_v: f64,
    /// The same behind the second filter: what is held [N·m].
    pub held: f64,
    /// An engagement was long enough to find T_v.
    pub found: bool,
    /// e^{−h/τ} of the last step h [s].
    forget: Kept<f64, f64>,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            momentum: 0.0,
            torque: 0.0,
            j_out: 0.0,
            running: -1.0,
            t_v: 0.0,
            held: 0.0,
            found: false,
            forget: Kept::NOTHING,
        }
    }
}

impl Load {
    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            momentum,
            torque,
            j_out,
            running,
            t_v,
            held,
            found,
            forget: _,
        } = self;
        for value in [momentum, torque, j_out, running, t_v, held] {
            visit(value);
        }
        visit_switch(found, visit);
    }

    /// T_v [N·m] at an instant `h` [s] after the last one.
    pub fn step(&mut self, now: &Instant<'_>, method: LoadMethod, lock: &Lock, h: f64) -> f64 {
        let Instant { p, sample, g, .. } = *now;
        let brake = brake(p, sample);
        let model = || p.road.load_torque(sample.omega_w, sample.phi) + brake;
        if method == LoadMethod::Grade {
            return model();
        }
        match lock.alone(now.force) {
            Some(engaged) => {
                let omega_o = output_speed(g, method, sample, engaged);
                self.follow_gears(p.j_out(g), omega_o);
                let momentum = match method {
                    LoadMethod::Engine => p.j_v_eq(g, engaged) * sample.omega_w,
                    _ => momentum(p, g, sample, engaged, omega_o),
                };
                let torque = g[engaged] * sample.t_e + sample.t_y - brake;
                let before = if self.found {
                    self.held
                } else {
                    model() - brake
                };
                self.filter(momentum, torque, before, h);
            }
            None => (self.running, self.t_v) = (-1.0, self.held),
        }
        if self.found {
            self.t_v + brake
        } else {
            model()
        }
    }

    /// The shafts that turn with the output at `omega_o` [rad/s] have J_out = `j_out` [kg·m²] now.
    fn follow_gears(&mut self, j_out: f64, omega_o: f64) {
        self.momentum += (j_out - self.j_out) * omega_o;
        self.j_out = j_out;
    }

    /// Takes E [N·m·s], the torque known to act on it [N·m], and T_v `before`, from which the filters begin [N·m].
    fn filter(&mut self, momentum: f64, torque: f64, before: f64, h: f64) {
        if self.running < 0.0 {
            (self.momentum, self.torque, self.running) = (momentum, before, 0.0);
            return;
        }
        let forget = self.forget.of(h, |h| ComplexField::exp(-h / TAU));
        self.momentum = momentum + (self.momentum - momentum) * forget;
        self.torque = torque + (self.torque - torque) * forget;
        self.running += h;
        if self.running >= SETTLING {
            let slope = (momentum - self.momentum) * (1.0 / forget - 1.0) / h;
            self.t_v = self.torque - slope;
            let memory = if self.found { TAU } else { 0.0 };
            self.held += (self.t_v - self.held) * (h / (h + memory));
            self.found = true;
        }
    }
}

/// E of (20) with the momentum of every inertia [N·m·s].
fn momentum(p: &Params, g: [f64; 2], sample: &Sample, engaged: usize, omega_o: f64) -> f64 {
    g[engaged] * p.j_ed() * sample.omega_e + p.j_out(g) * omega_o + p.j_v * sample.omega_w
}

/// Speed that J_out turns with in E [rad/s].
fn output_speed(g: [f64; 2], method: LoadMethod, sample: &Sample, engaged: usize) -> f64 {
    if method == LoadMethod::Engine {
        sample.omega_w
    } else {
        sample.omega_c[engaged] / g[engaged]
    }
}

#[cfg(test)]
mod tests {
    use super::{Load, LoadMethod, TAU};
    use crate::Params;
    use crate::observer::Sample;
    use crate::observer::instant::Instant;
    use crate::observer::lock::Lock;
    use crate::params::Actuation;

    /// T_v found `time` [s] after clutch 1 engaged, in steps of `h` [s], with 250 N·m to be found, and T_v that
    /// was known before [N·m].
    fn found(method: LoadMethod, h: f64, time: f64) -> [f64; 2] {
        const TRUE: f64 = 250.0;
        let (p, mut load) = (Params::TABLE_1, Load::default());
        let g = p.g([1, 2]);
        let slope = (g[0] * 60.0 - TRUE) / p.j_v_eq(g, 0);
        let sample = |time: f64| {
            let omega_w = 5.0 + slope * time;
            Sample {
                t_e: 60.0,
                omega_e: g[0] * omega_w,
                omega_c: g.map(|g| g * omega_w),
                omega_w,
                actuation: [9e-3, 0.0].map(|position| Actuation {
                    position,
                    pressure: 0.0,
                }),
                gear: [1, 2],
                ..Sample::default()
            }
        };
        let mut lock = Lock::default();
        lock.start(&p, &sample(0.0));
        let before = load.step(&Instant::new(&p, &sample(0.0)), method, &lock, 0.0);
        let steps = (1..).map(|k| f64::from(k) * h);
        let told = steps.take_while(|at| *at < time + 0.5 * h);
        let last = told.fold(0.0, |_, at| {
            load.step(&Instant::new(&p, &sample(at)), method, &lock, h)
        });
        [last, before]
    }

    /// A steady acceleration, of 2 m/s², leaves no error at any step.
    #[test]
    fn load_of_a_steady_acceleration_is_found_at_any_step() {
        for method in [LoadMethod::Engine, LoadMethod::Momentum] {
            for h in [1e-3, 1e-2, 2e-2] {
                let [t_v, _] = found(method, h, 3.0);
                assert!((t_v - 250.0).abs() < 1e-6, "{method:?} {h} s: {t_v} N·m");
            }
        }
    }

    /// Between what was known and what is found there is a first-order lag, no transient of the acceleration.
    #[test]
    fn load_begins_at_what_was_known() {
        let time: f64 = 0.4;
        let [t_v, before] = found(LoadMethod::Momentum, 1e-2, time);
        let expected = 250.0 + (before - 250.0) * (-time / TAU).exp();
        assert!((t_v - expected).abs() < 1e-6, "{t_v} of {expected} N·m");
    }
}
