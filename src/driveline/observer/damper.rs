//! An engaged clutch behind the damper (1)-(3): what `energy` is a copy of.
//!
//! ```text
//! free:       J_ed ω_e' = T_e − T_c1 − T_c2                        J_out ω_o' = g1 T_c1 + g2 T_c2 + T_y − T_o
//! i engaged:  J_e ω_e' = T_e − T_d        (J_out + g_i² J_d) ω_o' = g_i (T_d − T_cj) + g_j T_cj + T_y − T_o
//!             T_d = T_k + c_d (ω_e − g_i ω_o),  T_k' = k_d (ω_e − g_i ω_o)
//! both:       J_v ω_w' = T_o − T_v,  T_o = T_s + c (ω_o − ω_w),  T_s' = k (ω_o − ω_w)
//! ```
//!
//! A stiff damper would make the engaged clutch a constraint ω_e = g_i ω_o. But when a slipping clutch locks under
//! power its torque falls, and for half a second engine and gearbox swing against each other through the damper, with
//! a torque as large as before. Both of their speeds are measured, so the damper's torque is known as that of the
//! drive shaft is, and with it, behind the small J_d, that of the clutch:
//!
//! ```text
//! T_ci = T_d − T_cj − J_d g_i ω_o'
//! ```
//!
//! While no clutch is engaged T_k is what the clutches transmit, which is what the damper holds when one locks.

use crate::Params;
use crate::observer::Sample;
use crate::observer::speeds::{Speeds, damper};
use crate::reduced::exponential;
use nalgebra::{RowSVector, SMatrix, SVector};

/// States: ω_e, ω_o, ω_w [rad/s], T_s, T_k [N·m].
pub const STATES: usize = 5;
/// Inputs: T_e, T_c1, T_c2, T_v, T_y [N·m].
const INPUTS: usize = 5;
/// Speeds that are measured: ω_e, ω_o, ω_w.
pub const SPEEDS: usize = 3;
const AUGMENTED: usize = STATES + INPUTS + SPEEDS;

/// (ω_e, ω_o, ω_w, T_s, T_k), shape (5).
pub type State = SVector<f64, STATES>;
/// (T_e, T_c1, T_c2, T_v, T_y) [N·m], shape (5).
pub type Torques = SVector<f64, INPUTS>;
type Row = RowSVector<f64, STATES>;

/// The model for one pair of gears, with one clutch engaged or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Behind {
    /// The driveline from the clutches on.
    pub speeds: Speeds,
    /// J_e [kg·m²].
    pub j_e: f64,
    /// J_d [kg·m²].
    pub j_d: f64,
    /// k_d [N·m/rad].
    pub k_d: f64,
    /// c_d [N·m·s/rad].
    pub c_d: f64,
    /// The clutch that is engaged.
    pub engaged: Option<usize>,
}

impl Behind {
    /// The model for the gears of a sample.
    pub fn new(p: &Params, sample: &Sample, engaged: Option<usize>) -> Self {
        let speeds = Speeds::new(p, sample.gear);
        let [k_d, c_d] = engaged.map_or([p.k_d, p.c_d], |i| damper(p, speeds.g, i));
        Self {
            speeds,
            j_e: p.j_e,
            j_d: p.j_d,
            k_d,
            c_d,
            engaged,
        }
    }

    /// A, shape (5, 5), and B, shape (5, 5).
    fn matrices(&self) -> (SMatrix<f64, STATES, STATES>, SMatrix<f64, STATES, INPUTS>) {
        let (s, [g1, g2]) = (&self.speeds, self.speeds.g);
        let mut a = SMatrix::<f64, STATES, STATES>::zeros();
        let mut b = SMatrix::<f64, STATES, INPUTS>::zeros();
        let t_o = Row::from([0.0, s.c, -s.c, 1.0, 0.0]);
        a.set_row(2, &(t_o / s.j_v));
        a.set_row(3, &(Row::from([0.0, s.k, -s.k, 0.0, 0.0])));
        b[(2, 3)] = -1.0 / s.j_v;
        let Some(i) = self.engaged else {
            a.set_row(1, &(t_o / -s.j_out));
            b.set_row(0, &(Row::from([1.0, -1.0, -1.0, 0.0, 0.0]) / s.j_ed));
            b.set_row(1, &(Row::from([0.0, g1, g2, 0.0, 1.0]) / s.j_out));
            return (a, b);
        };
        let (g, output) = (s.g[i], self.output(i));
        let twist = Row::from([1.0, -g, 0.0, 0.0, 0.0]);
        let t_d = twist * self.c_d + Row::from([0.0, 0.0, 0.0, 0.0, 1.0]);
        a.set_row(0, &(t_d / -self.j_e));
        a.set_row(1, &((t_d * g - t_o) / output));
        a.set_row(4, &(twist * self.k_d));
        b[(0, 0)] = 1.0 / self.j_e;
        let mut by = Row::from([0.0, g1 - g, g2 - g, 0.0, 1.0]);
        by[1 + i] = 0.0;
        b.set_row(1, &(by / output));
        (a, b)
    }

