//! Control-oriented model (12)-(16): three states that keep the damping of the drive shaft.
//!
//! ```text
//! x1 = ω_e − ω_c2,  x2 = ω_c2/g2 − ω_w,  x3 = T_o
//! ẋ = A x + B u + E δ,  u = (T_e, T_c1, T_c2),  δ = T_v
//! ```
//!
//! x3 obeys ẋ3 = k_o,eq x2 + c_o,eq ẋ2 (15), which needs no twist angle. The conventional model that
//! the paper compares with is the same with c_o,eq = 0.
//!
//! ```
//! use dct_driveline::{Params, reduced::Reduced};
//!
//! let p = Params::TABLE_1;
//! let model = Reduced::new(&p, p.g([1, 2]), p.c_o);
//! assert!((model.a()[(2, 1)] - 4887.0).abs() < 1e-9);
//! ```

use crate::Params;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// States, a constant slope of each, and what that slope rises by over the step.
const AUGMENTED: usize = 9;

/// The control-oriented model for one pair of gears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reduced {
    /// J_ed of (13) [kg·m²].
    pub j_ed: f64,
    /// J_v [kg·m²].
    pub j_v: f64,
    /// J_ct2,eq of (13) [kg·m²].
    pub j_ct2_eq: f64,
    /// g1, g2 [1]; 0 cuts a shaft in neutral from the output.
    pub g: [f64; 2],
    /// Ratio by which x1 and x2 are defined: g2, or its stand-in while the even shaft is in neutral [1].
    pub g_ref: f64,
    /// k_o,eq [N·m/rad].
    pub k_o_eq: f64,
    /// c_o,eq [N·m·s/rad]; 0 for the conventional model.
    pub c_o_eq: f64,
}

impl Reduced {
    /// The model for total ratios `g`, shape (2), g2 ≠ 0, with damping `c_o_eq` [N·m·s/rad].
    pub fn new(p: &Params, g: [f64; 2], c_o_eq: f64) -> Self {
        Self::referred_to(p, g, g[1], c_o_eq)
    }

    /// The model for total ratios `g`, shape (2), whose x1 and x2 are defined by `g_ref` ≠ 0 [1].
    ///
    /// A shaft in neutral (0) takes its inertia and its clutch away from the output.
    pub fn referred_to(p: &Params, g: [f64; 2], g_ref: f64, c_o_eq: f64) -> Self {
        Self {
            j_ed: p.j_ed(),
            j_v: p.j_v,
            j_ct2_eq: p.j_out(g) / g_ref,
            g,
            g_ref,
            k_o_eq: p.k_o,
            c_o_eq,
        }
    }

    /// b = 1/(g2 J_ct2,eq) + 1/J_v of (14) [1/(kg·m²)].
    pub fn b_coupling(&self) -> f64 {
        1.0 / (self.g_ref * self.j_ct2_eq) + 1.0 / self.j_v
    }

    /// a_i = 1/J_ed + g_i/J_ct2,eq of (13), shape (2): effect of T_ci on −ẋ1 [1/(kg·m²)].
    pub fn a_slip(&self) -> [f64; 2] {
        self.g.map(|g| 1.0 / self.j_ed + g / self.j_ct2_eq)
    }

    /// h_i = g_i/(g2 J_ct2,eq) of (14), shape (2): effect of T_ci on ẋ2 [1/(kg·m²)].
    pub fn h_twist(&self) -> [f64; 2] {
        self.g.map(|g| g / (self.g_ref * self.j_ct2_eq))
    }

    /// A of (16), shape (3, 3).
    pub fn a(&self) -> Matrix3<f64> {
        let b = self.b_coupling();
        Matrix3::new(
            0.0,
            0.0,
            1.0 / self.j_ct2_eq, //
            0.0,
            0.0,
            -b, //
            0.0,
            self.k_o_eq,
            -self.c_o_eq * b,
        )
    }

    /// B of (16), shape (3, 3): columns T_e, T_c1, T_c2.
    pub fn b(&self) -> Matrix3<f64> {
        let ([a1, a2], [h1, h2]) = (self.a_slip(), self.h_twist());
        let c = self.c_o_eq;
        Matrix3::new(1.0 / self.j_ed, -a1, -a2, 0.0, h1, h2, 0.0, c * h1, c * h2)
    }

    /// E of (16), shape (3).
    ///
    /// Deviation: the third row is c_o,eq/J_v, which follows from (15); the paper prints 1/J_v
    /// (erratum E2).
    pub fn e(&self) -> Vector3<f64> {
        Vector3::new(0.0, 1.0 / self.j_v, self.c_o_eq / self.j_v)
    }

