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
//! locked once its slip has met 0, which a swing may take beyond the band before the next sample is taken, or stayed
//! small for a while; one that breaks away does neither. One that was found
//! to carry more than its friction ([`Lock::bear`]) slips until its slip has met 0, however small it is, and it carries
//! less than that: what would be let go at once does not lock. A
//! synchroniser on the other shaft kicks J_out against damper and drive shaft, by at most
//!
//! ```text
//! g_i T_y/√(J_out (g_i² k_d + k_o))                                                    from (4), (8), (10)
//! ```

use crate::Params;
use crate::observer::friction::Friction;
use crate::observer::instant::Instant;
use crate::observer::{Sample, Visit, lasting, visit_switch};
use nalgebra::ComplexField;

/// Slip below which a clutch may be engaged [rad/s].
pub const SLIP: f64 = 3.0;
/// Time constant of the slip that a clutch let go meets 0 with [s]: it is not noise.
const TAU: f64 = 0.01;
/// Part of its kinetic friction from which a clutch lets go in a handover [1]: what it carries is known to a tenth.
const HANDOVER: f64 = 0.9;
/// Such a slip that has a sign for sure [rad/s].
const SURE: f64 = 0.5;
/// Time for which it has to be, before a clutch is judged [s].
pub(super) const TIME: f64 = lasting(0.03);

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
    /// Slip through a low pass [rad/s], shape (2).
    pub slip: [f64; 2],
    /// It carried more than it can, and its slip has not met 0 since, shape (2).
    pub freed: [bool; 2],
    /// One let go has to be beyond 0 for a while, not once: of the method, not part of the state.
    pub wary: bool,
}

impl Default for Lock {
    fn default() -> Self {
        Self {
            since: [0.0; 2],
            swing: [0.0; 2],
            direction: [1.0; 2],
            met: [false; 2],
            slip: [0.0; 2],
            freed: [false; 2],
            wary: false,
        }
    }
}

impl Lock {
    /// At the start of a run a clutch that is pressed without slip has been so before.
    pub fn start(&mut self, p: &Params, sample: &Sample) {
        self.step(&Instant::new(p, sample), [0.0; 2], TIME);
    }

