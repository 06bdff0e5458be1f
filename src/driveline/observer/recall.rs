//! What is known of ε̂ from one sample to the next, before (29) corrects it: `paper` and `lyapunov`.
//!
//! The paper takes ε̂ as slow, ε̂' ≈ 0. But T̂_c = (μ_n f_n + ε̂) r_c N θ_m, and what stays or is known to move is
//!
//! ```text
//! slips:     its friction, once it was learnt or where it slips alone:  μ̂ = μ_n + ε̂/f_n stays
//! engaged:   its torque, that of the damper (1)-(3):    ΔT_ci = k_d h s + c_d Δs − ΔT_cj,   s = ω_e − ω_ci
//! ```
//!
//! ω_d is not measured, but of an engaged clutch ω_d = ω_ci, so the speeds of engine and input shaft are those of the
//! damper's two ends (J_d, behind it, is small). Over a step such a torque rises by ΔT_ci, where that of a slipping
//! clutch is held with its force. With this (29) has nothing to follow: a torque that moved while ε̂
//! was held left x̃1 and x̃2, and with them an error of x̂3 that takes seconds to go in a light gearbox. The errors ε̃
//! move as before: where T_c moves as it is known to, ε̃' = −ε̂' of (29), which is what the proof of `lyapunov` needs.

use crate::Params;
use crate::observer::adaptive::Adaptive;
use crate::observer::friction::Friction;
use crate::observer::lever::Lever;
use crate::observer::{Sample, within};
use nalgebra::Vector2;

impl Adaptive {
    /// Moves ε̂ to the levers of a sample `h` [s] after the last one, from which `engaged` is.
    ///
    /// Returned is what the torques of engaged clutches rose by over the step [N·m], shape (2).
    pub(super) fn recall(
        &mut self,
        p: &Params,
        mu_n: [f64; 2],
        sample: &Sample,
        levers: &[Lever; 2],
        engaged: [bool; 2],
        h: f64,
    ) -> Vector2<f64> {
        let last = [0, 1].map(|i| Lever {
            arm: self.arm[i],
            f_n: self.f_n[i],
        });
        let before = self.carried(mu_n, &last);
        let beyond = self.lock.slips(sample);
        for i in (0..2).filter(|i| beyond[*i] && levers[*i].f_n > 0.0) {
            let alone = levers[1 - i].f_n == 0.0;
            self.keep_friction(
                i,
                mu_n[i],
                sample.slip()[i],
                levers[i].f_n,
                engaged[i],
                alone,
            );
        }
        let wound = self.wound(p, sample, h);
        let (now, mut rise) = (self.carried(mu_n, levers), Vector2::zeros());
        for (i, j) in [(0, 1), (1, 0)] {
            let swings = self.friction.known(i) || sample.slip()[i].abs() <= self.lock.swing[i];
            let engaged = last[i].f_n > 0.0 && self.lock.holds(i) && !beyond[i] && swings;
            let open = last[j].f_n == 0.0 && levers[j].f_n == 0.0;
            if engaged && (open || beyond[j] && self.friction.known(j)) {
                let torque = before[i] + wound[i] - (now[j] - before[j]);
                self.keep_torque(i, mu_n[i], &levers[i], torque);
                rise[i] = self.carried(mu_n, levers)[i] - before[i];
            }
        }
        self.slip = sample.slip();
        (self.f_n, self.arm) = (levers.map(|lever| lever.f_n), levers.map(|lever| lever.arm));
        rise
    }

    /// T̂_c of ε̂ at given levers [N·m], shape (2).
    fn carried(&self, mu_n: [f64; 2], levers: &[Lever; 2]) -> [f64; 2] {
        [0, 1].map(|i| (mu_n[i] * levers[i].f_n + self.epsilon[i]) * levers[i].arm)
    }

    /// Clutch `i` slips under force: μ̂ stays, where it is one.
    ///
    /// A clutch that begins to slip takes the friction learnt in its last slip, against the slip. In a handover what an
    /// unknown friction adapted to runs along the undetermined direction (erratum E5) and is none.
    ///
    /// Deviation: the paper takes ε̂ as slow (ε̇ ≈ 0), but f_n changes with the position, so ε̂ of a wrong
    /// friction does too; and it lets (29) find each slip anew, from what it adapted in the engaged
    /// clutch, with the wrong sign where the slip is negative (erratum E8).
    fn keep_friction(
        &mut self,
        i: usize,
        mu_n: f64,
        slip: f64,
        f_n: f64,
        engaged: bool,
        alone: bool,
    ) {
        let (before, known) = (self.f_n[i], self.friction.known(i));
        let begins = before == 0.0 || engaged;
        if begins && known {
            self.epsilon[i] = (self.friction.mu[i] * slip.signum() - mu_n) * f_n;
        } else if !begins && (known || alone) {
            self.epsilon[i] *= f_n / before;
        }
    }

    /// What the damper wound behind an engaged clutch since the last sample [N·m], shape (2).
    fn wound(&self, p: &Params, sample: &Sample, h: f64) -> [f64; 2] {
        let slip = sample.slip();
        [0, 1].map(|i| {
            let mean = 0.5 * (self.slip[i] + slip[i]);
            p.k_d * h * mean + p.c_d * (slip[i] - self.slip[i])
        })
    }

    /// ε̂ of the engaged clutch `i` that carries `torque` [N·m], up to what its friction can.
    ///
    /// Deviation: with ε̂' ≈ 0 the torque of a clutch that is pressed home after it engaged rose with f_n, and (29) had
    /// to take it back, as it had to find every change of the torque that flows. In a handover with a clutch of an
    /// unknown friction it still falls with f_n: there the other clutch takes over, and what it carries is not known.
    fn keep_torque(&mut self, i: usize, mu_n: f64, lever: &Lever, torque: f64) {
        if lever.f_n > 0.0 {
            let mu = if self.friction.known(i) {
                Friction::STATIC * self.friction.mu[i]
            } else {
                Friction::PHYSICAL
            };
            let kept = within(torque / lever.arm, -mu * lever.f_n, mu * lever.f_n);
            self.epsilon[i] = kept - mu_n * lever.f_n;
        }
    }
}
