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
use crate::observer::adaptive::{Adaptive, Design};
use crate::observer::schedule::scaled;
use crate::observer::{Estimate, Observer, Sample, Settings, Visit};
use crate::reduced::Reduced;
use nalgebra::SMatrix;

/// Gains that (27) leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains {
    /// L11 [1/s].
    pub l_11: f64,
    /// L22 [1/s].
    pub l_22: f64,
    /// L_c1, L_c2 of (29) with θ in m, shape (2); their unit follows from a V that mixes units.
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

/// Gains for a step `h` [s].
fn design(settings: &Settings, h: f64, model: &Reduced) -> Design {
    let gains = if settings.scheduled {
        settings.gains.at_step(h)
    } else {
        settings.gains
    };
    Design {
        l: gains.l(model),
        weight: [1.0, 1.0],
        l_c: gains.l_c,
    }
}

impl Observer for Paper {
    fn start(&mut self, p: &Params, settings: &Settings, sample: &Sample) -> Estimate {
        let design = |model: &_, _: &_| design(settings, 1e-3, model);
        self.core.start(p, settings, sample, design)
    }

    fn step(&mut self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> Estimate {
        let design = |model: &_, _: &_| design(settings, h, model);
        self.core.step(p, settings, sample, h, design)
    }

    fn visit(&mut self, visit: Visit<'_>) {
        self.core.visit(visit);
    }
}