    /// Effect of T_y, a torque of synchronisers at the output, shape (3): that of T_ci without the engine,
    /// for a ratio of 1.
    pub fn y(&self) -> Vector3<f64> {
        let h_y = 1.0 / (self.g_ref * self.j_ct2_eq);
        Vector3::new(-1.0 / self.j_ct2_eq, h_y, self.c_o_eq * h_y)
    }

    /// The model over a step `h` [s] with held inputs, T_ci that rise evenly, and held innovation, exactly.
    ///
    /// `l`: observer gain L of (19), shape (3, 2).
    pub fn discrete(&self, l: &SMatrix<f64, 3, 2>, h: f64) -> Discrete {
        let mut m = SMatrix::<f64, AUGMENTED, AUGMENTED>::zeros();
        m.fixed_view_mut::<3, 3>(0, 0).copy_from(&(self.a() * h));
        m.fixed_view_mut::<3, 3>(0, 3).fill_diagonal(h);
        m.fixed_view_mut::<3, 3>(3, 6).fill_diagonal(1.0);
        let psi = exponential(&m);
        let gamma = psi.fixed_view::<3, 3>(0, 3);
        let b = self.b();
        Discrete {
            phi: psi.fixed_view::<3, 3>(0, 0).into_owned(),
            gamma_u: gamma * b,
            gamma_rise: psi.fixed_view::<3, 3>(0, 6) * b.fixed_columns::<2>(1),
            gamma_delta: gamma * self.e(),
            gamma_l: gamma * l,
            gamma_y: gamma * self.y(),
        }
    }
}

/// x⁺ = Φ x + Γ_u u + Γ_r ΔT_c + Γ_δ δ + Γ_L e + Γ_y T_y: the model over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    /// Φ = exp(A h), shape (3, 3).
    pub phi: Matrix3<f64>,
    /// Γ_u of T_e, T_c1, T_c2 at its begin, shape (3, 3).
    pub gamma_u: Matrix3<f64>,
    /// Γ_δ of T_v, shape (3).
    pub gamma_delta: Vector3<f64>,
    /// Γ_L of the innovation, shape (3, 2).
    pub gamma_l: SMatrix<f64, 3, 2>,
    /// Γ_y of T_y, shape (3).
    pub gamma_y: Vector3<f64>,
    /// Γ_r of what T_c1, T_c2 rise by over the step, shape (3, 2).
    pub gamma_rise: SMatrix<f64, 3, 2>,
}

impl Discrete {
    /// No model.
    pub(crate) const NOTHING: Self = Self {
        phi: zeros(),
        gamma_u: zeros(),
        gamma_delta: zeros(),
        gamma_l: zeros(),
        gamma_y: zeros(),
        gamma_rise: zeros(),
    };
}

/// A matrix of zeros, as a constant.
pub(crate) const fn zeros<const R: usize, const C: usize>() -> SMatrix<f64, R, C> {
    SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; R]; C]))
}

/// exp(M) by its series on M/2^n, squared n times; not finite where M is not.
pub(crate) fn exponential<const N: usize>(m: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    const REACH: f64 = 0.1; // REACH^10/10! < 1e-16
    let (mut scaled, mut squarings) = (*m, 0);
    // A part of infinity is infinite.
    while scaled.amax() > REACH && scaled.amax() < f64::INFINITY {
        scaled *= 0.5;
        squarings += 1;
    }
    let mut term = SMatrix::<f64, N, N>::identity();
    let mut sum = term;
    for k in 1..=12 {
        term = term * scaled / f64::from(k);
        sum += term;
    }
    (0..squarings).fold(sum, |root, _| root * root)
}

