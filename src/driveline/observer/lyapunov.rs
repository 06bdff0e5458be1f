//! Method `lyapunov`: the paper's observer with gains for which its proof holds.
//!
//! The paper derives (27) from V = ½ x̃1² + ½ x̃2² + ½ (c x̃2 − x̃3)² + …, which adds (rad/s)² to (N·m)².
//! With a weight for each term,
//!
//! ```text
//! V = ½ p1 x̃1² + ½ p2 x̃2² + ½ p3 z² + Σ ε̃_i²/(2 L_ci),   z = c x̃2 − x̃3
//! x̃1' = x̃3/J − L11 x̃1 − L12 x̃2 − Σ a_i m_i ε̃_i,            m_i = r_ci N_i θ_mi,  J = J_ct2,eq
//! x̃2' = −b x̃3 − L21 x̃1 − L22 x̃2 + Σ h_i m_i ε̃_i
//! z'  = −k x̃2 + (L31 − c L21) x̃1 + (L32 − c L22) x̃2            from (15): x̃3' − c x̃2' = k x̃2 − …
//! ```
//!
//! (T̃_v = 0 and ε' = 0 are taken as in the paper). Put x̃3 = c x̃2 − z and collect V̇:
//!
//! ```text
//! x̃1 x̃2:  p1 (c/J − L12) − p2 L21 = 0      x̃1 z:  −p1/J + p3 (L31 − c L21) = 0
//! x̃2 z:    p2 b + p3 (L32 − c L22 − k) = 0    x̃1²:  −p1 L11     x̃2²:  −p2 (L22 + c b)
//! ε̃_i:     m_i (−p1 a_i x̃1 + p2 h_i x̃2) ε̃_i − ε̃_i ε̂_i'/L_ci = 0
//! ```
//!
//! L21 = 0, L12 = c/J, L31 = (p1/p3)/J, L32 = k + c L22 − (p2/p3) b and
//! ε̂_i' = L_ci (−p1 a_i x̃1 + p2 h_i x̃2) m_i give
//!
//! ```text
//! V̇ = −p1 L11 x̃1² − p2 (L22 + c b) x̃2² ≤ 0   for L11 > 0, L22 > −c b.
//! ```
//!
//! **Proof: this one**, in continuous time, for a friction that stays and a load that is known. V̇ says
//! nothing of z and ε̃: they follow by LaSalle's invariance while the clutches excite them. With one clutch
//! transmitting, x̃1 = x̃2 = 0 leaves z = 0 and ε̃ = 0 only; with both, T̃_o : T̃_c1 : T̃_c2 = 1 : 0.32 : −0.39
//! remains (erratum E5). Holding the innovation over a sample is outside the proof.
//!
//! **Weights.** p1 = p2 = p3, the paper's, is nearly blind to T_o: its slowest pole is at −7·10⁻⁶ 1/s and a
//! wheel-speed bias of 0.01 rad/s gives an error of 111 %. V scales, so p1 = 1 here.

use crate::Params;
use crate::observer::adaptive::{Adaptive, At, Design};
use crate::observer::schedule::scaled;
use crate::observer::{Estimate, Observer, Sample, Settings, Visit};
use crate::reduced::Reduced;
use nalgebra::SMatrix;

/// Gains and weights that the proof leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// L11 [1/s], > 0.
    pub l_11: f64,
    /// L22 [1/s], ≥ 0.
    pub l_22: f64,
    /// L_c1, L_c2 with θ in m and p1 = 1, shape (2).
    pub l_c: [f64; 2],
    /// p2: weight of x̃2² over that of x̃1² [1], > 0.
    pub p_2: f64,
    /// p3: weight of z² over that of x̃1² [(rad/s)²/(N·m)²], > 0.
    pub p_3: f64,
}

impl Gains {
    /// For a step of 1 ms.
    pub const AT_1_KHZ: Self = Self {
        l_11: 48.0,
        l_22: 0.1,
        l_c: [1360e6, 1360e6],
        p_2: 20.0,
        p_3: 1.0 / 5800.0,
    };
    /// For a step of 10 ms.
    pub const AT_100_HZ: Self = Self {
        l_11: 35.0,
        l_22: 0.1,
        l_c: [400e6, 400e6],
        p_2: 20.0,
        p_3: 1.0 / 2500.0,
    };

    /// These gains, given for 1 ms, at a step `h` [s]: see `scaled`.
    pub fn at_step(&self, h: f64) -> Self {
        let [fast, slow] = [Self::AT_1_KHZ, Self::AT_100_HZ];
        Self {
            l_11: scaled(self.l_11, [fast.l_11, slow.l_11], 1, h),
            l_22: scaled(self.l_22, [fast.l_22, slow.l_22], 1, h),
            l_c: [0, 1].map(|i| scaled(self.l_c[i], [fast.l_c[i], slow.l_c[i]], 2, h)),
            p_2: self.p_2,
            p_3: scaled(self.p_3, [fast.p_3, slow.p_3], 0, h),
        }
    }

    /// These gains, given for the model of the lowest gears, for another pair of gears.
    ///
    /// The proof holds for any weights, so each pair may have its own: (p3/p1) J² and (p2/p3) b stay, and
    /// with them L31/J and L32. With the same weights in all gears L32 would turn negative.
    pub fn in_gear(&self, model: &Reduced, lowest: &Reduced) -> Self {
        let j = lowest.j_ct2_eq / model.j_ct2_eq;
        let p_3 = self.p_3 * j * j;
        let b = lowest.b_coupling() / model.b_coupling();
        Self {
            p_2: self.p_2 / self.p_3 * b * p_3,
            p_3,
            ..*self
        }
    }

    /// L of (19) for which V falls, shape (3, 2).
    pub fn l(&self, model: &Reduced) -> SMatrix<f64, 3, 2> {
        let (j, c, b) = (model.j_ct2_eq, model.c_o_eq, model.b_coupling());
        SMatrix::<f64, 3, 2>::new(
            self.l_11,
            c / j, //
            0.0,
            self.l_22, //
            1.0 / (self.p_3 * j),
            model.k_o_eq + c * self.l_22 - self.p_2 / self.p_3 * b,
        )
    }
}

/// The observer with the proof.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lyapunov {
    /// State and equations shared with `paper`.
    pub core: Adaptive,
}

/// Gains for a step `h` [s].
fn design(settings: &Settings, h: f64, at: &At) -> Design {
    let gains = if settings.scheduled {
        settings.lyapunov.at_step(h)
    } else {
        settings.lyapunov
    };
    let gains = gains.in_gear(&at.model, &at.lowest);
    Design {
        l: gains.l(&at.model),
        weight: [1.0, gains.p_2],
        l_c: gains.l_c,
    }
}

impl Observer for Lyapunov {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let design = |at: &_| design(settings, 1e-3, at);
        self.core.start(p, settings, sample, design)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        let design = |at: &_| design(settings, h, at);
        self.core.step(p, settings, sample, h, design)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.core.visit(visit);
    }
}
