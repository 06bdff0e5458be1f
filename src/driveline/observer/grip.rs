//! How the torque of each clutch moves: with its force while it slips, with the driveline while it is engaged.
//!
//! A filter that takes T_c as a random walk must guess one pace for all of it. But a slipping clutch carries
//! μ F(θ) r_c N with a friction that hardly changes, and an engaged one carries what keeps both sides together
//! (6). What neither tells, the 30 ms around an engagement, is fast.

use crate::Params;
use crate::observer::lock::SLIP;
use crate::observer::{Sample, Visit, lasting};

/// Time constant of the filtered slip [s].
const TAU: f64 = 0.01;
/// Filtered slip of a clutch that holds [rad/s]: above its noise, below the first wind-up of a damper. While a
/// synchroniser shakes the damper none does.
const HOLDS: f64 = 0.25;
/// Time for which an engaged clutch has to hold before its torque is a constraint [s].
const FIRM: f64 = lasting(0.1);
/// Lever from which the torque tells a friction [N·m].
const LEVER: f64 = 20.0;

/// How a clutch carries its torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hold {
    /// It slips: friction times a lever [N·m] that was `before` and is `now`.
    Slips {
        /// r_c N F of the last sample [N·m].
        before: f64,
        /// r_c N F of this sample [N·m].
        now: f64,
    },
    /// It engages, or lets go, or is open.
    Unsure,
    /// It holds both sides together.
    Firm,
}

impl Hold {
    /// Change of the torque of a slipping clutch whose torque is `t_c` [N·m].
    ///
    /// `known`: friction with the sign of the slip where the torque is too small to tell one [1].
    pub fn change(self, t_c: f64, known: f64) -> f64 {
        match self {
            Self::Slips { before, now } if before > LEVER => {
                (t_c / before).clamp(-1.0, 1.0) * (now - before)
            }
            Self::Slips { before, now } => known * (now - before),
            Self::Unsure | Self::Firm => 0.0,
        }
    }
}

/// What is remembered of both clutches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grip {
    /// r_c N F at the last sample [N·m], shape (2).
    pub lever: [f64; 2],
    /// Filtered slip [rad/s], shape (2).
    pub slip: [f64; 2],
    /// Time for which each clutch has held [s], shape (2), at most what makes it firm.
    pub held: [f64; 2],
}

impl Grip {
    /// Takes a sample `h` [s] after the last one; `engaged`: engaged clutches, shape (2).
    pub fn step(&mut self, p: &Params, sample: &Sample, engaged: [bool; 2], h: f64) -> [Hold; 2] {
        [0, 1].map(|i| {
            let now = p.clutch[i].force(sample.actuation[i]) * p.clutch[i].r_c_n;
            let before = core::mem::replace(&mut self.lever[i], now);
            let slip = sample.slip()[i];
            self.slip[i] += (slip - self.slip[i]) * (h / (h + TAU));
            let shaken = sample.t_y != 0.0;
            let holds = engaged[i] && self.slip[i].abs() < HOLDS && !shaken;
            self.held[i] = if holds {
                (self.held[i] + h).min(FIRM)
            } else {
                0.0
            };
            match engaged[i] {
                true if self.held[i] >= FIRM => Hold::Firm,
                false if slip.abs() > SLIP => Hold::Slips { before, now },
                _ => Hold::Unsure,
            }
        })
    }

    /// The firm clutch whose torque is a constraint; of two, the one pressed harder.
    pub fn firm(&self) -> Option<usize> {
        match self.held.map(|held| held >= FIRM) {
            [true, true] => Some(usize::from(self.lever[1] > self.lever[0])),
            [true, false] => Some(0),
            [false, true] => Some(1),
            [false, false] => None,
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { lever, slip, held } = self;
        lever.iter_mut().chain(slip).chain(held).for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::{Grip, Hold};
    use crate::Params;
    use crate::observer::Sample;
    use crate::params::Actuation;

    const H: f64 = 1e-3;

    fn sample(position: f64, slip: f64) -> Sample {
        Sample {
            omega_e: 100.0 + slip,
            omega_c: [100.0, 64.0],
            gear: [1, 2],
            actuation: [position, 0.0].map(|position| Actuation {
                position,
                pressure: 0.0,
            }),
            ..Sample::default()
        }
    }

    #[test]
    fn a_slipping_clutch_moves_with_its_force() {
        let (p, mut grip) = (Params::TABLE_1, Grip::default());
        grip.step(&p, &sample(5e-3, 40.0), [false; 2], H);
        let [hold, _] = grip.step(&p, &sample(6e-3, 40.0), [false; 2], H);
        let lever = |force: f64| force * p.clutch[0].r_c_n;
        let (before, now) = (lever(1350.0), lever(2200.0));
        let torque = 0.26 * before;
        assert!(
            (hold.change(torque, 0.4) - 0.26 * (now - before)).abs() < 1e-9,
            "{hold:?}"
        );
    }

    #[test]
    fn a_clutch_is_firm_once_it_has_held_for_a_while_and_not_when_it_lets_go() {
        let (p, mut grip) = (Params::TABLE_1, Grip::default());
        for k in 0..99 {
            let [hold, _] = grip.step(&p, &sample(9e-3, 0.05), [true, false], H);
            assert_eq!(hold, Hold::Unsure, "{k}");
        }
        grip.step(&p, &sample(9e-3, 0.05), [true, false], H);
        assert_eq!(grip.firm(), Some(0));
        for _ in 0..4 {
            grip.step(&p, &sample(9e-3, 2.0), [true, false], H);
        }
        assert_eq!(grip.firm(), None);
    }
}