#[cfg(test)]
mod tests {
    use super::{Reduced, exponential};
    use crate::Params;
    use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};

    /// Numbers of Table 1, computed by hand in double precision.
    const TOLERANCE: f64 = 1e-12;
    const P: Params = Params::TABLE_1;

    fn table_1() -> Reduced {
        Reduced::new(&P, P.g([1, 2]), P.c_o)
    }

    #[test]
    fn matrices_are_those_of_table_1() {
        let a = Matrix3::new(
            0.0,
            0.0,
            0.252_017_893_270_422_2, //
            0.0,
            0.0,
            -0.029_305_973_740_480_298, //
            0.0,
            4887.0,
            -16.616_487_110_852_33,
        );
        let b = Matrix3::new(
            1.313_197_636_244_254_8,
            -5.849_519_715_111_855,
            -4.216_443_766_719_518, //
            0.0,
            0.393_777_958_235_034_64,
            0.252_017_893_270_422_2, //
            0.0,
            223.272_102_319_264_66,
            142.894_145_484_329_39,
        );
        let e = Vector3::new(0.0, 0.007_429_420_505_200_595, 4.212_481_426_448_737);
        let model = table_1();
        for (ours, theirs) in [(model.a(), a), (model.b(), b)] {
            let error =
                (ours - theirs).component_div(&theirs.map(|x| if x == 0.0 { 1.0 } else { x }));
            assert!(error.amax() < TOLERANCE, "{error}");
        }
        assert!((model.e() - e).amax() < TOLERANCE * e[2]);
    }

    /// Runge-Kutta of order 4 knows nothing of exponentials.
    #[test]
    fn discretisation_follows_the_differential_equation() {
        const SUBSTEPS: u32 = 2000;
        // RK4 leaves (‖A‖ h/SUBSTEPS)⁴ of its terms: below 1e-11 at 20 ms.
        const AGREEMENT: f64 = 1e-9;
        let l = SMatrix::<f64, 3, 2>::new(80.0, 142.9, 0.0, 4.0, 0.25, 4887.0);
        let (u, e) = (Vector3::new(60.0, 35.0, -20.0), Vector2::new(0.3, 0.01));
        for (g, h) in [
            ([18.0, 11.52], 1e-4),
            ([18.0, 6.2], 1e-3),
            ([4.1, 11.52], 2e-2),
        ] {
            let model = Reduced::new(&P, g, P.c_o);
            let held = model.b() * u + model.e() * 250.0 + l * e - model.y() * 40.0;
            let rise = Vector2::new(-8.0, 15.0);
            let rising = model.b() * Vector3::new(0.0, rise[0], rise[1]);
            let slope = |x: Vector3<f64>, part: f64| model.a() * x + held + rising * part;
            let d = h / f64::from(SUBSTEPS);
            let start = Vector3::new(30.0, 0.1, 400.0);
            let reference = (0..SUBSTEPS).fold(start, |x, n| {
                let part = |of: f64| (f64::from(n) + of) / f64::from(SUBSTEPS);
                let k1 = slope(x, part(0.0));
                let k2 = slope(x + k1 * (d / 2.0), part(0.5));
                let k3 = slope(x + k2 * (d / 2.0), part(0.5));
                let k4 = slope(x + k3 * d, part(1.0));
                x + (k1 + (k2 + k3) * 2.0 + k4) * (d / 6.0)
            });
            let step = model.discrete(&l, h);
            let ours =
                step.phi * start + step.gamma_u * u + step.gamma_delta * 250.0 + step.gamma_l * e
                    - step.gamma_y * 40.0
                    + step.gamma_rise * rise;
            assert!(
                (ours - reference).amax() < AGREEMENT * reference.amax(),
                "{g:?} {h}"
            );
        }
    }

    /// What a driveline without inertia would ask for: it must end, and nobody may take it for a motion.
    #[test]
    fn exponential_of_an_infinite_matrix_ends_and_is_not_finite() {
        for entry in [f64::INFINITY, f64::NEG_INFINITY] {
            let m = Matrix3::new(0.0, entry, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 2.0);
            let found = exponential(&m);
            assert!(found.iter().any(|entry| !entry.is_finite()), "{found}");
        }
    }

    #[test]
    fn shaft_in_neutral_is_cut_from_the_output() {
        let even = Reduced::referred_to(&P, [18.0, 0.0], 11.52, P.c_o);
        assert_eq!((even.a_slip()[1], even.h_twist()[1]), (1.0 / P.j_ed(), 0.0));
        let j_out = P.j_o + 18.0 * 18.0 * P.j_ct[0];
        assert!((even.b_coupling() - (1.0 / j_out + 1.0 / P.j_v)).abs() < TOLERANCE);
        assert!((even.h_twist()[0] - 18.0 / j_out).abs() < TOLERANCE);
    }

    #[test]
    fn two_half_steps_are_one_step() {
        let l = SMatrix::<f64, 3, 2>::new(80.0, 142.9, 0.0, 4.0, 0.25, 4887.0);
        let [whole, half] = [1e-2, 5e-3].map(|h| table_1().discrete(&l, h));
        let x = Vector3::new(30.0, 0.1, 400.0);
        let (u, e) = (Vector3::new(60.0, 40.0, 10.0), Vector2::new(0.3, 0.01));
        let step = |d: &super::Discrete, x| {
            d.phi * x + d.gamma_u * u + d.gamma_delta * 90.0 + d.gamma_l * e
        };
        let difference = step(&whole, x) - step(&half, step(&half, x));
        assert!(difference.amax() < 1e-9 * x.amax(), "{difference}");
    }

    #[test]
    fn without_damping_the_shaft_torque_follows_the_twist_rate_alone() {
        let model = Reduced {
            c_o_eq: 0.0,
            ..table_1()
        };
        let x_dot = model.a() * Vector3::new(0.0, 0.2, 500.0) + model.b() * Vector3::repeat(50.0);
        assert_eq!(x_dot[2], 4887.0 * 0.2);
    }
}
