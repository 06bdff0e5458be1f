//! Linings: how the friction of a slipping clutch varies with its slip.
//!
//! In: |slip|. Out: the factor on μ_k of (6), (7), linear between the points of a table, constant
//! outside:
//!
//! ```text
//! T_c = μ_k φ(|slip|) F_n r_c N · sgn(slip)
//! ```
//!
//! A φ that falls from slip 0 is a Stribeck curve, one that falls at large slip is fade.
//!
//! Deviation: (6), (7) have one μ_k; with all points at slip 0, as in [`FrictionCurve::CONSTANT`], φ is 1.
//!
//! ```
//! use dct_driveline::friction::FrictionCurve;
//!
//! let curve = FrictionCurve {
//!     slip: [0.0, 10.0, 50.0, 100.0, 200.0],
//!     factor: [1.0, 0.9, 0.9, 0.8, 0.7],
//! };
//! assert!((curve.at(5.0).0 - 0.95).abs() < 1e-15); // and slope −0.01 s/rad
//! assert_eq!(FrictionCurve::CONSTANT.at(5.0), (1.0, 0.0));
//! ```

use crate::clutch::apart;

/// Number of points of a friction curve.
pub const CURVE_POINTS: usize = 5;

/// φ: factor on μ_k over |slip|, linear between points, constant outside.
///
/// `slip` ascends strictly from ≥ 0, or is 0 throughout: then φ is 1 and costs nothing.
#[derive(Debug, Clone, Copy)]
pub struct FrictionCurve {
    /// |slip| [rad/s], shape (CURVE_POINTS).
    pub slip: [f64; CURVE_POINTS],
    /// φ [1], shape (CURVE_POINTS), ≥ 0.
    pub factor: [f64; CURVE_POINTS],
}

/// Bit by bit, like [`ForceMap`](crate::clutch::ForceMap).
impl PartialEq for FrictionCurve {
    fn eq(&self, other: &Self) -> bool {
        apart(&self.slip, &other.slip) | apart(&self.factor, &other.factor) == 0
    }
}

impl FrictionCurve {
    /// The friction of the paper: φ = 1 at any slip.
    pub const CONSTANT: Self = Self {
        slip: [0.0; CURVE_POINTS],
        factor: [1.0; CURVE_POINTS],
    };

    /// Whether there is a table at all.
    pub const fn varies(&self) -> bool {
        self.slip[CURVE_POINTS - 1] > 0.0
    }

    /// φ [1] and dφ/d|slip| [s/rad], at a point of the table that to its right.
    ///
    /// `slip`: slip in the direction in which the clutch slips [rad/s]; below 0, which a step may probe
    /// on its way to a lock-up, φ is that of 0.
    pub fn at(&self, slip: f64) -> (f64, f64) {
        if !self.varies() {
            return (1.0, 0.0);
        }
        let right = self.slip.iter().take_while(|knot| **knot <= slip).count();
        if right == 0 || right == CURVE_POINTS || slip < 0.0 {
            return (self.factor[right.saturating_sub(1)], 0.0);
        }
        let left = right - 1;
        let slope = (self.factor[right] - self.factor[left]) / (self.slip[right] - self.slip[left]);
        (self.factor[left] + slope * (slip - self.slip[left]), slope)
    }
}

#[cfg(test)]
mod tests {
    use super::FrictionCurve;

    const CURVE: FrictionCurve = FrictionCurve {
        slip: [1.0, 2.0, 4.0, 8.0, 16.0],
        factor: [1.2, 1.0, 1.0, 0.8, 0.0],
    };

    #[test]
    fn a_curve_is_linear_between_points_and_constant_outside() {
        let cases = [
            (-3.0, 1.2, 0.0),
            (0.0, 1.2, 0.0),
            (1.0, 1.2, -0.2),
            (1.5, 1.1, -0.2),
            (3.0, 1.0, 0.0),
            (6.0, 0.9, -0.05),
            (15.0, 0.1, -0.1),
            (16.0, 0.0, 0.0),
            (99.0, 0.0, 0.0),
        ];
        for (slip, factor, slope) in cases {
            let found = CURVE.at(slip);
            assert!((found.0 - factor).abs() < 1e-15, "{slip} rad/s: {found:?}");
            assert!((found.1 - slope).abs() < 1e-15, "{slip} rad/s: {found:?}");
        }
    }

    #[test]
    fn without_points_the_factor_is_one() {
        let mut plain = FrictionCurve::CONSTANT;
        plain.factor = CURVE.factor;
        assert!(!plain.varies() && CURVE.varies());
        assert_eq!(plain.at(3.0), (1.0, 0.0));
    }
}
