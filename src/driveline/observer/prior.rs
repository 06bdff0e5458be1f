//! What an earlier drive learnt, as the point from which `calibrating` starts.
//!
//! Parameters and measurements are corrected by it before the filter sees them, so the filter learns what is left;
//! told is both together.

use crate::Params;
use crate::observer::Sample;
use crate::observer::calibration::{Calibration, PARAMETERS};

/// Where ν stands among the parameters.
pub const MASS: usize = 7;

/// α, β, δ, w, κ, γ, λ, ν of an earlier drive: [1], [N·m], [1], [rad/s], [1], [1], [1], [1]; shape (8).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Prior(pub [f64; PARAMETERS]);

impl Prior {
    /// Nothing was learnt before.
    pub const NONE: Self = Self([0.0; PARAMETERS]);

    /// Parameters and sample as they are by what was learnt before.
    pub fn correct(&self, p: &Params, sample: &Sample) -> (Params, Sample) {
        if *self == Self::NONE {
            return (*p, *sample);
        }
        let [alpha, beta, delta, bias, kappa, gamma, lambda, nu] = self.0;
        let corrected = Params {
            j_e: p.j_ed() * (1.0 + delta) - p.j_d,
            k_o: p.k_o * (1.0 + kappa),
            c_o: p.c_o * (1.0 + gamma),
            j_ct: p.j_ct.map(|j| j * (1.0 + lambda)),
            j_o: p.j_o * (1.0 + lambda),
            j_v: p.j_v * (1.0 + nu),
            ..*p
        };
        let seen = Sample {
            t_e: sample.t_e * (1.0 + alpha) + beta,
            omega_w: sample.omega_w - bias,
            t_y: sample.t_y * (1.0 + lambda),
            ..*sample
        };
        (corrected, seen)
    }

    /// What is known of the parameters after `learnt` on top of this.
    pub fn with(&self, learnt: &Calibration) -> Calibration {
        let (before, now) = (self.0, learnt.value);
        let mut value = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| (1.0 + before[k]) * (1.0 + now[k]) - 1.0);
        value[1] = (1.0 + now[0]) * before[1] + now[1];
        value[3] = before[3] + now[3];
        Calibration { value, ..*learnt }
    }

    /// The same with the mass that it means; `p` with what was learnt before.
    pub fn weigh(&self, p: &Params, learnt: &Calibration) -> Calibration {
        let all = self.with(learnt);
        let per_kg = p.road.r_w * p.road.r_w;
        let believed = p.j_v / (1.0 + self.0[MASS]);
        let mass = p.road.m_v + all.value[MASS] * believed / per_kg;
        Calibration {
            mass: [mass, all.deviation[MASS] * p.j_v / per_kg],
            ..all
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Calibration, Prior};
    use crate::Params;
    use crate::observer::Sample;

    /// Corrected twice is corrected once by both together.
    #[test]
    fn what_is_learnt_adds_to_what_was() {
        let first = Prior([0.05, 1.5, -0.1, 0.01, 0.1, -0.2, 0.15, 0.08]);
        let second = Prior([-0.02, -0.7, 0.2, 0.02, -0.05, 0.1, 0.05, -0.03]);
        let learnt = Calibration {
            value: second.0,
            ..Calibration::default()
        };
        let (p, sample) = (
            Params::TABLE_1,
            Sample {
                t_e: 60.0,
                omega_w: 9.0,
                t_y: -700.0,
                ..Sample::default()
            },
        );
        let (half, seen) = first.correct(&p, &sample);
        let (twice, seen_twice) = second.correct(&half, &seen);
        let (once, seen_once) = Prior(first.with(&learnt).value).correct(&p, &sample);
        let of = |p: &Params, s: &Sample| {
            [
                p.j_e, p.k_o, p.c_o, p.j_ct[0], p.j_ct[1], p.j_o, p.j_v, s.t_e, s.omega_w, s.t_y,
            ]
        };
        for (a, b) in of(&twice, &seen_twice).iter().zip(of(&once, &seen_once)) {
            assert!((a - b).abs() < 1e-12 * a.abs(), "{a} {b}");
        }
    }
}
