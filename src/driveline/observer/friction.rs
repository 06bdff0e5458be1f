//! Friction learnt while slipping: what a clutch control may rely on.
//!
//! In an engaged clutch (29) adapts μ·f to the torque that happens to flow, which says nothing of the
//! friction. So μ̂ is taken only from a clutch that slips well above its touch point, low-passed, and
//! kept otherwise.

use crate::Params;
use crate::observer::Sample;
use nalgebra::ComplexField;

/// Slip above which a clutch certainly slips [rad/s].
const SLIP: f64 = 5.0;
/// Torque per unit of friction above which a clutch can be judged [N·m].
const LEVER: f64 = 20.0;
/// Time constant of the low pass [s].
const TAU: f64 = 0.05;

/// μ̂ learnt in both clutches, shape (2) [1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction(pub [f64; 2]);

impl Friction {
    /// Largest friction coefficient of any clutch lining [1].
    pub const PHYSICAL: f64 = 1.0;
    /// Smallest friction coefficient a slipping clutch can have [1].
    const SMALLEST: f64 = 0.01;

    /// Takes the adapted μ̂ of both clutches, signed like their torque, `h` [s] after the last.
    pub fn learn(&mut self, p: &Params, sample: &Sample, mu_hat: [f64; 2], h: f64) {
        let slip = sample.slip();
        for i in 0..2 {
            let clutch = &p.clutch[i];
            let lever = clutch.force(sample.actuation[i]) * clutch.r_c_n;
            if slip[i].abs() > SLIP && lever > LEVER {
                let seen = (mu_hat[i] * slip[i].signum()).clamp(Self::SMALLEST, Self::PHYSICAL);
                self.0[i] = seen + (self.0[i] - seen) * ComplexField::exp(-h / TAU);
            }
        }
    }
}
