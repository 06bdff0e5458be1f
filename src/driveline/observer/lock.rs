//! Which clutches are fully engaged, from measured slip and actuators.
//!
//! What is measured before a clutch is ω_e, not ω_d of (2). When a slipping clutch locks, its torque falls from
//! μ F r_c N to what the driveline needs, and the damper swings: ω_e − ω_ci, 0 behind the damper, reaches
//!
//! ```text
//! ΔT_c/√(k_d J_e), and dies with the time constant 2 J_e/c_d                    from (1), (3)
//! ```
//!
//! which a large torque takes beyond any fixed threshold. So a clutch that has locked may swing by as much. It has
//! locked once its slip has met 0, or stayed small for a while; one that breaks away does neither. One that was found
//! to carry more than its friction ([`Lock::let_go`]) slips until its slip meets 0, however small that is. A
//! synchroniser on the other shaft kicks J_out against damper and drive shaft, by at most
//!
//! ```text
//! g_i T_y/√(J_out (g_i² k_d + k_o))                                                    from (4), (8), (10)
//! ```

use crate::Params;
use crate::observer::{Sample, Visit, lasting, visit_switch};
use nalgebra::ComplexField;

/// Slip below which a clutch may be engaged [rad/s].
pub const SLIP: f64 = 3.0;
/// Time for which it has to be [s].
const TIME: f64 = lasting(0.03);

/// What the slip of each clutch has told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lock {
    /// Time pressed without slip [s], shape (2), at most the time that it takes.
    pub since: [f64; 2],
    /// Swing of the damper that may show as slip [rad/s], shape (2).
    pub swing: [f64; 2],
    /// sgn of the slip seen last beyond the band of an engaged clutch, shape (2).
    pub direction: [f64; 2],
    /// The slip has met 0 and stayed small since, shape (2).
    pub met: [bool; 2],
    /// It carried more than it can, and its slip has not met 0 since, shape (2).
    pub freed: [bool; 2],
}

impl Default for Lock {
    fn default() -> Self {
        Self {
            since: [0.0; 2],
            swing: [0.0; 2],
            direction: [1.0; 2],
            met: [false; 2],
            freed: [false; 2],
        }
    }
}

impl Lock {
    /// At the start of a run a clutch that is pressed without slip has been so before.
    pub fn start(&mut self, p: &Params, sample: &Sample) {
        self.step(p, sample, [0.0; 2], TIME);
    }

    /// Takes a sample `h` [s] after the last one; `t_c`: estimated torques of the clutches [N·m], shape (2).
    pub fn step(&mut self, p: &Params, sample: &Sample, t_c: [f64; 2], h: f64) {
        let g = p.g(sample.gear);
        if sample.t_y != 0.0 {
            self.swing = [0, 1].map(|i| self.swing[i].max(kick(p, g, sample.t_y, i)));
        }
        let slips = self.slips(sample);
        for (i, slip) in sample.slip().into_iter().enumerate() {
            if slips[i] {
                (self.direction[i], self.freed[i]) = (slip.signum(), false);
            }
            let meets = slip * self.direction[i] <= 0.0;
            let pressed = p.clutch[i].force(sample.actuation[i]) > 0.0;
            if pressed && !slips[i] && g[i] != 0.0 && (meets || !self.freed[i]) {
                self.since[i] = (self.since[i] + h).min(TIME);
                self.swing[i] *= ComplexField::exp(-h * p.c_d / (2.0 * p.j_e));
                (self.met[i], self.freed[i]) = (self.met[i] || meets, false);
            } else {
                (self.since[i], self.met[i]) = (0.0, false);
                self.swing[i] = if t_c[i] == 0.0 {
                    0.0 // of open clutches: there is no root to draw
                } else {
                    t_c[i].abs() / ComplexField::sqrt(p.k_d * p.j_e)
                };
            }
        }
    }

    /// Clutch `i` carries more than its friction can, in the direction of `torque`: it slips.
    pub fn let_go(&mut self, i: usize, torque: f64) {
        (self.since[i], self.met[i], self.freed[i]) = (0.0, false, true);
        self.direction[i] = torque.signum();
    }

