//! Friction learnt while slipping: what a clutch control may rely on.
//!
//! In an engaged clutch (29) adapts μ·f to the torque that happens to flow, which says nothing of the
//! friction; and while both clutches transmit, speeds leave one direction of (T_c1, T_c2) nearly
//! undetermined (erratum E5). So μ̂ is taken from a clutch that slips well above its touch point while
//! the other is open, low-passed, and kept otherwise. Until a clutch has been seen alone, what both
//! tell together is better than the nominal value.

use crate::observer::instant::Instant;
use crate::observer::{Visit, lasting};
use nalgebra::ComplexField;

/// Slip above which a clutch certainly slips [rad/s].
const SLIP: f64 = 5.0;
/// Torque per unit of friction above which a clutch can be judged [N·m].
const LEVER: f64 = 20.0;
/// Time for which it has to slip before it is judged [s].
pub(super) const SETTLING: f64 = lasting(0.03);
/// Time constant of the low pass [s].
const TAU: f64 = 0.05;
/// Time a clutch has to be seen slipping alone before its friction is known [s].
const KNOWN: f64 = lasting(2.0 * TAU);

/// Friction learnt in both clutches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// μ̂ [1], shape (2).
    pub mu: [f64; 2],
    /// How long each clutch has been slipping [s], shape (2).
    pub slipping: [f64; 2],
    /// How long each clutch was seen slipping alone [s], shape (2), at most what makes it known.
    pub seen: [f64; 2],
}

impl Friction {
    /// Largest friction coefficient of any clutch lining [1].
    pub const PHYSICAL: f64 = 1.0;
    /// Static over kinetic friction of a clutch lining, at most [1].
    pub const STATIC: f64 = 1.2;
    /// Smallest friction coefficient a slipping clutch can have [1].
    const SMALLEST: f64 = 0.01;

    /// Nothing learnt yet: the nominal friction coefficients [1], shape (2).
    pub const fn nominal(mu_n: [f64; 2]) -> Self {
        Self {
            mu: mu_n,
            slipping: [0.0; 2],
            seen: [0.0; 2],
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { mu, slipping, seen } = self;
        mu.iter_mut().chain(slipping).chain(seen).for_each(visit);
    }

    /// The friction of clutch `i` was learnt, not assumed.
    pub fn known(&self, i: usize) -> bool {
        self.seen[i] >= KNOWN
    }

    /// Clutch `i` has slipped for long enough under a lever that its friction is taken.
    pub fn taken(&self, i: usize) -> bool {
        self.slipping[i] >= SETTLING
    }

    /// Clutches whose friction is to be adapted, shape (2), of those that are `pressed`.
    ///
    /// With both pressed the speeds leave one direction of the torques nearly undetermined (erratum E5), along
    /// which errors of the engaged clutch run into the other. So a clutch that slips with a friction that was
    /// learnt keeps it, and the other is determined.
    pub fn adapting(&self, pressed: [bool; 2], engaged: [bool; 2]) -> [bool; 2] {
        let both = pressed == [true; 2];
        [0, 1].map(|i| pressed[i] && !(both && !engaged[i] && self.known(i)))
    }

    /// Takes the adapted μ̂ of both clutches, signed like their torque, `h` [s] after the last; an engaged
    /// clutch tells nothing.
    pub fn learn(&mut self, now: &Instant<'_>, engaged: [bool; 2], mu_hat: [f64; 2], h: f64) {
        let (sample, lever) = (now.sample, now.levers());
        for (i, slip) in sample.slip().into_iter().enumerate() {
            let slips = slip.abs() > SLIP && lever[i] > LEVER && !engaged[i];
            self.slipping[i] = if slips {
                (self.slipping[i] + h).min(SETTLING)
            } else {
                0.0
            };
            let alone = lever[1 - i] <= 0.0;
            if !self.taken(i) || !alone && self.known(i) {
                continue;
            }
            let mu = (mu_hat[i] * slip.signum()).clamp(Self::SMALLEST, Self::PHYSICAL);
            self.mu[i] = mu + (self.mu[i] - mu) * ComplexField::exp(-h / TAU);
            if alone {
                self.seen[i] = (self.seen[i] + h).min(KNOWN);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Friction, KNOWN};

    #[test]
    fn in_a_handover_a_slipping_clutch_keeps_what_was_learnt_of_it() {
        let learnt = Friction {
            seen: [0.0, KNOWN],
            ..Friction::nominal([0.4, 0.1])
        };
        let cases = [
            ([true, true], [false, false], [true, false]),
            ([true, true], [false, true], [true, true]),
            ([false, true], [false, false], [false, true]),
            ([false, false], [false, false], [false, false]),
        ];
        for (pressed, engaged, expected) in cases {
            assert_eq!(learnt.adapting(pressed, engaged), expected, "{pressed:?}");
        }
    }
}
