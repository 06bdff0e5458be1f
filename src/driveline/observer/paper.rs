//! Method `paper`: the adaptive observer (19), (27), (29) as printed.
//!
//! ```text
//! L12 = c/J_ct2,eq,  L21 = 0,  L31 = 1/J_ct2,eq,  L32 = k − b,  L11 > 0,  L22 ≥ 0             (27)
//! ```
//!
//! **Proof: there is none for these gains.** (28) does not follow from (26): with L32 as printed, V̇
//! keeps a term c L22 x̃2 x̃3, and V mixes (rad/s)² with (N·m)² (errata E3, E4). The frozen dynamics are
//! stable where they were scanned, which is no proof either. [`lyapunov`](crate::observer::lyapunov) has
//! the family with a proof.
//!
//! **Gears.** While (29) follows T_ci, errors of x̂3 and T̂_ci that x1 and x2 hardly show go together. With
//! r = h_i/a_i, x̃1 ≈ r x̃2 from ε̂' ≈ 0, and x̃1' ≈ x̃2' ≈ 0,
//!
//! ```text
//! T̃_o' = −T̃_o (c L22 + β) β/(L22 + D),   β = b − r/J_ct2,eq,   D = r (L11 r + c/J_ct2,eq)
//! ```
//!
//! and T_ci that moved by ΔT, before (29) followed it, leaves T̃_o/(g_i ΔT) ~ L11 c L22/((L22 + D) J_out). Both the
//! pole and this share are right for the inertias of Table 1: in a light gearbox D, nearly c/J_out, is large, the pole
//! is slow (preset `wet6` in third and second gear 0.14 1/s, where that of Table 1 is 1.4 to 1.7), and the share is
//! large. So L22, which (27) leaves free, follows the gears: where damper or force tells how T_ci moves, which leaves nothing
//! to share, it keeps the pole of the lowest gears of Table 1, as far as samples follow; elsewhere it keeps the share.
//!
//! ```
//! use dct_driveline::{Params, observer::{Observer, Paper, Sample, Settings}};
//!
//! let (p, settings) = (Params::TABLE_1, Settings::CASE_1);
//! let sample = Sample { t_e: 60.0, omega_e: 90.0, gear: [1, 2], ..Sample::default() };
//! let mut observer = Paper::default();
//! observer.start(&p, &settings, &sample);
//! assert!(observer.step(&p, &settings, &sample, 1e-3).t_o.is_finite());
//! ```

use crate::Params;
use crate::observer::adaptive::Adaptive;
use crate::observer::design::{At, Design, GAINS};
use crate::observer::schedule::{paced, scaled};
use crate::observer::{Estimate, Observer, Sample, Settings, Visit, made};
use crate::reduced::Reduced;
use nalgebra::SMatrix;

/// Largest L22 h that follows the gears: that of the gains for 100 Hz [1].
const HELD: f64 = Gains::AT_100_HZ.l_22 * 1e-2;

/// Gains that (27) leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// L11 [1/s].
    pub l_11: f64,
    /// L22 [1/s].
    pub l_22: f64,
    /// L_c1, L_c2 of (29) with θ in m [kg·N/m], shape (2).
    pub l_c: [f64; 2],
}

impl Gains {
    /// For a step of 1 ms.
    pub const AT_1_KHZ: Self = Self {
        l_11: 80.0,
        l_22: 4.0,
        l_c: [1200e6, 1200e6],
    };
    /// For a step of 10 ms.
    pub const AT_100_HZ: Self = Self {
        l_11: 24.0,
        l_22: 60.0,
        l_c: [400e6, 400e6],
    };

    /// These gains, given for 1 ms, at a step `h` [s]: see `scaled`.
    pub fn at_step(&self, h: f64) -> Self {
        let [fast, slow] = [Self::AT_1_KHZ, Self::AT_100_HZ];
        Self {
            l_11: scaled(self.l_11, [fast.l_11, slow.l_11], 1, h),
            l_22: scaled(self.l_22, [fast.l_22, slow.l_22], 1, h),
            l_c: [0, 1].map(|i| scaled(self.l_c[i], [fast.l_c[i], slow.l_c[i]], 2, h)),
        }
    }

