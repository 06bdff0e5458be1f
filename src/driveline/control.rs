//! Clutch control: the position that makes a clutch carry a requested torque.
//!
//! (21) turned round: T = μ F_map(θ) r_c N, so θ = F_map⁻¹(T / (μ r_c N)). With feedback μ is the
//! friction that the observer learnt while the clutch slipped, without it the nominal one, which is the
//! map-based control that the paper starts from.
//!
//! ```
//! use dct_driveline::{Params, control::position};
//!
//! let clutch = &Params::TABLE_1.clutch[0];
//! let theta = position(clutch, 40.0, 0.26);
//! assert!((0.26 * clutch.map.force(theta) * clutch.r_c_n - 40.0).abs() < 1e-9);
//! ```

use crate::params::ClutchParams;

/// Smallest friction coefficient a position is computed with [1].
const MU_MIN: f64 = 0.02;

/// θ_m [m] at which a slipping clutch carries `torque` [N·m], by friction `mu` [1].
///
/// Between open (0) and the end of the map. No torque, or none that is a number: fully open.
pub fn position(clutch: &ClutchParams, torque: f64, mu: f64) -> f64 {
    if torque.is_nan() || torque <= 0.0 {
        return 0.0;
    }
    clutch
        .map
        .position(torque / (mu.max(MU_MIN) * clutch.r_c_n))
}

/// Follows `target` from `last` [m] no faster than `rate` [m/s] over `h` [s].
pub fn limit_rate(last: f64, target: f64, rate: f64, h: f64) -> f64 {
    target.clamp(last - rate * h, last + rate * h)
}

#[cfg(test)]
mod tests {
    use super::{limit_rate, position};
    use crate::Params;

    #[test]
    fn no_torque_opens_the_clutch_and_too_much_closes_it() {
        let clutch = &Params::TABLE_1.clutch[0];
        assert_eq!(position(clutch, 0.0, 0.3), 0.0);
        assert_eq!(position(clutch, f64::NAN, 0.3), 0.0);
        assert_eq!(position(clutch, 1e6, 0.3), clutch.map.position[9]);
    }

    #[test]
    fn a_position_moves_no_faster_than_its_actuator() {
        assert_eq!(limit_rate(1e-3, 9e-3, 0.1, 1e-2), 2e-3);
        assert_eq!(limit_rate(9e-3, 1e-3, 0.1, 1e-2), 8e-3);
        assert_eq!(limit_rate(1e-3, 1.1e-3, 0.1, 1e-2), 1.1e-3);
    }
}
