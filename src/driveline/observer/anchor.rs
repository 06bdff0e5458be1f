//! What the method `calibrating` trusts: the one factor that no speed shows.
//!
//! All equations of the driveline are homogeneous in torques, inertias, k and c: one common factor on all of
//! them changes no speed. The filter therefore measures everything in units of the engine torque that is
//! reported, where nothing is hidden, and finds ratios
//!
//! ```text
//! ℓ_j = ln(1+δ), ln(1+κ), ln(1+γ), ln(1+λ), ln(1+ν)          of J_ed, k_o, c_o, J_out, J_v to T_e
//! ```
//!
//! with covariance P. If the reported torque is s too large (in logarithms), all of them read s too large;
//! if one parameter is wrong, only that one does. So before a drive they are uncertain together,
//!
//! ```text
//! P_0 = diag(σ_j²) + σ_0² 1 1ᵀ                                σ_0 of T_e, σ_j of the parameters
//! ```
//!
//! and a ratio that speeds show tells of those that they have not shown yet. What speeds alone say of them is the belief
//! less what was believed before; else what nobody has seen would vote for 0:
//!
//! ```text
//! Λ = P⁻¹ − P_0⁻¹,   η = P⁻¹ ℓ
//! ```
//!
//! Each witness is right within its core c_j or, seldom, far off (a Student distribution of n degrees), so the factor is
//! their robust mean, least squares of η = Λ (s 1 + e) with errors e of variances W_j:
//!
//! ```text
//! ŝ = uᵀη/(uᵀΛ1 + 1/W_0),   u = (Λ + W⁻¹)⁻¹ W⁻¹ 1,   W_j = c_j² (n + r_j²/c_j²)/(n + 1),  r_j = ℓ_j − s
//! ```
//!
//! (iterated as time goes on; r_0 = s for T_e itself). One error alone is outvoted whichever it is; σ_j = 0 makes
//! a witness the anchor.

use nalgebra::{ComplexField, SMatrix, SVector};

/// One number for each witness.
pub type Ratios = SVector<f64, WITNESSES>;
/// Their covariance.
pub type Square = SMatrix<f64, WITNESSES, WITNESSES>;

/// Witnesses beside T_e: J_ed, k_o, c_o, J_out, J_v.
pub const WITNESSES: usize = 5;
/// n: degrees of freedom of the Student distribution; few make one error cheap.
const FREEDOM: f64 = 1.0;
/// c_j: how far a witness that is right may be off [1], where the user gives it no less.
const CORE: f64 = 0.025;
/// Variance that keeps what an anchor says invertible [1].
const EXACT: f64 = 1e-12;
/// Time constant with which the factor follows [s].
const TAU: f64 = 0.1;

/// The factor, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Anchor {
    /// s: logarithm of reported over true torque [1].
    pub s: f64,
    /// Its variance [1].
    pub variance: f64,
}

impl Anchor {
    /// True over reported torque [1].
    pub fn factor(&self) -> f64 {
        ComplexField::exp(-self.s)
    }

    /// Takes the ratios ℓ with covariance P, shape (5) and (5, 5), `h` [s] after the last ones.
    ///
    /// `sigma`: deviations of T_e and the five witnesses before the drive [1], shape (6).
    pub fn step(&mut self, ratio: &Ratios, p: &Square, sigma: [f64; WITNESSES + 1], h: f64) {
        let own = spread(sigma[0], self.s);
        if own <= 0.0 {
            *self = Self::default();
            return;
        }
        let Some(believed) = (p + Square::identity() * EXACT).cholesky() else {
            return;
        };
        let precision = believed.inverse();
        let shown = precision - before(sigma);
        let trust = Ratios::from_fn(|j, _| 1.0 / (spread(sigma[j + 1], ratio[j] - self.s) + EXACT));
        let Some(both) = (shown + Square::from_diagonal(&trust)).cholesky() else {
            return;
        };
        let weights = both.solve(&trust);
        let told = weights.dot(&shown.column_sum()).max(0.0);
        self.variance = 1.0 / (told + 1.0 / own);
        let best = weights.dot(&(precision * ratio)) * self.variance;
        self.s += (best - self.s) * (1.0 - ComplexField::exp(-h / TAU));
    }
}

/// P_0⁻¹, by Sherman and Morrison: of a diagonal and one direction.
fn before(sigma: [f64; WITNESSES + 1]) -> Square {
    let single = Ratios::from_fn(|j, _| 1.0 / (sigma[j + 1] * sigma[j + 1] + EXACT));
    let common = single.sum() + 1.0 / (sigma[0] * sigma[0]);
    Square::from_diagonal(&single) - single * single.transpose() / common
}

/// W_j: variance of a witness of deviation `sigma` that is `r` off [1]; none for an anchor.
fn spread(sigma: f64, r: f64) -> f64 {
    if sigma <= 0.0 {
        return 0.0;
    }
    let core = CORE.min(sigma);
    (FREEDOM * core * core + r * r) / (FREEDOM + 1.0)
}

#[cfg(test)]
mod tests {
    use super::{Anchor, Ratios, Square, WITNESSES, before};

    const SIGMA: [f64; WITNESSES + 1] = [0.06, 0.3, 0.1, 0.2, 0.1, 0.2];

    /// s after 3 s of ratios that are known to 0.5 %.
    fn settled(ratio: [f64; WITNESSES], sigma: [f64; WITNESSES + 1]) -> f64 {
        let shown = Square::identity() / (0.005 * 0.005);
        told(&shown, &Ratios::from(ratio), sigma)
    }

    /// s after 3 s of ratios that speeds show with the information `shown`.
    fn told(shown: &Square, ratio: &Ratios, sigma: [f64; WITNESSES + 1]) -> f64 {
        let p = (shown + before(sigma)).try_inverse().unwrap();
        let mut anchor = Anchor::default();
        for _ in 0..3000 {
            anchor.step(&(p * shown * ratio), &p, sigma, 1e-3);
        }
        anchor.s
    }

    /// The last ratio follows the four that are seen, and has no vote of its own.
    #[test]
    fn a_ratio_that_no_speed_has_shown_does_not_vote() {
        let mut shown = Square::identity() / (0.005 * 0.005);
        shown[(4, 4)] = 0.0;
        let ratio = Ratios::repeat(0.05);
        let s = [0.05, 0.2, 0.5].map(|sigma| {
            let mut all = SIGMA;
            all[5] = sigma;
            told(&shown, &ratio, all)
        });
        assert!((s[0] - 0.05).abs() < 0.005, "{s:?}");
        assert!(s.iter().all(|other| (other - s[0]).abs() < 1e-9), "{s:?}");
    }

    #[test]
    fn one_wrong_witness_is_outvoted() {
        for j in 0..WITNESSES {
            let mut ratio = [0.0; WITNESSES];
            ratio[j] = 0.2;
            assert!(settled(ratio, SIGMA).abs() < 0.005, "{j}");
        }
    }

    #[test]
    fn all_witnesses_against_the_torque_move_it() {
        assert!((settled([0.05; WITNESSES], SIGMA) - 0.05).abs() < 0.005);
    }

    #[test]
    fn an_anchor_is_trusted_against_all_others() {
        let mut sigma = SIGMA;
        sigma[0] = 0.0;
        assert_eq!(settled([0.05; WITNESSES], sigma), 0.0);
        sigma = SIGMA;
        sigma[2] = 0.0;
        assert!((settled([0.0, 0.1, 0.0, 0.0, 0.0], sigma) - 0.1).abs() < 0.02);
    }
}
