//! The damper while no clutch is engaged: how `calibrating` reads ω_e.
//!
//! Its ω_e is then that of J_e and J_d as one, but a sensor reads J_e alone, and J_d swings behind it whenever T_c or T_e
//! changes its pace. From (1)-(3), with T_c that of both clutches,
//!
//! ```text
//! ω̄ = (J_e ω_e + J_d ω_d)/J_ed             J_ed ω̄' = T_e − T_c                      ω_e = ω̄ + (J_d/J_ed) s
//! s = ω_e − ω_d      s' = T_e/J_e + T_c/J_d − (T_k + c_d s)(1/J_e + 1/J_d)           T_k' = k_d s
//! ```
//!
//! A swing of `dry7` (J_d/J_ed = 1/4, 20 Hz) moves ω_e by more than quiet speeds are believed to be noisy. Taken for an
//! acceleration of all, it was learnt as errors of δ, γ, λ and ν; as they are ratios to T_e, the common factor went with them.
//!
//! It dies within 0.05 s, so it is computed and not estimated. T_c is what the filter says, but for its last 0.05 s: it
//! moves with the force at once, and what the filter corrects comes through a low pass. As told by the filter it would
//! answer to the innovation that it makes, and `dry7` diverges. In a handover, where both torques are known least, it is
//! not read. `kalman`, which believes in noisy speeds, gains nothing by it.

use crate::Params;
use crate::observer::Visit;

/// Time constant with which what the filter corrects of T_c comes in [s]: 0.02 to 0.1 give the same.
const TAU: f64 = 0.05;
/// Longest part of a step [s].
const PART: f64 = 1e-3;
/// Step over which a swing is not followed [s].
const LASTS: f64 = 0.05;

/// The damper, and what winds it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Swing {
    /// ω_e − ω̄ [rad/s].
    pub shown: f64,
    /// T_k [N·m].
    pub spring: f64,
    /// T_c of both clutches, through the low pass [N·m].
    pub load: f64,
}

impl Swing {
    /// A damper that does not swing between the engine and clutches that carry `t_c` [N·m].
    pub fn rest(p: &Params, t_e: f64, t_c: f64) -> Self {
        Self {
            shown: 0.0,
            spring: (p.j_d * t_e + p.j_e * t_c) / p.j_ed(),
            load: t_c,
        }
    }

    /// Over a step `h` [s], by the trapezoidal rule in parts that follow a swing; a long one is over by then.
    ///
    /// `j_e`: inertia of the engine [kg·m²], `t_e` and `t_c`: torques of engine and clutches [N·m].
    pub fn step(&mut self, p: &Params, j_e: f64, [t_e, t_c]: [f64; 2], h: f64) {
        if h > LASTS {
            *self = Self::rest(p, t_e, t_c);
            return;
        }
        self.load += (t_c - self.load) * (h / (h + TAU));
        let mut left = h;
        while left > 0.0 {
            self.part(p, j_e, t_e, left.min(PART));
            left -= PART;
        }
    }

    /// Over a part of a step, `h` [s].
    fn part(&mut self, p: &Params, j_e: f64, t_e: f64, h: f64) {
        let (share, both) = (p.j_d / (j_e + p.j_d), 1.0 / j_e + 1.0 / p.j_d);
        let (before, half) = (self.shown / share, 0.5 * h);
        let push = t_e / j_e + self.load / p.j_d - self.spring * both;
        let mean = (before + half * push) / (1.0 + half * (p.c_d + half * p.k_d) * both);
        self.spring += h * p.k_d * mean;
        self.shown = share * (2.0 * mean - before);
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            shown,
            spring,
            load,
        } = self;
        visit(shown);
        visit(spring);
        visit(load);
    }
}

#[cfg(test)]
mod tests {
    use super::{Swing, TAU};
    use crate::Params;

    const H: f64 = 1e-4;

    /// ω_e, ω_d [rad/s] and T_k [N·m] of (1)-(3) as printed.
    #[derive(Clone, Copy)]
    struct Printed {
        omega: [f64; 2],
        t_k: f64,
    }

    impl Printed {
        /// Over `H`, semi-implicit Euler in steps a hundred times shorter; ω_e less that of both inertias [rad/s].
        fn step(&mut self, p: &Params, [t_e, t_c]: [f64; 2]) -> f64 {
            const FINER: u32 = 100;
            let step = H / f64::from(FINER);
            let [e, d] = &mut self.omega;
            for _ in 0..FINER {
                let t_d = self.t_k + p.c_d * (*e - *d);
                *e += step * (t_e - t_d) / p.j_e;
                *d += step * (t_d - t_c) / p.j_d;
                self.t_k += step * p.k_d * (*e - *d);
            }
            *e - (p.j_e * *e + p.j_d * *d) / p.j_ed()
        }
    }

    /// A launch whose clutch closes within 0.1 s, told by its force.
    #[test]
    fn it_is_the_swing_of_the_damper_as_printed() {
        for p in [Params::TABLE_1, Params::DRY_7, Params::WET_6] {
            let mut swing = Swing::rest(&p, 60.0, 0.0);
            let (omega, t_k) = ([0.0; 2], swing.spring);
            let (mut truth, mut largest, mut off) = (Printed { omega, t_k }, 0.0_f64, [0.0_f64; 2]);
            for k in 0..3000 {
                let torques = [60.0, 80.0 * (f64::from(k) * H / 0.1).min(1.0)];
                swing.load = torques[1];
                swing.step(&p, p.j_e, torques, H);
                let shown = truth.step(&p, torques);
                largest = largest.max(shown.abs());
                off[0] = off[0].max((shown - swing.shown).abs());
                off[1] = off[1].max((truth.t_k - swing.spring).abs());
            }
            assert!(
                off[0] < 0.01 * largest && off[1] < 0.01,
                "{off:?} of {largest} rad/s"
            );
        }
    }

    #[test]
    fn at_rest_it_stays_and_shows_nothing() {
        for p in [Params::TABLE_1, Params::DRY_7] {
            let mut swing = Swing::rest(&p, 60.0, 45.0);
            let before = swing;
            for h in [1e-4, 1e-3, 2e-2] {
                swing.step(&p, p.j_e, [60.0, 45.0], h);
            }
            assert!(swing.shown.abs() < 1e-12 && (swing.spring - before.spring).abs() < 1e-9);
        }
    }

    /// With any step and any inertia that is learnt the swing of a jump of T_c dies.
    #[test]
    fn it_dies_whatever_the_step() {
        for (h, share) in [
            (1e-4, 1.0),
            (1e-3, 0.3),
            (1e-2, 1.7),
            (2e-2, 1.0),
            (0.1, 0.3),
        ] {
            let (p, mut swing) = (Params::DRY_7, Swing::rest(&Params::DRY_7, 60.0, 0.0));
            let mut time = 0.0;
            while time < 20.0 * TAU {
                swing.step(&p, share * p.j_e, [60.0, 80.0], h);
                time += h;
            }
            assert!(swing.shown.abs() < 1e-3, "{h} s, {share}: {swing:?}");
        }
    }
}
