//! How `kalman` and `calibrating` see the clutches carry their torques.
//!
//! ```text
//! slips:     T_ci moves with its force, T_ci' = T_ci F'/F, and its friction walks: q = q_T T_ci²
//! engaged:   T_k takes the place of T_ci, what the damper carries:          T_k' = k_d (ω_e − g_i ω_o)
//! let go:    its friction may fall from static to kinetic:                  q += (μ_s/μ_k − 1)² T_ci²/t
//! neither:   for the moment T_ci is a fast random walk
//! ```
//!
//! Behind the damper stand J_e and J_out + g_i² J_d, as in [`damper`](crate::observer::damper), and
//!
//! ```text
//! T_ci = T_k + c_d (ω_e − g_i ω_o) − T_cj − J_d g_i ω_o'
//! ```
//!
//! so an engaged clutch swings with the damper after a lock-up or a gear change, and what the other one does in a
//! handover does not move T_k. A random walk fast enough for the swing, 1400 N·m/s, lags by 10 N·m and lets the noise in.
//!
//! A clutch that was found to carry more than it can ([`release`](Tracker::release)) breaks away at once, or a few
//! hundredths of a second later, t, which no speed tells before: its torque then falls within a step.
//!
//! The stiffness is not known to the last: T_k walks by a part of what the damper winds. Behind a clutch whose friction
//! is not known that part is all of it, as what looks like a twist may be its slip.

use crate::Params;
use crate::observer::friction::Friction;
use crate::observer::grip::Hold;
use crate::observer::instant::Instant;
use crate::observer::lock::TIME;
use crate::observer::speeds::Speeds;
use crate::observer::swing::Swing;
use crate::observer::tracker::{OPEN, T_C, Tracker, W_E, W_O};
use nalgebra::SVector;

/// Intensity of T_c of a clutch that engages or lets go [(N·m)²/s].
const UNSURE: f64 = 4000.0;
/// Relative intensity of T_c of a clutch that was let go [1/s].
const BREAKS: f64 = (Friction::STATIC - 1.0) * (Friction::STATIC - 1.0) / TIME;
/// Relative deviation of a friction that was learnt earlier [1].
const REMEMBERED: f64 = 0.15;
/// Time for which its error lasts [s].
const LASTS: f64 = 0.1;
/// Intensity of T_k of the damper behind an engaged clutch [(N·m)²/s].
const DAMPER: f64 = 1.0;
/// Relative error of what the damper winds [1]: friction of the clutch behind it known, and not.
const STIFFNESS: [f64; 2] = [0.2, 1.0];
/// Time for which it acts in one direction: a quarter of a swing [s].
const SWING: f64 = 0.05;
/// Relative deviation of the torque that a change of force brings [1]: friction known, and not.
const FORCE: [f64; 2] = [0.3, 1.0];

impl<const N: usize> Tracker<N> {
    /// T_k = T_c1 + T_c2 takes the place of T_ci where clutch i engages, and gives it back where it lets go.
    pub fn engage(&mut self, now: &Instant<'_>) {
        let engaged = self.lock.harder(now.force);
        if engaged != self.engaged {
            self.belief.x[W_E] += self.swings(now);
            for (clutch, sign) in [(self.engaged, -1.0), (engaged, 1.0)] {
                if let Some(i) = clutch {
                    self.belief.add(T_C + i, T_C + 1 - i, sign);
                }
            }
            if engaged.is_none() {
                let x = &self.belief.x;
                self.swing = Swing::rest(now.p, now.sample.t_e, x[T_C] + x[T_C + 1]);
            }
            self.engaged = engaged;
        }
    }

    /// What the swing of the damper adds to ω_e of the filter [rad/s].
    pub(super) fn swings(&self, now: &Instant<'_>) -> f64 {
        if self.engaged.is_some() || now.pressed() == [true; 2] {
            return 0.0;
        }
        self.swing.shown
    }

    /// Lets the damper swing over a step `h` [s]; `t_e`: of the engine [N·m].
    pub fn swing(&mut self, p: &Params, model: &Speeds, t_e: f64, h: f64) {
        if self.engaged.is_none() {
            let (x, j_e) = (&self.belief.x, model.j_ed * p.j_e / p.j_ed());
            self.swing.step(p, j_e, [t_e, x[T_C] + x[T_C + 1]], h);
        }
    }

    /// T_c of a slipping clutch moves with its force.
    pub fn follow_force(&mut self, hold: [Hold; 2]) {
        let Self {
            belief,
            friction,
            lock,
            swing,
            ..
        } = self;
        for (i, hold) in hold.into_iter().enumerate() {
            let before = belief.x[T_C + i];
            let known = friction.mu[i] * lock.direction[i];
            let after = before + hold.change(before, known);
            let relative = FORCE[usize::from(!friction.known(i))];
            belief.x[T_C + i] = after;
            swing.load += after - before;
            belief.p[(T_C + i, T_C + i)] +=
                relative * relative * (after * after - before * before).abs();
        }
    }

    /// Intensities of T_c1, T_c2 [(N·m)²/s] in those of all states `q`, shape (N), where they are relative [1/s].
    pub fn noise(&self, model: &Speeds, hold: [Hold; 2], q: &mut SVector<f64, N>) {
        let [e, o] = model.twist();
        let x = &self.belief.x;
        let rate = e * x[W_E] + o * x[W_O];
        for i in [0, 1] {
            match hold[i] {
                Hold::Slips { now, .. } => {
                    let torque = x[T_C + i].abs().max(self.friction.mu[i] * now);
                    let breaks = if self.lock.freed[i] { BREAKS } else { 0.0 };
                    q[T_C + i] = (q[T_C + i] + breaks) * torque * torque;
                }
                Hold::Unsure => q[T_C + i] = UNSURE,
                Hold::Engaged => {
                    let wrong = rate * STIFFNESS[usize::from(!self.friction.known(i))];
                    q[T_C + i] = DAMPER + wrong * wrong * SWING;
                }
            }
        }
    }

    /// In a handover, where speeds leave one direction of both torques nearly undetermined (erratum E5), a clutch that
    /// slips carries what its friction, if it was learnt, makes of its force.
    pub fn remember(&mut self, now: &Instant<'_>, hold: [Hold; 2], h: f64) {
        if now.pressed() != [true; 2] {
            return;
        }
        for (i, hold) in hold.into_iter().enumerate() {
            if let (Hold::Slips { now, .. }, true) = (hold, self.friction.known(i)) {
                let torque = self.friction.mu[i] * now * self.lock.direction[i];
                let sigma = REMEMBERED * torque.abs() + OPEN;
                self.measure(
                    &[(T_C + i, 1.0)],
                    torque,
                    sigma * sigma * (LASTS / h).max(1.0),
                );
            }
        }
    }

    /// A clutch of a known friction that would carry more than it can slips, and goes on slipping while it would.
    pub fn release(&mut self, now: &Instant<'_>) {
        let lever = now.levers();
        for i in [0, 1] {
            if !self.friction.known(i) || self.engaged != Some(i) && !self.lock.freed[i] {
                continue;
            }
            let handover = now.force[1 - i] > 0.0;
            let kinetic = self.friction.mu[i] * lever[i];
            self.lock.bear(now.p, i, self.t_c[i], kinetic, handover);
        }
    }
}
