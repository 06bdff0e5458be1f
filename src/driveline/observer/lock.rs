//! Which clutches are fully engaged, from measured slip and actuators.
//!
//! What is measured before a clutch is ω_e, not ω_d of (2). When a slipping clutch locks, its torque falls from
//! μ F r_c N to what the driveline needs, and the damper swings: ω_e − ω_ci, 0 behind the damper, reaches
//!
//! ```text
//! ΔT_c/√(k_d J_e), and dies with the time constant 2 J_e/c_d                    from (1), (3)
//! ```
//!
//! which a large torque takes beyond any fixed threshold. So a clutch that has locked may swing by as much. A
//! synchroniser on the other shaft kicks J_out against damper and drive shaft, by at most
//!
//! ```text
//! g_i T_y/√(J_out (g_i² k_d + k_o))                                                    from (4), (8), (10)
//! ```

use crate::Params;
use crate::observer::{Sample, Visit};
use nalgebra::ComplexField;

/// Slip below which a clutch may be engaged [rad/s].
pub const SLIP: f64 = 3.0;
/// Time for which it has to be [s].
const TIME: f64 = 0.03;

/// How long each clutch has been pressed without slip [s], shape (2).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lock {
    /// Time pressed without slip [s], shape (2), at most the time that it takes.
    pub since: [f64; 2],
    /// Swing of the damper that may show as slip [rad/s], shape (2).
    pub swing: [f64; 2],
}

impl Lock {
    /// At the start of a run a clutch that is pressed without slip has been so before.
    pub fn start(&mut self, p: &Params, sample: &Sample) {
        self.step(p, sample, [0.0; 2], TIME);
    }

    /// Takes a sample `h` [s] after the last one; `t_c`: estimated torques of the clutches [N·m], shape (2).
    pub fn step(&mut self, p: &Params, sample: &Sample, t_c: [f64; 2], h: f64) {
        for i in [0, 1] {
            self.swing[i] = self.swing[i].max(kick(p, sample, i));
        }
        let (g, slips) = (p.g(sample.gear), self.slips(sample));
        for i in [0, 1] {
            let pressed = p.clutch[i].force(sample.actuation[i]) > 0.0;
            if pressed && !slips[i] && g[i] != 0.0 {
                self.since[i] = (self.since[i] + h).min(TIME);
                self.swing[i] *= ComplexField::exp(-h * p.c_d / (2.0 * p.j_e));
            } else {
                self.since[i] = 0.0;
                self.swing[i] = t_c[i].abs() / ComplexField::sqrt(p.k_d * p.j_e);
            }
        }
    }

    /// The slip is beyond what a locked clutch shows, shape (2).
    pub fn slips(&self, sample: &Sample) -> [bool; 2] {
        let slip = sample.slip();
        [0, 1].map(|i| {
            let swing = if self.since[i] > 0.0 {
                self.swing[i]
            } else {
                0.0
            };
            slip[i].abs() >= SLIP + swing
        })
    }

    /// Fully engaged clutches, shape (2).
    pub fn engaged(&self) -> [bool; 2] {
        self.since.map(|since| since >= TIME)
    }

    /// The one clutch that is engaged while the other is open: (20) holds.
    pub fn alone(&self, p: &Params, sample: &Sample) -> Option<usize> {
        let open = [0, 1].map(|i| p.clutch[i].force(sample.actuation[i]) <= 0.0);
        match (self.engaged(), open) {
            ([true, _], [_, true]) => Some(0),
            ([_, true], [true, _]) => Some(1),
            _ => None,
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        self.since.iter_mut().chain(&mut self.swing).for_each(visit);
    }
}

/// Swing of the damper behind clutch `i` that synchronisers bring about [rad/s].
fn kick(p: &Params, sample: &Sample, i: usize) -> f64 {
    let g = p.g(sample.gear);
    let stiffness = g[i] * g[i] * p.k_d + p.k_o;
    g[i].abs() * sample.t_y.abs() / ComplexField::sqrt(p.j_out(g) * stiffness)
}

#[cfg(test)]
mod tests {
    use super::Lock;
    use crate::Params;
    use crate::observer::Sample;
    use crate::params::Actuation;

    const H: f64 = 1e-3;

    /// A clutch that carried `t_c` [N·m] locks and the damper swings by `swing` [rad/s] for 1 s.
    fn stays_engaged(t_c: f64, swing: f64) -> bool {
        let (p, mut lock) = (Params::TABLE_1, Lock::default());
        let mut step = |slip: f64| {
            let sample = Sample {
                omega_e: 100.0 + slip,
                omega_c: [100.0, 64.0],
                gear: [1, 2],
                actuation: [8e-3, 0.0].map(|position| Actuation {
                    position,
                    pressure: 0.0,
                }),
                ..Sample::default()
            };
            lock.step(&p, &sample, [t_c, 0.0], H);
            lock.engaged()[0]
        };
        for k in 0..80 {
            step(8.0 - 0.1 * f64::from(k));
        }
        (0..1000).all(|k| {
            let time = f64::from(k) * H;
            step(-swing * f64::sin(28.0 * time) * f64::exp(-time))
        })
    }

    #[test]
    fn a_swing_of_the_damper_is_no_slip() {
        assert!(stays_engaged(140.0, 6.0));
    }

    #[test]
    fn more_than_the_torque_explains_is_slip() {
        assert!(!stays_engaged(20.0, 6.0));
    }
}
