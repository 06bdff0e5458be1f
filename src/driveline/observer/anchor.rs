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
//! Each witness is right, within its core c_j, or it is wrong and as far off as was believed, σ_j; the one is as likely as
//! the other, and T_e is wrong three times in ten. For every suspicion S, of who is wrong, all of it is normal, so the factor and
//! what speaks for S have a closed form:
//!
//! ```text
//! W_j = σ_j² if wrong, else c_j²,   u = (Λ + W⁻¹)⁻¹ W⁻¹ 1,   ŝ_S = v_S uᵀη,   1/v_S = uᵀΛ1 + 1/W_0
//! p_S ∝ π_0 √(v_S/(W_0 |1 + WΛ|)) exp ½(ηᵀ(Λ + W⁻¹)⁻¹η + v_S (uᵀη)² − ηᵀℓ)      (ηᵀℓ is the same for all)
//! s = Σ p_S ŝ_S,   var s = Σ p_S (v_S + ŝ_S²) − s²
//! ```
//!
//! One error alone is outvoted whichever it is. Where two readings explain what speeds show, as three witnesses that
//! are off by the same share against T_e and two, s lies between them and its deviation covers both. A
//! suspicion of the witnesses is heard a millisecond; σ_j = 0 makes a witness the anchor.

use crate::observer::Visit;
use nalgebra::{ComplexField, SMatrix, SVector};

/// One number for each witness.
pub type Ratios = SVector<f64, WITNESSES>;
/// Their covariance.
pub type Square = SMatrix<f64, WITNESSES, WITNESSES>;
/// 1 for each witness that is suspected, else 0.
type Suspected = [f64; WITNESSES];

/// Witnesses beside T_e: J_ed, k_o, c_o, J_out, J_v.
pub const WITNESSES: usize = 5;
/// c_j: how far a value that is right may be off [1], where the user gives it no less.
const CORE: f64 = 0.01;
/// Odds that T_e is wrong: three in ten.
const ODDS: f64 = 3.0 / 7.0;
/// Time for which a suspicion is heard [s], and how many there are.
const TURN: f64 = 1e-3;
const TURNS: f64 = 32.0;
/// Largest exponent of p_S; with ηᵀℓ taken off it stays far below.
const LARGEST: f64 = 300.0;
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
    /// Where s goes: what all suspicions said together [1].
    mean: f64,
    /// Σ p_S, Σ p_S ŝ_S, Σ p_S (v_S + ŝ_S²) of those that were heard since.
    sum: [f64; 3],
    /// Number of the suspicion that is heard next [1]: its binary digits tell which witnesses are wrong.
    turn: f64,
}

impl Anchor {
    /// True over reported torque [1].
    pub fn factor(&self) -> f64 {
        ComplexField::exp(-self.s)
    }

    /// What is believed before a drive; `sigma` of T_e [1].
    pub fn new(sigma: f64) -> Self {
        Self {
            variance: sigma * sigma,
            ..Self::default()
        }
    }

    /// Takes the ratios ℓ with covariance P, shape (5) and (5, 5), `h` [s] after the last ones.
    ///
    /// `sigma`: deviations of T_e and the five witnesses before the drive [1], shape (6).
    pub fn step(&mut self, ratio: &Ratios, p: &Square, sigma: [f64; WITNESSES + 1], h: f64) {
        if sigma[0] <= 0.0 {
            *self = Self::default();
            return;
        }
        let Some(believed) = (p + Square::identity() * EXACT).cholesky() else {
            return;
        };
        let shown = Shown::new(&believed.inverse(), ratio, sigma);
        let (mut heard, due) = (0.5, (h / TURN).clamp(1.0, TURNS));
        while heard < due {
            self.hear(&shown, sigma);
            heard += 1.0;
        }
        self.s += (self.mean - self.s) * (1.0 - ComplexField::exp(-h / TAU));
    }

