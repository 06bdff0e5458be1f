//! Gains and model over a step of `paper` and `lyapunov`: kept while what they follow from stays.
//!
//! A step asks for them with numbers alone (`Question`). They change with a gear, with a parameter or gain that is
//! set, with the step, and with what is known of a clutch; in between, to find them anew would cost more than the rest of
//! the observer. Numbers are compared bit by bit, so what is kept is what would be found.

use crate::Params;
use crate::observer::instant::Instant;
use crate::observer::schedule::{lowest_ratios, radius};
use crate::reduced::{Discrete, Reduced, zeros};
use nalgebra::SMatrix;

/// What a method chooses: gains for the step at hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// L of (19), shape (3, 2).
    pub l: SMatrix<f64, 3, 2>,
    /// ε̂_ci' over r_ci N_i θ_mi per x̃1 and x̃2, row by row, with θ in m, shape (2, 2).
    pub adaptation: SMatrix<f64, 2, 2>,
}

/// What the gains of a step may depend on.
#[derive(Debug, Clone, Copy)]
pub struct At {
    /// The model of the gears at hand.
    pub model: Reduced,
    /// That of the lowest gears of Table 1, which gains are given for.
    pub lowest: Reduced,
    /// The clutch that carries alone, of a friction that is known or being taken: damper or force tells how its
    /// torque moves.
    pub told: Option<usize>,
    /// (r_ci N_i)² of Table 1 over that at hand [1], shape (2).
    pub radius: [f64; 2],
}

/// Numbers that gains of either method may have.
pub const GAINS: usize = 6;
/// What a method makes of its gains where gears, vehicle and clutches are those at hand, at a step [s].
pub type Method = fn([f64; GAINS], &At, f64) -> Design;
/// Numbers of a question.
const NUMBERS: usize = 12 + GAINS;

/// All that a design and a model follow from but J_v of a wheel that is held: parameters, ratios, the step, gains.
type Question = [f64; NUMBERS];

/// What a method asks for at a step.
#[derive(Debug, Clone, Copy)]
pub struct Wanted {
    /// The ratio by which x1 and x2 are defined [1].
    pub g_ref: f64,
    /// See [`At::told`].
    pub told: Option<usize>,
    /// The step [s].
    pub h: f64,
    /// Gains of the method at that step.
    pub gains: [f64; GAINS],
    /// What it makes of them.
    pub design: Method,
}

impl Wanted {
    fn question(&self, now: &Instant<'_>) -> Question {
        let (p, [g1, g2]) = (now.p, now.g);
        let [r1, r2] = [0, 1].map(|i| p.clutch[i].r_c_n);
        let told = match self.told {
            None => -1.0,
            Some(0) => 0.0,
            Some(_) => 1.0,
        };
        let [a, b, c, d, e, f] = self.gains;
        let (j_ed, j_out, g_ref) = (p.j_ed(), p.j_out(now.g), self.g_ref);
        [
            j_ed, p.j_v, j_out, p.k_o, p.c_o, g1, g2, g_ref, r1, r2, self.h, told, a, b, c, d, e, f,
        ]
    }
}

/// An answer to a question.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    question: Question,
    /// J_ct2,eq of (13) [kg·m²].
    j_ct2_eq: f64,
    /// a_1, a_2 of (13), shape (2).
    pub a: [f64; 2],
    /// Gains.
    pub design: Design,
    /// J_v that the discrete model was made for [kg·m²]; −∞: none yet.
    j_v: f64,
    discrete: Discrete,
}

impl Answer {
    /// The answer to no question: a step is never 0.
    const NONE: Self = Self {
        question: [0.0; NUMBERS],
        j_ct2_eq: 0.0,
        a: [0.0; 2],
        design: Design {
            l: zeros(),
            adaptation: zeros(),
        },
        j_v: f64::NEG_INFINITY,
        discrete: Discrete::NOTHING,
    };

    /// The model over the step for the J_v at hand [kg·m²].
    #[inline]
    pub fn discrete(&mut self, j_v: f64) -> &Discrete {
        if self.j_v.to_bits() != j_v.to_bits() {
            self.make_discrete(j_v);
        }
        &self.discrete
    }

    #[cold]
    #[inline(never)]
    fn make_discrete(&mut self, j_v: f64) {
        let discrete = self.model(j_v).discrete(&self.design.l, self.question[10]);
        (self.j_v, self.discrete) = (j_v, discrete);
    }

    /// The model of the gears at hand for the J_v at hand [kg·m²].
    #[inline]
    pub const fn model(&self, j_v: f64) -> Reduced {
        let [j_ed, _, _, k_o_eq, c_o_eq, g1, g2, g_ref, ..] = self.question;
        Reduced {
            j_ed,
            j_v,
            j_ct2_eq: self.j_ct2_eq,
            g: [g1, g2],
            g_ref,
            k_o_eq,
            c_o_eq,
        }
    }
}

/// The last two answers. Two, since steps of a third of a millisecond alternate between two lengths, of whole
/// picoseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answers {
    kept: [Answer; 2],
    /// Which of them is the last.
    last: bool,
}

impl Default for Answers {
    fn default() -> Self {
        Self {
            kept: [Answer::NONE; 2],
            last: false,
        }
    }
}

impl Answers {
    /// The last answer.
    #[inline]
    pub const fn last(&self) -> &Answer {
        &self.kept[self.last as usize]
    }

    /// The last answer, whose discrete model may be made.
    #[inline]
    pub const fn last_mut(&mut self) -> &mut Answer {
        &mut self.kept[self.last as usize]
    }

