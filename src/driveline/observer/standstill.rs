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
//!
//! Rolling resistance holds a wheel as well, with whatever the drive shaft and the grade leave. To (11) its direction is that
//! of ω_w, which of a wheel at rest is that of a sensor's noise or bias. The mean over ω_w ~ N(ω̂_w, σ²) is
//!
//! ```text
//! E sgn(ω_w) = erf(ω̂_w/(√2 σ)) ≈ tanh(V̂/V_σ),   V_σ = √(π/2) r_w σ        the same slope at 0
//! ```
//!
//! whose slope lets a filter know that resistance and grade cannot be told apart before the wheel turns.

use crate::Params;
use crate::observer::Sample;
use nalgebra::ComplexField;

/// Estimated speed below which a wheel stands [rad/s].
const STANDS: f64 = 0.1;
/// Inertia of a wheel that nothing moves [kg·m²].
const IMMOVABLE: f64 = 1e9;

/// The driveline with a wheel that stands, if the brake holds it.
///
/// `omega_w` [rad/s], `t_o` and `t_v` without the brake [N·m]: as estimated.
pub fn held(p: &Params, sample: &Sample, omega_w: f64, t_o: f64, t_v: f64) -> Option<Params> {
    if !stands(sample, omega_w) || (t_o - t_v).abs() > sample.t_brake {
        return None;
    }
    Some(Params {
        j_v: IMMOVABLE,
        ..*p
    })
}

/// Whether a wheel at `omega_w` [rad/s] stands, braked.
pub fn stands(sample: &Sample, omega_w: f64) -> bool {
    sample.t_brake > 0.0 && omega_w.abs() < STANDS
}

/// Makes rolling resistance as well known as the speed of the wheel, of variance `variance` [(rad/s)²]: V_ε² + V_σ² in
/// place of V_ε².
pub fn unsure(p: &mut Params, variance: f64) {
    let (r_w, v_eps) = (p.road.r_w, p.road.v_eps);
    let v_sigma = core::f64::consts::FRAC_PI_2 * r_w * r_w * variance;
    p.road.v_eps = ComplexField::sqrt(v_eps * v_eps + v_sigma);
}

#[cfg(test)]
mod tests {
    use super::{held, unsure};
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

    /// Against the mean over the normal density: the tanh is off by 2.5 % at most.
    #[test]
    fn rolling_resistance_is_its_mean_over_what_the_speed_may_be() {
        const SIGMA: f64 = 0.02;
        let mut p = Params::TABLE_1;
        p.road.v_eps = 0.0;
        let mut blurred = p;
        unsure(&mut blurred, SIGMA * SIGMA);
        for speed in [0.0, 0.005, -0.01, 0.02, 0.05, 3.0] {
            let chances = (-4000..=4000).map(|k| f64::from(k) * 1e-3);
            let (mut mean, mut sum) = (0.0, 0.0);
            for z in chances {
                let density = (-0.5 * z * z).exp();
                mean += p.road.direction(speed + SIGMA * z) * density;
                sum += density;
            }
            let error = blurred.road.direction(speed) - mean / sum;
            assert!(error.abs() < 0.025, "{speed}: {error}");
        }
    }

    #[test]
    fn a_brake_holds_a_wheel_that_stands_until_the_drive_shaft_pulls_harder() {
        assert!(holds(0.0, 0.0) && holds(0.02, 1149.0));
        assert!(!holds(0.0, 1151.0) && !holds(0.0, -451.0) && !holds(1.0, 0.0));
        let open = Sample::default();
        assert!(held(&Params::TABLE_1, &open, 0.0, 0.0, 0.0).is_none());
    }
}