    /// Hears the next suspicion; after the last one, what all say together.
    fn hear(&mut self, shown: &Shown, sigma: [f64; WITNESSES + 1]) {
        for said in shown.suspecting(suspected(self.turn), sigma) {
            self.sum[0] += said.weight;
            self.sum[1] += said.weight * said.s;
            self.sum[2] += said.weight * (said.variance + said.s * said.s);
        }
        self.turn += 1.0;
        let all = self.turn >= TURNS;
        let [weight, first, second] = self.sum;
        if all && weight > 0.0 {
            self.mean = first / weight;
            self.variance = (second / weight - self.mean * self.mean).max(0.0);
        }
        if all {
            (self.turn, self.sum) = (0.0, [0.0; 3]);
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            s,
            variance,
            mean,
            sum,
            turn,
        } = self;
        visit(s);
        visit(variance);
        visit(mean);
        sum.iter_mut().for_each(&mut *visit);
        visit(turn);
    }
}

/// The suspicion of a number, from nobody, 0, to all.
fn suspected(turn: f64) -> Suspected {
    let (mut rest, mut weight, mut wrong) = (turn, TURNS, [0.0; WITNESSES]);
    for wrong in wrong.iter_mut().rev() {
        weight *= 0.5;
        if rest >= weight {
            (rest, *wrong) = (rest - weight, 1.0);
        }
    }
    wrong
}

/// What a suspicion says.
#[derive(Debug, Clone, Copy)]
struct Said {
    /// p_S, but for a factor that all have.
    weight: f64,
    /// ŝ_S.
    s: f64,
    /// v_S.
    variance: f64,
}

/// What speeds have shown: ℓ, Λ, η.
#[derive(Debug)]
struct Shown {
    ratio: Ratios,
    lambda: Square,
    eta: Ratios,
}

impl Shown {
    /// From P⁻¹ and ℓ.
    fn new(precision: &Square, ratio: &Ratios, sigma: [f64; WITNESSES + 1]) -> Self {
        Self {
            ratio: *ratio,
            lambda: precision - before(sigma),
            eta: precision * ratio,
        }
    }

    /// What follows if these witnesses are wrong and the others right, and T_e is right, or wrong.
    fn suspecting(&self, wrong: Suspected, sigma: [f64; WITNESSES + 1]) -> [Said; 2] {
        let w = Ratios::from_fn(|j, _| spread(sigma[j + 1], wrong[j] > 0.0) + EXACT);
        let trust = w.map(|variance| 1.0 / variance);
        let Some(both) = (self.lambda + Square::from_diagonal(&trust)).cholesky() else {
            return [Said::NOTHING; 2];
        };
        let [u, fitted] = [trust, self.eta].map(|side| both.solve(&side));
        let told = u.dot(&self.lambda.column_sum()).max(0.0);
        let sum = u.dot(&self.eta);
        let fit = self.eta.dot(&(fitted - self.ratio));
        let size: f64 = (0..WITNESSES)
            .map(|j| {
                let root = both.l_dirty()[(j, j)];
                w[j] * (root * root)
            })
            .product();
        [(false, 1.0), (true, ODDS)].map(|(wrong, odds)| {
            let own = spread(sigma[0], wrong);
            let variance = 1.0 / (told + 1.0 / own);
            let fit = 0.5 * (fit + variance * sum * sum);
            let room = ComplexField::sqrt(variance / (own * size));
            Said {
                weight: odds * room * ComplexField::exp(fit.min(LARGEST)),
                s: variance * sum,
                variance,
            }
        })
    }
}

impl Said {
    /// Of a suspicion that what is shown rules out.
    const NOTHING: Self = Self {
        weight: 0.0,
        s: 0.0,
        variance: 0.0,
    };
}