    /// J_out + g_i² J_d: what turns with the output behind the damper [kg·m²].
    fn output(&self, i: usize) -> f64 {
        let g = self.speeds.g[i];
        self.speeds.j_out + g * g * self.j_d
    }

    /// T_o [N·m] of a state.
    pub fn t_o(&self, x: &State) -> f64 {
        x[3] + self.speeds.c * (x[1] - x[2])
    }

    /// T_ci of the engaged clutch `i` [N·m]; `other`: torque of the other one, `t_y`: of synchronisers [N·m].
    pub fn clutch_torque(&self, x: &State, i: usize, other: f64, t_y: f64) -> f64 {
        let (g, g_j) = (self.speeds.g[i], self.speeds.g[1 - i]);
        let t_d = x[4] + self.c_d * (x[0] - g * x[1]);
        let acting = g * (t_d - other) + g_j * other + t_y - self.t_o(x);
        t_d - other - self.j_d * g * acting / self.output(i)
    }

    /// x⁺ = Φ x + Γ v + Γ_l ω̃ over a step `h` [s] with gains `l` on the speeds [1/s], shape (3), exactly.
    pub fn discrete(&self, l: [f64; SPEEDS], h: f64) -> Discrete {
        let (a, b) = self.matrices();
        let mut m = SMatrix::<f64, AUGMENTED, AUGMENTED>::zeros();
        m.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(&a);
        m.fixed_view_mut::<STATES, INPUTS>(0, STATES).copy_from(&b);
        for (j, l) in l.into_iter().enumerate() {
            m[(j, STATES + INPUTS + j)] = l;
        }
        let psi = exponential(&(m * h));
        Discrete {
            phi: psi.fixed_view::<STATES, STATES>(0, 0).into_owned(),
            gamma: psi.fixed_view::<STATES, INPUTS>(0, STATES).into_owned(),
            gamma_l: psi
                .fixed_view::<STATES, SPEEDS>(0, STATES + INPUTS)
                .into_owned(),
        }
    }
}

/// x⁺ = Φ x + Γ v + Γ_l ω̃.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    /// Φ, shape (5, 5).
    pub phi: SMatrix<f64, STATES, STATES>,
    /// Γ of (T_e, T_c1, T_c2, T_v, T_y), shape (5, 5).
    pub gamma: SMatrix<f64, STATES, INPUTS>,
    /// Γ_l of the speeds' errors, shape (5, 3).
    pub gamma_l: SMatrix<f64, STATES, SPEEDS>,
}

#[cfg(test)]
mod tests {
    use super::{Behind, State, Torques};
    use crate::Params;
    use crate::observer::Sample;
    use crate::observer::speeds::Speeds;
    use nalgebra::Vector5;

    const P: Params = Params::TABLE_1;
    /// Round-off of a few products.
    const TOLERANCE: f64 = 1e-9;

    fn model(engaged: Option<usize>) -> Behind {
        let sample = Sample {
            gear: [1, 2],
            ..Sample::default()
        };
        Behind::new(&P, &sample, engaged)
    }

    fn state() -> State {
        Vector5::new(180.5, 10.0, 9.7, 500.0, 40.0)
    }

    /// (4), (5), (8) with the clutch torque that is told: it moves the output as the engaged model does.
    #[test]
    fn torque_of_the_engaged_clutch_is_what_turns_the_output() {
        for (i, other) in [(0, 12.0), (1, -7.0)] {
            let (engaged, x) = (model(Some(i)), state());
            let mut v = Torques::from([60.0, other, other, 250.0, -30.0]);
            let (a, b) = engaged.matrices();
            let omega_o_dot = (a * x + b * v)[1];
            v[1 + i] = engaged.clutch_torque(&x, i, other, -30.0);
            let (a, b) = model(None).matrices();
            assert!((omega_o_dot - (a * x + b * v)[1]).abs() < TOLERANCE);
        }
    }

    /// V̇ of the observer's proof without gains: no term but the dampings.
    #[test]
    fn energy_falls_by_the_losses_in_damper_and_drive_shaft() {
        for i in [0, 1] {
            let (behind, x) = (model(Some(i)), state());
            let x_dot = behind.matrices().0 * x;
            let Behind { k_d, c_d, .. } = behind;
            let Speeds { k, c, .. } = behind.speeds;
            let inertias = Vector5::new(P.j_e, behind.output(i), P.j_v, 1.0 / k, 1.0 / k_d);
            let power = inertias.component_mul(&x).dot(&x_dot);
            let twist = x[0] - behind.speeds.g[i] * x[1];
            let lost = c * 0.3 * 0.3 + c_d * twist * twist;
            assert!((power + lost).abs() < 1e-7, "{power} {lost} W");
        }
    }
}