    /// These gains, given for the lowest gears of Table 1, where gears, vehicle and clutches are those `at` hand,
    /// at a step `h` [s].
    ///
    /// Deviation: L22 follows the gears, as the module says.
    pub fn in_gear(&self, at: &At, h: f64) -> Self {
        let l_22 = match at.told {
            Some(i) => self.l_22.max(self.as_fast(at, i).min(HELD / h)),
            None => self.as_quiet(at).min(self.l_22),
        };
        Self { l_22, ..*self }
    }

    /// r_i = h_i/a_i, β_i, D_i: the slow motion with clutch `i`.
    fn slow(&self, model: &Reduced, i: usize) -> [f64; 2] {
        let r = model.h_twist()[i] / model.a_slip()[i];
        let beta = model.b_coupling() - r / model.j_ct2_eq;
        [beta, r * (self.l_11 * r + model.c_o_eq / model.j_ct2_eq)]
    }

    /// L22 for which the slow pole with clutch `i` is that of the lowest gears.
    fn as_fast(&self, at: &At, i: usize) -> f64 {
        let [beta, d] = self.slow(&at.lowest, i);
        let pole = at.lowest.c_o_eq * beta * self.l_22 / (self.l_22 + d);
        let [beta, d] = self.slow(&at.model, i);
        let fastest = at.model.c_o_eq * beta;
        if pole < fastest {
            d * pole / (fastest - pole)
        } else {
            f64::INFINITY
        }
    }

    /// L22 for which a torque that moves unforeseen leaves no larger share in x̂3 than in the lowest gears.
    fn as_quiet(&self, at: &At) -> f64 {
        let j_out = |model: &Reduced| model.j_ct2_eq * model.g_ref;
        let lighter = j_out(&at.model) / j_out(&at.lowest);
        let quiet = |i: usize| {
            let [_, d] = self.slow(&at.lowest, i);
            let share = lighter * self.l_22 / (self.l_22 + d);
            let [_, d] = self.slow(&at.model, i);
            if share < 1.0 {
                d * share / (1.0 - share)
            } else {
                f64::INFINITY
            }
        };
        let transmits = |i: &usize| at.model.g[*i] != 0.0;
        (0..2)
            .filter(transmits)
            .map(quiet)
            .fold(f64::INFINITY, f64::min)
    }

    /// ε̂_ci' of (29) over r_ci N_i θ_mi per x̃1 and x̃2, row by row, shape (2, 2).
    fn adaptation(&self, at: &At) -> SMatrix<f64, 2, 2> {
        let (a, h) = (at.model.a_slip(), at.model.h_twist());
        let square = |model: &Reduced| model.a_slip().map(|a| a * a);
        let l_c = paced(self.l_c, at.radius, square(&at.model), square(&at.lowest));
        SMatrix::from_fn(|i, j| l_c[i] * [-a[i], h[i]][j])
    }

    /// L of (19) with the rows that (27) fixes, shape (3, 2).
    pub fn l(&self, model: &Reduced) -> SMatrix<f64, 3, 2> {
        let j = model.j_ct2_eq;
        SMatrix::<f64, 3, 2>::new(
            self.l_11,
            model.c_o_eq / j, //
            0.0,
            self.l_22, //
            1.0 / j,
            model.k_o_eq - model.b_coupling(),
        )
    }
}

/// The observer as printed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Paper {
    /// State and equations shared with `lyapunov`.
    pub core: Adaptive,
}

/// Gains for a step `h` [s], where nothing is known of the gears yet.
fn at_step(settings: &Settings, h: f64) -> Gains {
    if settings.scheduled {
        settings.gains.at_step(h)
    } else {
        settings.gains
    }
}

impl Gains {
    /// All of them, as a question.
    const fn numbers(&self) -> [f64; GAINS] {
        let Gains {
            l_11,
            l_22,
            l_c: [one, two],
        } = *self;
        [l_11, l_22, one, two, 0.0, 0.0]
    }
}

/// What becomes of gains for a step `h` [s] where gears, vehicle and clutches are those `at` hand.
fn design([l_11, l_22, one, two, ..]: [f64; GAINS], at: &At, h: f64) -> Design {
    let l_c = [one, two];
    let gains = Gains { l_11, l_22, l_c }.in_gear(at, h);
    Design {
        l: gains.l(&at.model),
        adaptation: gains.adaptation(at),
    }
}

