//! Model on the three measured speeds: what `kalman` and `calibrating` are built on, and `energy` with the damper.
//!
//! ```text
//! J_ed ω_e'  = T_e − T_c1 − T_c2                     from (1), (2) with a stiff damper
//! J_out ω_o' = g1 T_c1 + g2 T_c2 + T_y − T_o         from (4), (5), (8) with stiff transfer shafts
//! J_v ω_w'   = T_o − T_v                             (9)
//! T_o = T_s + c (ω_o − ω_w),  T_s' = k (ω_o − ω_w)   (10)
//! ```
//!
//! T_y is what synchronisers do ([`shift`](crate::observer::shift)). The states do not refer to a gear, so a new gear or
//! another acting clutch makes no jump. With clutch i engaged the damper stands before it, as in
//! [`damper`](crate::observer::damper): J_e and J_out + g_i² J_d take the places of J_ed and J_out, and T_k, what the
//! damper carries, that of T_ci.
//!
//! **Transfer shafts are not stiff**, and what they give is part of the springs beside them. Let ω_o stand for the mean of
//! the gearbox by inertia, with parts w_i = g_i² J_cti/J_out (J_d added on both sides where a clutch is engaged): (4), (5),
//! (8) summed are then the line of J_out as it stands, and least squares of both input shafts' speeds are that mean where
//! J_ct1 = J_ct2. A shaft winds by a_i = Ṫ_ti/(k_ti i_fi), so that ω_ci/g_i − a_i is the output, the same for both. With
//! K_i = k_ti i_fi², the torques T_ti of (4), (5), and springs whose swing is slow against K_i/(g_i² J_cti),
//!
//! ```text
//! k = k_o/(1 + k_o s),  c = c_o (k/k_o)²                s = Σ w_i²/K_i
//! behind clutch i:  k_d/(1 + k_d s_i),  c_d/(1 + k_d s_i)²        s_i = g_i² ((1 − w_i)²/K_i + w_j²/K_j)
//! ```
//!
//! of Table 1 0.3 % of k_o, 3 and 8 % of k_d (clutch 1 and 2). Left out, an observer that learns puts it into c_o and the
//! common factor.

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
    /// ∂T_v/∂ω_w, where the load is one of the speed [N·m·s/rad].
    pub drag: f64,
    /// k_d [N·m/rad], c_d [N·m·s/rad], J_d [kg·m²] behind which a clutch is engaged; 0 while none is.
    pub damper: [f64; 3],
    /// The clutch that is engaged.
    pub engaged: Option<usize>,
}

impl Speeds {
    /// The model for the gears of a sample.
    pub fn new(p: &Params, gear: [i32; 2]) -> Self {
        let g = p.g(gear);
        let j_out = p.j_out(g);
        let part = share(p, g, j_out);
        let give = give(p);
        let soft =
            1.0 / (1.0 + p.k_o * (part[0] * part[0] * give[0] + part[1] * part[1] * give[1]));
        Self {
            j_ed: p.j_ed(),
            j_out,
            j_v: p.j_v,
            g,
            k: p.k_o * soft,
            c: p.c_o * soft * soft,
            drag: 0.0,
            damper: [0.0; 3],
            engaged: None,
        }
    }

    /// The same with clutch `engaged` behind the damper: J_e and J_out + g_i² J_d in place of J_ed and J_out; k_d, c_d
    /// and J_d times `scale` [1].
    pub fn behind(self, p: &Params, engaged: Option<usize>, scale: f64) -> Self {
        let Some(i) = engaged else { return self };
        let [k_d, c_d] = damper(p, self.g, i);
        Self {
            j_ed: self.j_ed * p.j_e / p.j_ed(),
            j_out: self.j_out + self.g[i] * self.g[i] * p.j_d * scale,
            damper: [k_d, c_d, p.j_d].map(|value| value * scale),
            engaged,
            ..self
        }
    }

    /// T_k' per unit of ω_e and ω_o [N·m/rad], shape (2).
    pub fn twist(&self) -> [f64; 2] {
        let g = self.engaged.map_or(0.0, |i| self.g[i]);
        [self.damper[0], -g * self.damper[0]]
    }

