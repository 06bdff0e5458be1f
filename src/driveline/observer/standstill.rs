//! A wheel that a brake holds.
//!
//! At rest the brake carries what the drive shaft and the grade leave, up to T_b, and the wheel stays:
//!
//! ```text
//! |T_o − T_v| ≤ T_b, ω_w = 0   ⇒   J_v ω_w' = 0                                   in place of (9)
//! ```
//!
//! An observer that copies (9) takes what the brake carries for a load, or for an acceleration. So while the wheel
//! is held its inertia is taken as beyond all measure, and (9) says nothing of T_o and T_v.

use crate::Params;
use crate::observer::Sample;

/// Estimated speed below which a wheel stands [rad/s].
const STANDS: f64 = 0.1;
/// Inertia of a wheel that nothing moves [kg·m²].
const IMMOVABLE: f64 = 1e9;

/// The driveline with a wheel that stands, if the brake holds it.
///
/// `omega_w` [rad/s], `t_o` and `t_v` without the brake [N·m]: as estimated.
pub fn held(p: &Params, sample: &Sample, omega_w: f64, t_o: f64, t_v: f64) -> Option<Params> {
    let stands = sample.t_brake > 0.0 && omega_w.abs() < STANDS;
    if !stands || (t_o - t_v).abs() > sample.t_brake {
        return None;
    }
    Some(Params {
        j_v: IMMOVABLE,
        ..*p
    })
}

#[cfg(test)]
mod tests {
    use super::held;
    use crate::Params;
    use crate::observer::Sample;

    /// Whether 800 N·m of brake hold the wheel.
    fn holds(omega_w: f64, t_o: f64) -> bool {
        let sample = Sample {
            t_brake: 800.0,
            ..Sample::default()
        };
        held(&Params::TABLE_1, &sample, omega_w, t_o, 350.0).is_some()
    }

    #[test]
    fn a_brake_holds_a_wheel_that_stands_until_the_drive_shaft_pulls_harder() {
        assert!(holds(0.0, 0.0) && holds(0.02, 1149.0));
        assert!(!holds(0.0, 1151.0) && !holds(0.0, -451.0) && !holds(1.0, 0.0));
        let open = Sample::default();
        assert!(held(&Params::TABLE_1, &open, 0.0, 0.0, 0.0).is_none());
    }
}