    /// Makes the answer to what is `wanted` now the last one.
    #[inline]
    pub fn find(&mut self, now: &Instant<'_>, wanted: &Wanted) {
        let question = wanted.question(now);
        if !same(&self.last().question, &question) {
            self.look(now, wanted, &question);
        }
    }

    #[cold]
    #[inline(never)]
    fn look(&mut self, now: &Instant<'_>, wanted: &Wanted, question: &Question) {
        self.last = !self.last;
        if same(&self.last().question, question) {
            return;
        }
        let (p, table) = (now.p, Params::TABLE_1);
        let model = Reduced::referred_to(p, now.g, wanted.g_ref, p.c_o);
        let at = At {
            model,
            lowest: Reduced::new(&table, lowest_ratios(&table), table.c_o),
            told: wanted.told,
            radius: radius(p),
        };
        *self.last_mut() = Answer {
            question: *question,
            j_ct2_eq: model.j_ct2_eq,
            a: model.a_slip(),
            design: (wanted.design)(wanted.gains, &at, wanted.h),
            ..Answer::NONE
        };
    }
}

/// Whether two questions are the same, bit by bit.
#[inline]
fn same(one: &Question, other: &Question) -> bool {
    let pairs = one.iter().zip(other);
    pairs.fold(0, |apart, (a, b)| apart | (a.to_bits() ^ b.to_bits())) == 0
}

#[cfg(test)]
mod tests {
    use super::{Answers, Design, GAINS, Wanted, zeros};
    use crate::Params;
    use crate::observer::instant::Instant;
    use crate::observer::{Lyapunov, Observer as _, Paper, Sample, Settings};
    use crate::params::Actuation;
    use core::sync::atomic::{AtomicU32, Ordering};

    /// Steps of a third of a millisecond alternate; a gear, a parameter and a gain change once each.
    #[test]
    fn gains_are_found_once_for_as_long_as_all_stays() {
        static FOUND: AtomicU32 = AtomicU32::new(0);
        let mut answers = Answers::default();
        let mut ask = |p: &Params, gear: [i32; 2], l_11: f64| {
            for k in 0..100 {
                let sample = Sample {
                    gear,
                    ..Sample::default()
                };
                let now = Instant::new(p, &sample);
                let wanted = Wanted {
                    g_ref: now.g[1],
                    told: None,
                    h: [333_333_333e-12, 333_333_334e-12][k % 2],
                    gains: [l_11; GAINS],
                    design: |_, _, _| {
                        FOUND.fetch_add(1, Ordering::Relaxed);
                        Design {
                            l: zeros(),
                            adaptation: zeros(),
                        }
                    },
                };
                answers.find(&now, &wanted);
            }
        };
        let heavy = Params {
            j_v: 200.0,
            ..Params::TABLE_1
        };
        ask(&Params::TABLE_1, [1, 2], 80.0);
        ask(&Params::TABLE_1, [3, 2], 80.0);
        ask(&heavy, [3, 2], 80.0);
        ask(&heavy, [3, 2], 81.0);
        assert_eq!(FOUND.load(Ordering::Relaxed), 2 * 4);
    }

    /// A drive of 40 s in which everything changes that gains and model follow from: steps, gears, a wheel that is
    /// held, which clutch carries, parameters and gains.
    fn drive(mut step: impl FnMut(&Params, &Settings, &Sample, f64)) {
        for k in 0..4000_u16 {
            let time = f64::from(k) * 1e-2;
            let (mut p, mut settings) = (Params::TABLE_1, Settings::CASE_1);
            p.j_v += f64::from(k / 1900);
            for clutch in &mut p.clutch {
                clutch.r_c_n *= f64::from(1 + 2 * (k / 2500));
            }
            settings.gains.l_11 += f64::from(k / 2800);
            settings.lyapunov.p_3 += f64::from(k / 3100);
            let (slip, omega_w) = ((40.0 - 2.0 * time).max(0.0), (time - 3.0).max(0.0));
            let held = if time < 4.0 { 2000.0 } else { 0.0 };
            let sample = Sample {
                t_e: 60.0,
                omega_e: 18.0 * omega_w + slip,
                omega_c: [18.0 * omega_w, 11.5 * omega_w],
                omega_w,
                actuation: [[6e-3, 0.0], [6e-3, 6e-3], [0.0, 6e-3]][usize::from(k / 700 % 3)].map(
                    |position| Actuation {
                        position,
                        pressure: 0.0,
                    },
                ),
                gear: [[1, 2], [3, 2], [3, 0]][usize::from(k / 1000 % 3)],
                t_brake: held,
                ..Sample::default()
            };
            step(
                &p,
                &settings,
                &sample,
                [1e-3, 1e-2][usize::from(k / 300 % 2)],
            );
        }
    }

    /// What is kept between steps is what would be found anew, to the last bit.
    #[test]
    fn nothing_that_is_kept_differs_from_what_would_be_found() {
        let (mut kept, mut anew) = ((Paper::default(), Lyapunov::default()), None);
        drive(|p, settings, sample, h| {
            let (paper, lyapunov) = anew.get_or_insert_with(|| {
                kept.0.start(p, settings, sample);
                kept.1.start(p, settings, sample);
                kept
            });
            (paper.core.answers, lyapunov.core.answers) = (Answers::default(), Answers::default());
            let [one, other] = [&mut kept.0, paper].map(|o| o.step(p, settings, sample, h));
            assert_eq!(one, other);
            assert_eq!(kept.0.core.answers.last(), paper.core.answers.last());
            let [one, other] = [&mut kept.1, lyapunov].map(|o| o.step(p, settings, sample, h));
            assert_eq!(one, other);
            assert_eq!(kept.1.core.answers.last(), lyapunov.core.answers.last());
        });
    }
}
