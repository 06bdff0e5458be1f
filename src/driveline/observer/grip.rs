//! How the torque of each clutch moves: with its force while it slips, with the damper while it is engaged.
//!
//! A filter that takes T_c as a random walk must guess one pace for all of it. But a slipping clutch carries
//! μ F(θ) r_c N with a friction that hardly changes, and an engaged one carries what the damper does. What neither tells,
//! the moment around an engagement, is fast.

use crate::observer::Visit;
use crate::observer::instant::Instant;
use crate::observer::lock::{Lock, SLIP};

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
    /// It engages, or is open.
    Unsure,
    /// It holds both sides together, and carries what the damper carries.
    Engaged,
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
            Self::Unsure | Self::Engaged => 0.0,
        }
    }
}

/// What is remembered of both clutches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grip {
    /// r_c N F at the last sample [N·m], shape (2).
    pub lever: [f64; 2],
}

impl Grip {
    /// Takes the next sample; `engaged`: the clutch that is.
    pub fn step(&mut self, now: &Instant<'_>, lock: &Lock, engaged: Option<usize>) -> [Hold; 2] {
        let (levers, slip) = (now.levers(), now.sample.slip());
        [0, 1].map(|i| {
            let now = levers[i];
            let before = core::mem::replace(&mut self.lever[i], now);
            match lock.freed[i] || slip[i].abs() > SLIP {
                _ if engaged == Some(i) => Hold::Engaged,
                true => Hold::Slips { before, now },
                false => Hold::Unsure,
            }
        })
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { lever } = self;
        lever.iter_mut().for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::{Grip, Hold};
    use crate::Params;
    use crate::observer::Sample;
    use crate::observer::instant::Instant;
    use crate::observer::lock::Lock;
    use crate::params::Actuation;

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
        grip.step(
            &Instant::new(&p, &sample(5e-3, 40.0)),
            &Lock::default(),
            None,
        );
        let [hold, _] = grip.step(
            &Instant::new(&p, &sample(6e-3, 40.0)),
            &Lock::default(),
            None,
        );
        let lever = |force: f64| force * p.clutch[0].r_c_n;
        let (before, now) = (lever(1350.0), lever(2200.0));
        let torque = 0.26 * before;
        assert!(
            (hold.change(torque, 0.4) - 0.26 * (now - before)).abs() < 1e-9,
            "{hold:?}"
        );
    }

    /// One that was let go slips, however little.
    #[test]
    fn a_clutch_slips_as_its_lock_says() {
        let (p, mut grip, mut lock) = (Params::TABLE_1, Grip::default(), Lock::default());
        let sample = sample(5e-3, 0.3);
        let now = Instant::new(&p, &sample);
        let mut hold = |lock: &Lock, engaged| grip.step(&now, lock, engaged)[0];
        assert_eq!(hold(&lock, Some(0)), Hold::Engaged);
        assert_eq!(hold(&lock, None), Hold::Unsure);
        lock.bear(&p, 0, 100.0, 30.0, false);
        assert!(matches!(hold(&lock, None), Hold::Slips { .. }));
    }
}
