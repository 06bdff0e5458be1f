//! Identification of the drive shaft (17), (18): k_o,eq and c_o,eq by least squares.
//!
//! T_o = X β with X = [θ_c2/g2 − θ_w, ω_c2/g2 − ω_w] and β = (k_o,eq, c_o,eq). Take the first part of
//! a launch, once T_o has built up: angles are integrated speeds, so the window must be short.
//!
//! ```
//! use dct_driveline::identify::LeastSquares;
//!
//! let mut fit = LeastSquares::default();
//! for k in 0..100 {
//!     let (twist, rate) = (0.001 * f64::from(k), 0.02 - 0.0001 * f64::from(k * k % 7));
//!     fit.add(twist, rate, 4887.0 * twist + 561.0 * rate);
//! }
//! let shaft = fit.solve().expect("the data excite both");
//! assert!((shaft.k_o_eq.value - 4887.0).abs() < 1e-6 && shaft.r_squared > 0.999_999);
//! ```

use nalgebra::{ComplexField, Matrix2, Vector2};

/// An estimate with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// Estimate.
    pub value: f64,
    /// Standard error, in the same unit.
    pub standard_error: f64,
}

/// What (18) finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// k_o,eq [N·m/rad].
    pub k_o_eq: Estimated,
    /// c_o,eq [N·m·s/rad].
    pub c_o_eq: Estimated,
    /// R²: share of the variation of T_o about its mean that the fit explains [1].
    pub r_squared: f64,
}

/// Sums of the normal equations of (18), sample by sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeastSquares {
    count: f64,
    /// XᵀX.
    gram: Matrix2<f64>,
    /// Xᵀ T_o.
    moment: Vector2<f64>,
    /// Σ T_o and Σ T_o².
    torque: [f64; 2],
}

impl LeastSquares {
    /// Adds one sample: twist [rad], its rate [rad/s], drive-shaft torque T_o [N·m].
    pub fn add(&mut self, twist: f64, rate: f64, t_o: f64) {
        let x = Vector2::new(twist, rate);
        self.count += 1.0;
        self.gram += x * x.transpose();
        self.moment += x * t_o;
        self.torque[0] += t_o;
        self.torque[1] += t_o * t_o;
    }

    /// β̂ = (XᵀX)⁻¹ Xᵀ T_o of (18); `None` for fewer than three samples or twist and rate in
    /// proportion.
    pub fn solve(&self) -> Option<Shaft> {
        let spare = self.count - 2.0;
        let determinant = self.gram.determinant();
        let scale = self.gram[(0, 0)] * self.gram[(1, 1)];
        if spare < 1.0 || determinant.is_nan() || determinant <= scale * 1e-12 {
            return None;
        }
        let inverse = self.gram.try_inverse()?;
        let beta = inverse * self.moment;
        let residual = (self.torque[1] - self.moment.dot(&beta)).max(0.0);
        let total = self.torque[1] - self.torque[0] * self.torque[0] / self.count;
        let estimated = |i: usize| Estimated {
            value: beta[i],
            standard_error: ComplexField::sqrt(inverse[(i, i)] * residual / spare),
        };
        Some(Shaft {
            k_o_eq: estimated(0),
            c_o_eq: estimated(1),
            r_squared: 1.0 - residual / total,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::LeastSquares;

    #[test]
    fn proportional_columns_are_refused() {
        let mut fit = LeastSquares::default();
        for k in 1..50 {
            let twist = 1e-3 * f64::from(k);
            fit.add(twist, 2.0 * twist, 5.0 * twist);
        }
        assert_eq!(fit.solve(), None);
    }

    /// Errors +1, −1 alternate on orthogonal regressors, so every sum is known in closed form:
    /// s² = n/(n−2), standard error = s/√(Σ x²).
    #[test]
    fn standard_errors_are_those_of_the_closed_form() {
        let mut fit = LeastSquares::default();
        for k in 0..400_u32 {
            let sign = |period: u32| {
                if (k / period).is_multiple_of(2) {
                    1.0
                } else {
                    -1.0
                }
            };
            let (twist, rate, noise) = (0.1 * sign(2), 0.5 * sign(4), sign(1));
            fit.add(twist, rate, 4887.0 * twist + 561.0 * rate + noise);
        }
        let shaft = fit.solve().unwrap();
        let s = (400.0_f64 / 398.0).sqrt();
        assert!((shaft.k_o_eq.value - 4887.0).abs() < 1e-9);
        assert!((shaft.k_o_eq.standard_error / (s / (0.1 * 20.0)) - 1.0).abs() < 1e-6);
        assert!((shaft.c_o_eq.standard_error / (s / (0.5 * 20.0)) - 1.0).abs() < 1e-6);
    }
}