    /// Takes an instant `h` [s] after the last one; `t_c`: estimated torques of the clutches [N·m], shape (2).
    pub fn step(&mut self, now: &Instant<'_>, t_c: [f64; 2], h: f64) {
        let Instant { p, sample, g, .. } = *now;
        if sample.t_y != 0.0 {
            self.swing = [0, 1].map(|i| self.swing[i].max(kick(p, g, sample.t_y, i)));
        }
        let slips = self.slips(sample);
        for (i, slip) in sample.slip().into_iter().enumerate() {
            if slips[i] {
                (self.direction[i], self.freed[i]) = (slip.signum(), false);
            }
            let meets = self.meets(i, slip, h);
            let pressed = now.force[i] > 0.0;
            if pressed && !slips[i] && g[i] != 0.0 && (meets || !self.freed[i]) {
                self.since[i] = (self.since[i] + h).min(TIME);
                self.swing[i] *= ComplexField::exp(-h * p.c_d / (2.0 * p.j_e));
                self.met[i] |= meets && !(self.freed[i] && self.wary);
                self.freed[i] &= self.wary && self.since[i] < TIME;
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

    /// Whether the slip of clutch `i` [rad/s] has met 0; that of one let go is smoothed.
    fn meets(&mut self, i: usize, slip: f64, h: f64) -> bool {
        self.slip[i] += (slip - self.slip[i]) * (h / (h + TAU));
        if !(self.freed[i] && self.wary) {
            return slip * self.direction[i] <= 0.0;
        }
        if self.slip[i] * self.direction[i] < -SURE {
            self.direction[i] = -self.direction[i];
        }
        self.slip[i] * self.direction[i] <= 0.0
    }

    /// Clutch `i`, engaged, is found to carry `torque` and can carry `kinetic` while it slips [N·m]. It lets go where
    /// that is too much, or where it slips by more than its friction can make the damper swing.
    ///
    /// In a `handover` speeds leave both torques to each other (erratum E5), and a slip that is taken for a twist of
    /// the damper runs away in the other torque. One let go before does not lock while it carries as much against its slip.
    pub fn bear(&mut self, p: &Params, i: usize, torque: f64, kinetic: f64, handover: bool) {
        let (most, slip) = (
            if handover { HANDOVER } else { Friction::STATIC } * kinetic,
            self.slip[i],
        );
        if self.freed[i] {
            if torque * self.direction[i] > most {
                self.since[i] = 0.0;
            }
        } else if torque.abs() > most {
            self.let_go(i, if slip.abs() > SURE { slip } else { torque });
        } else if handover && slip.abs() > SURE + kinetic / ComplexField::sqrt(p.k_d * p.j_e) {
            self.let_go(i, slip);
        }
    }

    /// Clutch `i` slips in the direction of `of`.
    pub fn let_go(&mut self, i: usize, of: f64) {
        (self.since[i], self.met[i], self.freed[i]) = (0.0, false, true);
        self.direction[i] = of.signum();
    }

    /// The slip is beyond what a locked clutch shows, shape (2).
    pub fn slips(&self, sample: &Sample) -> [bool; 2] {
        let slip = sample.slip();
        [0, 1].map(|i| {
            let meets = slip[i] * self.direction[i] <= 0.0 && !self.freed[i];
            let swing = if self.holds(i) || meets {
                self.swing[i]
            } else {
                0.0
            };
            slip[i].abs() >= SLIP + swing
        })
    }

    /// Clutch `i` holds both sides together: its slip has met 0, or stayed small for a while.
    pub fn holds(&self, i: usize) -> bool {
        self.met[i] || self.since[i] >= TIME
    }

    /// The clutch that holds; of two, the one pressed harder.
    pub fn harder(&self, force: [f64; 2]) -> Option<usize> {
        match [0, 1].map(|i| self.holds(i)) {
            [true, true] => Some(usize::from(force[1] > force[0])),
            [true, false] => Some(0),
            [false, true] => Some(1),
            [false, false] => None,
        }
    }

    /// Fully engaged clutches, shape (2).
    pub fn engaged(&self) -> [bool; 2] {
        self.since.map(|since| since >= TIME)
    }

    /// The one clutch that is engaged while the other is open: (20) holds.
    pub fn alone(&self, force: [f64; 2]) -> Option<usize> {
        let open = force.map(|force| force <= 0.0);
        match (self.engaged(), open) {
            ([true, _], [_, true]) => Some(0),
            ([_, true], [true, _]) => Some(1),
            _ => None,
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            since,
            swing,
            direction,
            slip,
            met,
            freed,
            wary: _,
        } = self;
        let numbers = since.iter_mut().chain(swing);
        let all = numbers.chain(direction).chain(slip);
        all.for_each(&mut *visit);
        for switch in met.iter_mut().chain(freed) {
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
    use crate::observer::instant::Instant;
    use crate::params::Actuation;

    const H: f64 = 1e-3;

    /// A clutch that carried `t_c` [N·m] locks and the damper swings by `swing` [rad/s] for 1 s.
    fn stays_engaged(t_c: f64, swing: f64) -> bool {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        let mut step = |slip: f64| {
            lock.step(&Instant::new(&p, &sample(slip)), [t_c, 0.0], H);
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
            lock.step(&Instant::new(&p, &sample(slip)), [100.0, 0.0], H);
        }
        assert!(!lock.holds(0) && lock.slips(&sample(4.0))[0]);
    }

    #[test]
    fn a_clutch_that_was_let_go_slips_until_its_slip_meets_0() {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        lock.start(&p, &sample(0.0));
        lock.bear(&p, 0, 20.0, 15.0, false);
        for _ in 0..100 {
            lock.step(&Instant::new(&p, &sample(0.5)), [20.0, 0.0], H);
            assert!(!lock.holds(0));
        }
        for _ in 0..100 {
            lock.step(&Instant::new(&p, &sample(-0.1)), [20.0, 0.0], H);
        }
        assert!(lock.holds(0));
    }

    /// 15 N·m of friction swing the damper by 0.7 rad/s; a slip of 2 rad/s is more.
    #[test]
    fn a_slip_beyond_what_friction_can_swing_lets_go_in_a_handover() {
        let p = Params::TABLE_1;
        for (slip, handover, holds) in [(2.0, true, false), (1.0, true, true), (2.0, false, true)] {
            let mut lock = Lock::default();
            lock.start(&p, &sample(0.0));
            for _ in 0..100 {
                lock.step(&Instant::new(&p, &sample(slip)), [10.0, 0.0], H);
            }
            lock.bear(&p, 0, 10.0, 15.0, handover);
            assert_eq!(lock.holds(0), holds, "{slip} rad/s, {handover}");
        }
    }

    /// On the verge of slipping: the damper winds one way while the torque is that of a slip the other way.
    #[test]
    fn a_clutch_that_carries_what_it_was_let_go_at_does_not_lock() {
        const KINETIC: f64 = 80.0;
        let p = Params::TABLE_1;
        for (torque, holds) in [(-78.0, false), (-60.0, true), (78.0, true)] {
            let mut lock = Lock {
                wary: true,
                ..Lock::default()
            };
            lock.start(&p, &sample(0.0));
            lock.bear(&p, 0, -78.0, KINETIC, true);
            assert!(lock.freed[0] && lock.direction[0] < 0.0);
            for _ in 0..100 {
                lock.step(&Instant::new(&p, &sample(0.15)), [torque, 0.0], H);
                if lock.freed[0] {
                    lock.bear(&p, 0, torque, KINETIC, true);
                }
            }
            assert_eq!(lock.holds(0), holds, "{torque} N·m");
        }
    }

    /// 190 N·m lock between two samples of 100 Hz, and the swing shows at once as a slip the other way.
    #[test]
    fn a_slip_that_has_met_0_may_swing_from_the_first_sample_on() {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        for slip in [12.0, 6.0, 1.0, -4.7] {
            lock.step(&Instant::new(&p, &sample(slip)), [190.0, 0.0], 1e-2);
        }
        assert!(lock.holds(0) && lock.direction[0] > 0.0);
        lock.step(&Instant::new(&p, &sample(-20.0)), [190.0, 0.0], 1e-2);
        assert!(!lock.holds(0) && lock.direction[0] < 0.0);
    }

    #[test]
    fn more_than_the_torque_explains_is_slip() {
        assert!(!stays_engaged(20.0, 6.0));
    }
}