    /// T_c1, T_c2 [N·m] of the states (ω_e, ω_o, ω_w, T_s) and the torques of the clutches, of which that of the
    /// engaged one is T_k; `t_y`: of synchronisers [N·m].
    pub fn clutch_torques(&self, x: &Vector4<f64>, mut t: [f64; 2], t_y: f64) -> [f64; 2] {
        if let Some(i) = self.engaged {
            let (g, other, [_, c_d, j_d]) = (self.g[i], t[1 - i], self.damper);
            let t_d = t[i] + c_d * (x[0] - g * x[1]);
            let acting = g * (t_d - other) + self.g[1 - i] * other + t_y - self.t_o(x);
            t[i] = t_d - other - j_d * g * acting / self.j_out;
        }
        t
    }

    /// A for the states (ω_e, ω_o, ω_w, T_s), shape (4, 4), with both clutches free.
    pub fn a(&self) -> Matrix4<f64> {
        let (k, c, j_v) = (self.k, self.c, self.j_v);
        let t_o = RowVector4::new(0.0, c, -c, 1.0);
        let mut a = Matrix4::zeros();
        a.set_row(1, &(t_o / -self.j_out));
        a.set_row(2, &(t_o / j_v));
        a[(2, 2)] -= self.drag / j_v;
        if let Some(i) = self.engaged {
            let (g, c_d) = (self.g[i], self.damper[1]);
            let t_d = RowVector4::new(c_d, -c_d * g, 0.0, 0.0);
            a.set_row(0, &(t_d / -self.j_ed));
            a.set_row(1, &((t_d * g - t_o) / self.j_out));
        }
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
        if let Some(i) = self.engaged {
            let other = 2 - i; // column of the other clutch
            b[(0, other)] = 0.0;
            b[(1, other)] = (self.g[1 - i] - self.g[i]) / self.j_out;
        }
        b
    }

    /// T_o [N·m] of a state.
    pub fn t_o(&self, x: &Vector4<f64>) -> f64 {
        x[3] + self.c * (x[1] - x[2])
    }
}

/// k_d [N·m/rad] and c_d [N·m·s/rad] of the damper with the transfer shafts behind clutch `i`, shape (2); `g`: ratios.
pub fn damper(p: &Params, g: [f64; 2], i: usize) -> [f64; 2] {
    let (j_d, give) = (g[i] * g[i] * p.j_d, give(p));
    let all = p.j_out(g) + j_d;
    let j = 1 - i;
    let other = g[j] * g[j] * p.j_ct[j] / all;
    let behind = 1.0 - (j_d + g[i] * g[i] * p.j_ct[i]) / all;
    let soft =
        1.0 / (1.0 + p.k_d * g[i] * g[i] * (behind * behind * give[i] + other * other * give[j]));
    [p.k_d * soft, p.c_d * soft * soft]
}

/// w_i: part of J_out that turns with shaft i [1], shape (2).
fn share(p: &Params, g: [f64; 2], j_out: f64) -> [f64; 2] {
    [0, 1].map(|i| g[i] * g[i] * p.j_ct[i] / j_out)
}