/// P_0⁻¹, by Sherman and Morrison: of a diagonal and one direction.
fn before(sigma: [f64; WITNESSES + 1]) -> Square {
    let single = Ratios::from_fn(|j, _| 1.0 / (sigma[j + 1] * sigma[j + 1] + EXACT));
    let common = single.sum() + 1.0 / (sigma[0] * sigma[0]);
    Square::from_diagonal(&single) - single * single.transpose() / common
}

/// W_j: variance of a value of deviation `sigma` [1]; none of an anchor.
fn spread(sigma: f64, wrong: bool) -> f64 {
    let sigma = if wrong { sigma } else { sigma.min(CORE) };
    sigma * sigma
}

#[cfg(test)]
mod tests {
    use super::{
        Anchor, ODDS, Ratios, Shown, Square, Suspected, WITNESSES, before, spread, suspected,
    };

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

    /// T_e and two more stand against them; that it might still be T_e shows in the deviation.
    #[test]
    fn three_witnesses_that_err_alike_hardly_move_the_torque() {
        let shown = Square::identity() / (0.01 * 0.01);
        let p = (shown + before(SIGMA)).try_inverse().unwrap();
        let settled = |off: f64| {
            let ratio = Ratios::from([off, off, 0.0, 0.0, off]);
            let mut anchor = Anchor::default();
            for _ in 0..3000 {
                anchor.step(&(p * shown * ratio), &p, SIGMA, 1e-3);
            }
            (anchor.s, anchor.variance.sqrt())
        };
        let ((none, sure), (s, unsure)) = (settled(0.0), settled(0.165));
        assert!(none.abs() < 1e-9 && s.abs() < 0.01, "{none} {s}");
        assert!(unsure > 2.0 * sure && s < unsure, "{s}: {sure} {unsure}");
    }

    /// Against the normal density of what speeds show, ℓ = η/Λ of covariance W + W_0 1 1ᵀ + Λ⁻¹.
    #[test]
    fn what_speaks_for_a_suspicion_is_its_density() {
        let half = Square::from_iterator((1..=25_u8).map(|k| 3.0 / f64::from(k)));
        let lambda = half * half.transpose() * 300.0 + Square::identity() * 500.0;
        let ratio = Ratios::from([0.05, -0.02, 0.03, 0.08, 0.01]);
        let precision = lambda + before(SIGMA);
        let shown = Shown::new(
            &precision,
            &(precision.try_inverse().unwrap() * lambda * ratio),
            SIGMA,
        );
        let density = |wrong: Suspected, torque: bool| {
            let w = Ratios::from_fn(|j, _| spread(SIGMA[j + 1], wrong[j] > 0.0));
            let common = Square::repeat(spread(SIGMA[0], torque));
            let all = Square::from_diagonal(&w) + common + lambda.try_inverse().unwrap();
            let inverse = all.try_inverse().unwrap();
            let odds = if torque { ODDS } else { 1.0 };
            let s = (common * inverse * ratio)[0];
            (
                odds * (-0.5 * ratio.dot(&(inverse * ratio))).exp() / all.determinant().sqrt(),
                s,
            )
        };
        let nobody = [0.0; WITNESSES];
        let unit = shown.suspecting(nobody, SIGMA)[0].weight / density(nobody, false).0;
        for turn in 0..32 {
            let wrong = suspected(f64::from(turn));
            for (torque, said) in [false, true]
                .into_iter()
                .zip(shown.suspecting(wrong, SIGMA))
            {
                let (expected, s) = density(wrong, torque);
                assert!(
                    (said.weight / unit / expected - 1.0).abs() < 1e-6,
                    "{wrong:?} {torque}"
                );
                assert!(
                    (said.s - s).abs() < 1e-9,
                    "{wrong:?} {torque}: {} {s}",
                    said.s
                );
            }
        }
    }

    #[test]
    fn a_number_tells_who_is_suspected() {
        for (turn, wrong) in [(0.0, [0; 5]), (5.0, [1, 0, 1, 0, 0]), (31.0, [1; 5])] {
            assert_eq!(suspected(turn), wrong.map(f64::from), "{turn}");
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
