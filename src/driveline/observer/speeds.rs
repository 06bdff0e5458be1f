//! Model on the three measured speeds: what `kalman` and `calibrating` are built on, and `energy` with the damper.
//!
//! ```text
//! J_ed ω_e'  = T_e − T_c1 − T_c2                     from (1), (2) with a stiff damper
//! J_out ω_o' = g1 T_c1 + g2 T_c2 + T_y − T_o         from (4), (5), (8) with stiff transfer shafts
//! J_v ω_w'   = T_o − T_v                             (9)
//! T_o = T_s + c (ω_o − ω_w),  T_s' = k (ω_o − ω_w)   (10)
//! ```
//!
//! T_y is what synchronisers do ([`shift`](crate::observer::shift)). The states do not refer to a gear, so a new gear or another acting clutch makes no jump. With clutch i
//! engaged ω_e = g_i ω_o, and T_ci is the constraint torque of (6), found without differentiating:
//!
//! ```text
//! ω_o' = (g_i (T_e − T_cj) + g_j T_cj + T_y − T_o)/(J_out + g_i² J_ed),   T_ci = T_e − T_cj − J_ed g_i ω_o'
//! ```

use crate::Params;
use crate::observer::Sample;
use nalgebra::{Matrix4, Matrix4x5, RowVector4, RowVector5, Vector4};

/// The model for one pair of gears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// J_ed [kg·m²].
    pub j_ed: f64,
    /// J_out [kg·m²].
    pub j_out: f64,
    /// J_v [kg·m²].
    pub j_v: f64,
    /// g1, g2 [1]; 0 in neutral.
    pub g: [f64; 2],
    /// k_o [N·m/rad].
    pub k: f64,
    /// c_o [N·m·s/rad].
    pub c: f64,
}

impl Speeds {
    /// The model for the gears of a sample.
    pub fn new(p: &Params, gear: [i32; 2]) -> Self {
        let g = p.g(gear);
        Self {
            j_ed: p.j_ed(),
            j_out: p.j_out(g),
            j_v: p.j_v,
            g,
            k: p.k_o,
            c: p.c_o,
        }
    }

    /// A for the states (ω_e, ω_o, ω_w, T_s), shape (4, 4), with both clutches free.
    pub fn a(&self) -> Matrix4<f64> {
        let (k, c, j_v) = (self.k, self.c, self.j_v);
        let t_o = RowVector4::new(0.0, c, -c, 1.0);
        let mut a = Matrix4::zeros();
        a.set_row(1, &(t_o / -self.j_out));
        a.set_row(2, &(t_o / j_v));
        a.set_row(3, &RowVector4::new(0.0, k, -k, 0.0));
        a
    }

    /// B for the torques (T_e, T_c1, T_c2, T_v, T_y), shape (4, 5), with both clutches free.
    pub fn b(&self) -> Matrix4x5<f64> {
        let [g1, g2] = self.g;
        let mut b = Matrix4x5::zeros();
        b.set_row(0, &(RowVector5::new(1.0, -1.0, -1.0, 0.0, 0.0) / self.j_ed));
        b.set_row(1, &(RowVector5::new(0.0, g1, g2, 0.0, 1.0) / self.j_out));
        b[(2, 3)] = -1.0 / self.j_v;
        b
    }

    /// T_o [N·m] of a state.
    pub fn t_o(&self, x: &Vector4<f64>) -> f64 {
        x[3] + self.c * (x[1] - x[2])
    }

    /// T_ci of the engaged clutch `i` [N·m]: (6) without differentiating.
    ///
    /// `other`: torque of the other clutch [N·m]. `t_y`: that of synchronisers [N·m].
    pub fn constraint_torque(
        &self,
        x: &Vector4<f64>,
        i: usize,
        t_e: f64,
        other: f64,
        t_y: f64,
    ) -> f64 {
        let (g, g_j) = (self.g[i], self.g[1 - i]);
        let acting = g * (t_e - other) + g_j * other + t_y - self.t_o(x);
        t_e - other - self.j_ed * g * acting / self.j_together(i)
    }

    /// J_out + g_i² J_ed: gearbox and engine at the output while clutch `i` is engaged [kg·m²].
    fn j_together(&self, i: usize) -> f64 {
        self.j_out + self.g[i] * self.g[i] * self.j_ed
    }
}

/// ω_o [rad/s] from every shaft that has a gear in, as least squares on the shafts' speeds; ω_w without.
pub fn output_speed(g: [f64; 2], sample: &Sample) -> f64 {
    let weight = g[0] * g[0] + g[1] * g[1];
    if weight == 0.0 {
        return sample.omega_w;
    }
    (g[0] * sample.omega_c[0] + g[1] * sample.omega_c[1]) / weight
}

#[cfg(test)]
mod tests {
    use super::{Speeds, output_speed};
    use crate::Params;
    use crate::observer::Sample;
    use nalgebra::{Vector4, Vector5};

    const P: Params = Params::TABLE_1;
    /// Round-off of a few products.
    const TOLERANCE: f64 = 1e-9;

    /// With the constraint torque the free model keeps ω_e = g_i ω_o.
    #[test]
    fn constraint_torque_keeps_both_sides_of_the_clutch_together() {
        let model = Speeds::new(&P, [1, 2]);
        let x = Vector4::new(180.0, 10.0, 9.7, 500.0);
        for (i, other) in [(0, 12.0), (1, -7.0)] {
            let mut v = Vector5::new(60.0, other, other, 250.0, -30.0);
            v[1 + i] = model.constraint_torque(&x, i, 60.0, other, -30.0);
            let x_dot = model.a() * x + model.b() * v;
            assert!((x_dot[0] - model.g[i] * x_dot[1]).abs() < TOLERANCE);
        }
    }

    #[test]
    fn energy_falls_by_the_loss_in_the_drive_shaft() {
        let model = Speeds::new(&P, [1, 2]);
        let x = Vector4::new(180.0, 10.0, 9.7, 500.0);
        let x_dot = model.a() * x;
        let inertias = Vector4::new(model.j_ed, model.j_out, model.j_v, 1.0 / model.k);
        let power = inertias.component_mul(&x).dot(&x_dot);
        assert!((power + P.c_o * 0.3 * 0.3).abs() < TOLERANCE, "{power} W");
    }

    #[test]
    fn output_speed_comes_from_the_shafts_that_have_a_gear() {
        let sample = Sample {
            omega_c: [180.0, 115.2],
            omega_w: 9.0,
            ..Sample::default()
        };
        for g in [[18.0, 11.52], [18.0, 0.0], [0.0, 11.52]] {
            assert!((output_speed(g, &sample) - 10.0).abs() < TOLERANCE);
        }
        assert_eq!(output_speed([0.0, 0.0], &sample), 9.0);
    }
}