impl Observer for Paper {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let gains = at_step(settings, 1e-3);
        self.core
            .start(p, settings, sample, gains.numbers(), design)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        made(|y| self.step_to(p, settings, sample, h, y))
    }

    fn step_to(
        &mut self,
        p: &Params,
        settings: &Settings,
        sample: &Sample,
        h: f64,
        y: &mut Estimate,
    ) {
        let gains = at_step(settings, h).numbers();
        self.core.step(p, settings, sample, h, (gains, design), y);
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.core.visit(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::{Gains, HELD};
    use crate::Params;
    use crate::observer::design::At;
    use crate::observer::poles;
    use crate::observer::schedule::{lowest_ratios, radius};
    use crate::reduced::Reduced;
    use nalgebra::Matrix4;

    /// θ of a clutch that is pressed home [m].
    const THETA: f64 = 5e-3;
    const H: f64 = 1e-3;

    fn at(p: &Params, gears: [i32; 2], told: Option<usize>) -> At {
        let table = Params::TABLE_1;
        At {
            model: Reduced::new(p, p.g(gears), p.c_o),
            lowest: Reduced::new(&table, lowest_ratios(&table), table.c_o),
            told,
            radius: radius(p),
        }
    }

    /// Slowest pole [1/s] of (x̃1, x̃2, x̃3, T̃_ci) with clutch `i` transmitting.
    fn slowest(p: &Params, at: &At, gains: &Gains, i: usize) -> f64 {
        let (m, l) = (&at.model, gains.l(&at.model));
        let (a, h, arm) = (m.a_slip()[i], m.h_twist()[i], p.clutch[i].r_c_n * THETA);
        let adaptation = gains.adaptation(at) * (arm * arm);
        let (j, b, k, c) = (m.j_ct2_eq, m.b_coupling(), m.k_o_eq, m.c_o_eq);
        let errors = Matrix4::new(
            -l[(0, 0)],
            -l[(0, 1)],
            1.0 / j,
            -a, //
            -l[(1, 0)],
            -l[(1, 1)],
            -b,
            h, //
            -l[(2, 0)],
            k - l[(2, 1)],
            -c * b,
            c * h, //
            -adaptation[(i, 0)],
            -adaptation[(i, 1)],
            0.0,
            0.0,
        );
        poles::slowest(errors)
    }

    #[test]
    fn gains_of_table_1_are_those_that_are_given() {
        let p = Params::TABLE_1;
        for (gains, h) in [(Gains::AT_1_KHZ, 1e-3), (Gains::AT_100_HZ, 1e-2)] {
            for told in [None, Some(0), Some(1)] {
                let l_22 = gains.in_gear(&at(&p, [1, 2], told), h).l_22;
                assert!((l_22 / gains.l_22 - 1.0).abs() < 1e-12, "{told:?}: {l_22}");
            }
        }
    }

    /// A light gearbox forgets as fast as the paper's while it is told how the torque moves: poles in 1/s.
    #[test]
    fn light_gearboxes_forget_as_fast_as_the_one_of_the_paper() {
        let table = at(&Params::TABLE_1, [1, 2], None);
        for p in [Params::WET_6, Params::DRY_7] {
            for (gears, i) in [([1, 2], 0), ([1, 2], 1), ([3, 2], 0), ([3, 2], 1)] {
                let gains = Gains::AT_1_KHZ;
                let paper = slowest(&Params::TABLE_1, &table, &gains, i);
                let told = at(&p, gears, Some(i));
                let given = slowest(&p, &told, &gains, i);
                let followed = slowest(&p, &told, &gains.in_gear(&told, H), i);
                assert!(given < 0.6 * paper, "{gears:?} {i}: {given} of {paper}");
                let ratio = followed / paper;
                assert!(
                    (0.7..1.4).contains(&ratio),
                    "{gears:?} {i}: {followed} of {paper}"
                );
            }
        }
    }

    /// Where nothing tells how a torque moves L22 falls, and it never corrects more in a sample than at 100 Hz.
    #[test]
    fn l_22_stays_within_what_samples_follow() {
        let p = Params::WET_6;
        for (gains, h) in [(Gains::AT_1_KHZ, 1e-3), (Gains::AT_100_HZ, 1e-2)] {
            for gears in [[1, 2], [3, 2], [5, 6]] {
                let quiet = gains.in_gear(&at(&p, gears, None), h).l_22;
                let fast = gains.in_gear(&at(&p, gears, Some(1)), h).l_22;
                assert!(quiet < gains.l_22 && quiet > 0.0, "{gears:?}: {quiet}");
                assert!(fast * h < HELD + 1e-12, "{gears:?}: {fast}");
            }
        }
    }
}
