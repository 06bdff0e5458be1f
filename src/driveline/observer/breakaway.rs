//! The moment when an engaged clutch begins to slip whose friction was never seen: `energy`.
//!
//! A learnt friction tells what a clutch can carry. Of one that was engaged from the start nothing is known but this:
//! it carried every |T_ci|/w_i so far, so it lets go at the largest one, and that is its static friction,
//!
//! ```text
//! μ_s ≥ |T_ci|/w_i while engaged, with equality where it breaks away;   μ_k ≥ μ_s/1.2 for any lining
//! ```
//!
//! From then on its slip, taken for a twist of the damper, asks for more torque than there is, and the slip that is
//! measured runs away from the one of the model, s̃ = ω̃_e − g_i ω̃_o, in the direction of the torque. Through a low pass
//! of 10 ms s̃ is beyond noise at 0.5 rad/s, which takes some 20 ms; a slip of 3 rad/s that no swing explains takes 70 ms.

use crate::observer::Visit;
use crate::observer::friction::Friction;

/// Time constant of s̃ [s].
const TAU: f64 = 0.01;
/// s̃ that is neither noise nor the error of a damper [rad/s].
const SURE: f64 = 0.5;

/// What both clutches have carried.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BreakAway {
    /// Largest |T_ci|/w_i while engaged [1], shape (2).
    pub most: [f64; 2],
    /// s̃ through a low pass [rad/s], shape (2).
    pub apart: [f64; 2],
}

impl BreakAway {
    /// Whether clutch `i`, engaged with `lever` w_i [N·m] and found to carry `t_c` [N·m], has begun to slip, `h` [s]
    /// after the last sample; `apart`: s̃ [rad/s].
    pub fn step(&mut self, i: usize, lever: f64, t_c: f64, apart: f64, h: f64) -> bool {
        self.apart[i] += (apart - self.apart[i]) * (h / (h + TAU));
        let carried = t_c.abs() / lever;
        let most = carried >= self.most[i];
        self.most[i] = self.most[i].max(carried);
        most && self.apart[i] * t_c.signum() > SURE
    }

    /// Clutch `i` is not watched: it is open, slips, or its friction is known.
    pub fn rest(&mut self, i: usize) {
        self.apart[i] = 0.0;
    }

    /// Kinetic friction of clutch `i` from what it has carried [1]; nothing if it has carried nothing.
    pub fn friction(&self, i: usize) -> Option<f64> {
        let mu = self.most[i] / Friction::STATIC;
        (mu > 0.0).then_some(mu.min(Friction::PHYSICAL))
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { most, apart } = self;
        most.iter_mut().chain(apart).for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::BreakAway;

    const H: f64 = 1e-3;
    const LEVER: f64 = 400.0;

    /// Time [s] after which a clutch is found to slip that has carried 100 N·m and then `t_c` [N·m], s̃ by the time.
    fn found(t_c: f64, apart: impl Fn(f64) -> f64) -> Option<f64> {
        let mut clutch = BreakAway::default();
        assert!(!clutch.step(1, LEVER, 100.0, 0.0, H));
        let times = (1..1000).map(|k| f64::from(k) * H);
        times
            .into_iter()
            .find(|time| clutch.step(1, LEVER, t_c, apart(*time), H))
    }

    #[test]
    fn a_clutch_that_slips_at_the_most_it_carried_is_found() {
        let time = found(101.0, |time| 40.0 * time).expect("found");
        assert!(time < 0.03, "{time} s");
    }

    #[test]
    fn one_that_carried_more_before_is_not() {
        assert_eq!(found(99.0, |time| 40.0 * time), None);
    }

    #[test]
    fn noise_and_a_slip_against_the_torque_are_none() {
        assert_eq!(found(101.0, |time| 0.4 * (1e3 * time).sin()), None);
        assert_eq!(found(101.0, |time| -40.0 * time), None);
    }

    #[test]
    fn what_was_carried_tells_the_friction() {
        let mut clutch = BreakAway::default();
        assert_eq!(clutch.friction(0), None);
        clutch.step(0, LEVER, -120.0, 0.0, H);
        assert!(
            clutch
                .friction(0)
                .is_some_and(|mu| (mu - 0.25).abs() < 1e-12)
        );
    }
}