    /// The slip is beyond what a locked clutch shows, shape (2).
    pub fn slips(&self, sample: &Sample) -> [bool; 2] {
        let slip = sample.slip();
        [0, 1].map(|i| {
            let swing = if self.holds(i) { self.swing[i] } else { 0.0 };
            slip[i].abs() >= SLIP + swing
        })
    }

    /// Clutch `i` holds both sides together: its slip has met 0, or stayed small for a while.
    pub fn holds(&self, i: usize) -> bool {
        self.met[i] || self.since[i] >= TIME
    }

    /// Fully engaged clutches, shape (2).
    pub fn engaged(&self) -> [bool; 2] {
        self.since.map(|since| since >= TIME)
    }

    /// The one clutch that is engaged while the other is open: (20) holds.
    pub fn alone(&self, p: &Params, sample: &Sample) -> Option<usize> {
        let open = [0, 1].map(|i| p.clutch[i].force(sample.actuation[i]) <= 0.0);
        match (self.engaged(), open) {
            ([true, _], [_, true]) => Some(0),
            ([_, true], [true, _]) => Some(1),
            _ => None,
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let numbers = self.since.iter_mut().chain(&mut self.swing);
        numbers.chain(&mut self.direction).for_each(&mut *visit);
        for switch in self.met.iter_mut().chain(&mut self.freed) {
            visit_switch(switch, visit);
        }
    }
}

/// Swing of the damper behind clutch `i` that synchronisers bring about [rad/s].
fn kick(p: &Params, g: [f64; 2], t_y: f64, i: usize) -> f64 {
    let stiffness = g[i] * g[i] * p.k_d + p.k_o;
    g[i].abs() * t_y.abs() / ComplexField::sqrt(p.j_out(g) * stiffness)
}

#[cfg(test)]
mod tests {
    use super::Lock;
    use crate::Params;
    use crate::observer::Sample;
    use crate::params::Actuation;

    const H: f64 = 1e-3;

    /// A clutch that carried `t_c` [N·m] locks and the damper swings by `swing` [rad/s] for 1 s.
    fn stays_engaged(t_c: f64, swing: f64) -> bool {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        let mut step = |slip: f64| {
            lock.step(&p, &sample(slip), [t_c, 0.0], H);
            lock.engaged()[0]
        };
        for k in 0..80 {
            step(8.0 - 0.1 * f64::from(k));
        }
        (0..1000).all(|k| {
            let time = f64::from(k) * H;
            step(-swing * f64::sin(28.0 * time) * f64::exp(-time))
        })
    }

    #[test]
    fn a_swing_of_the_damper_is_no_slip() {
        assert!(stays_engaged(140.0, 6.0));
    }

    /// Clutch 1 at a slip [rad/s].
    fn sample(slip: f64) -> Sample {
        Sample {
            omega_e: 100.0 + slip,
            omega_c: [100.0, 64.0],
            gear: [1, 2],
            actuation: [8e-3, 0.0].map(|position| Actuation {
                position,
                pressure: 0.0,
            }),
            ..Sample::default()
        }
    }

    /// A slip that grows past the band and reads small once, of noise, has not locked.
    #[test]
    fn one_small_sample_of_a_clutch_that_breaks_away_allows_no_swing() {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        lock.start(&p, &sample(0.0));
        assert!(lock.engaged()[0]);
        for slip in [2.5, 3.1, 2.9, 3.3, 4.0] {
            lock.step(&p, &sample(slip), [100.0, 0.0], H);
        }
        assert!(!lock.holds(0) && lock.slips(&sample(4.0))[0]);
    }

    #[test]
    fn a_clutch_that_was_let_go_slips_until_its_slip_meets_0() {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        lock.start(&p, &sample(0.0));
        lock.let_go(0, 20.0);
        for _ in 0..100 {
            lock.step(&p, &sample(0.5), [20.0, 0.0], H);
            assert!(!lock.holds(0));
        }
        lock.step(&p, &sample(-0.1), [20.0, 0.0], H);
        assert!(lock.holds(0) && lock.met[0]);
    }

    #[test]
    fn more_than_the_torque_explains_is_slip() {
        assert!(!stays_engaged(20.0, 6.0));
    }
}