/// 1/K_i: what the transfer shafts give at the output [rad/(N·m)], shape (2).
fn give(p: &Params) -> [f64; 2] {
    if p.rigid {
        return [0.0; 2];
    }
    [0, 1].map(|i| 1.0 / (p.k_t[i] * p.i_f[i] * p.i_f[i]))
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
    use nalgebra::{SMatrix, SVector, Vector4, Vector5};

    const P: Params = Params::TABLE_1;
    /// Round-off of a few products.
    const TOLERANCE: f64 = 1e-9;

    /// (4), (5), (8) with the clutch torques that are told: they move the output as the engaged model does.
    #[test]
    fn torque_of_an_engaged_clutch_is_what_turns_the_output() {
        let free = Speeds::new(&P, [1, 2]);
        let x = Vector4::new(180.5, 10.0, 9.7, 500.0);
        for (i, other) in [(0, 12.0), (1, -7.0)] {
            let engaged = free.behind(&P, Some(i), 1.0);
            let mut t = [other; 2];
            t[i] = 40.0; // T_k
            let moves = |model: &Speeds, t: [f64; 2]| {
                let v = Vector5::new(60.0, t[0], t[1], 250.0, -30.0);
                (model.a() * x + model.b() * v)[1]
            };
            let told = engaged.clutch_torques(&x, t, -30.0);
            assert!((moves(&engaged, t) - moves(&free, told)).abs() < TOLERANCE);
        }
    }

    /// V̇ without inputs: no term but the dampings of damper and drive shaft.
    #[test]
    fn energy_falls_by_the_loss_in_the_damper_of_an_engaged_clutch() {
        let model = Speeds::new(&P, [1, 2]).behind(&P, Some(0), 1.0);
        let (x, t_k) = (Vector4::new(180.5, 10.0, 9.7, 500.0), 40.0);
        let v = Vector5::new(0.0, t_k, 0.0, 0.0, 0.0);
        let x_dot = model.a() * x + model.b() * v;
        let inertias = Vector4::new(model.j_ed, model.j_out, model.j_v, 1.0 / model.k);
        let [e, o] = model.twist();
        let power =
            inertias.component_mul(&x).dot(&x_dot) + t_k * (e * x[0] + o * x[1]) / model.damper[0];
        let [_, c_d, _] = model.damper;
        let lost = model.c * 0.3 * 0.3 + c_d * 0.5 * 0.5;
        assert!((power + lost).abs() < 1e-7, "{power} {lost} W");
    }

    #[test]
    fn energy_falls_by_the_loss_in_the_drive_shaft() {
        let model = Speeds::new(&P, [1, 2]);
        let x = Vector4::new(180.0, 10.0, 9.7, 500.0);
        let x_dot = model.a() * x;
        let inertias = Vector4::new(model.j_ed, model.j_out, model.j_v, 1.0 / model.k);
        let power = inertias.component_mul(&x).dot(&x_dot);
        assert!((power + model.c * 0.3 * 0.3).abs() < TOLERANCE, "{power} W");
    }

    /// ω² of five inertias on springs k between q·x [1/s²], lowest first.
    fn swings(inertias: [f64; 5], springs: &[(f64, [f64; 5])]) -> [f64; 5] {
        let scale = SVector::from(inertias).map(|j| 1.0 / j.sqrt());
        let mut stiffness = SMatrix::<f64, 5, 5>::zeros();
        for (k, q) in springs {
            let q = SVector::from(*q).component_mul(&scale);
            stiffness += q * q.transpose() * *k;
        }
        let mut all: [f64; 5] = stiffness.symmetric_eigenvalues().into();
        all.sort_by(f64::total_cmp);
        all
    }

    /// (1)-(10) undamped with transfer shafts, clutch `i` engaged: a whole-body motion, two swings and two of shafts.
    fn whole(i: usize) -> [f64; 2] {
        let [t1, t2, f1, f2] = [P.i_t[0][0], P.i_t[1][0], P.i_f[0], P.i_f[1]];
        let (mut j_ct, mut damper) = (P.j_ct, [1.0, 0.0, 0.0, 0.0, 0.0]);
        (j_ct[i], damper[1 + i]) = (j_ct[i] + P.j_d, -1.0);
        let springs = [
            (P.k_d, damper),
            (P.k_t[0], [0.0, 1.0 / t1, 0.0, -f1, 0.0]),
            (P.k_t[1], [0.0, 0.0, 1.0 / t2, -f2, 0.0]),
            (P.k_o, [0.0, 0.0, 0.0, 1.0, -1.0]),
        ];
        let all = swings([P.j_e, j_ct[0], j_ct[1], P.j_o, P.j_v], &springs);
        [all[1], all[2]]
    }

    /// Both swings of the model with springs k_d and k_o; two inertias stand idle beside it.
    fn reduced(model: &Speeds, g: f64, k_d: f64, k_o: f64) -> [f64; 2] {
        let springs = [
            (k_d, [1.0, -g, 0.0, 0.0, 0.0]),
            (k_o, [0.0, 1.0, -1.0, 0.0, 0.0]),
        ];
        let all = swings([model.j_ed, model.j_out, model.j_v, 1.0, 1.0], &springs);
        [all[3], all[4]]
    }

    /// Stiff transfer shafts are FACTOR times further off.
    #[test]
    fn swings_are_those_of_the_whole_driveline() {
        const FACTOR: f64 = 5.0;
        for i in [0, 1] {
            let model = Speeds::new(&P, [1, 2]).behind(&P, Some(i), 1.0);
            let off = |k_d, k_o| {
                let (ours, truth) = (reduced(&model, model.g[i], k_d, k_o), whole(i));
                [0, 1].map(|n| (ours[n] / truth[n] - 1.0).abs())
            };
            let (ours, stiff) = (off(model.damper[0], model.k), off(P.k_d, P.k_o));
            let closer = (0..2).all(|n| FACTOR * ours[n] < stiff[n]);
            assert!(closer, "clutch {i}: {ours:?}, stiff {stiff:?}");
        }
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
