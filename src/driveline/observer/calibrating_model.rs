//! The driveline as `calibrating` sees it: the motion, and what every state does to it.
//!
//! ```text
//! x = (ω_e, ω_o, ω_w, T_s, T_c1, T_c2, T_v, β, δ, w, κ, γ, λ, ν, r)     torques in units of the reported T_e
//! J_ed (1+δ) ω_e' = T_e + β − T_c1 − T_c2                    J_out (1+λ) ω_o' = g1 T_c1 + g2 T_c2 − T_o + (1+λ) T_y
//! J_v (1+ν) ω_w' = T_o − T_v − T_r(ω_w) − T_b                T_o = T_s + c (1+γ) (ω_o − ω_w)
//! T_s' = k (1+κ) (ω_o − ω_w)                                 T_v' = r,  r' = −r/τ_r (`walk.rs`)
//! ```
//!
//! T_r is drag and rolling resistance of (11) on the level; T_v is what remains: the grade, and all errors. Dry rolling
//! resistance is as the mean over what is believed of ω_w ([`unsure`](crate::observer::standstill::unsure)).
//! T_y, of synchronisers, is known by the inertia of a shaft, so λ scales it. Behind an engaged clutch T_ci is T_k, what
//! the damper carries, with J_e and J_out + g_i² J_d ([`Speeds::behind`]).

use crate::Params;
use crate::observer::filter::{Flow, Motion as Moving, Rows, with_damper};
use crate::observer::speeds::Speeds;
use crate::observer::tracker::{SHARED, T_C, T_S, T_V, W_E, W_O, W_W};
use crate::observer::{Sample, brake};
use nalgebra::{SVector, Vector4, Vector5, Vector6};

/// Number of parameters among the states: β, δ, w, κ, γ, λ, ν.
pub const LEARNT: usize = 7;
/// Number of states.
pub const N: usize = SHARED + LEARNT + 1;
pub type Vector = SVector<f64, N>;

/// Index of β [N·m]: offset of the engine torque.
pub const BETA: usize = SHARED;
/// Index of δ [1]: error of J_ed.
pub const DELTA: usize = 8;
/// Index of w [rad/s]: bias of the wheel speed.
pub const BIAS: usize = 9;
/// Index of κ [1]: error of k_o.
pub const KAPPA: usize = 10;
/// Index of γ [1]: error of c_o.
pub const GAMMA: usize = 11;
/// Index of λ [1]: error of J_out.
pub const LAMBDA: usize = 12;
/// Index of ν [1]: error of J_v.
pub const NU: usize = 13;
/// Index of r [N·m/s]: rate of T_v.
pub const RATE: usize = 14;

/// Largest |β|, |δ|, |w|, |κ|, |γ|, |λ|, |ν| that a vehicle can have.
const LARGEST: [f64; LEARNT] = [30.0, 0.7, 0.5, 0.5, 0.7, 0.7, 0.7];
/// States that move others: all but w and r.
pub const ACTING: [usize; 13] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13];

/// Keeps the parameters within what a vehicle can have; tells whether that was needed.
pub fn bound(x: &mut Vector) -> bool {
    let mut bounded = false;
    for (k, largest) in LARGEST.into_iter().enumerate() {
        let x = &mut x[SHARED + k];
        let free = *x;
        *x = free.clamp(-largest, largest);
        bounded |= *x != free;
    }
    bounded
}

/// A sample seen with the parameters of a state.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    pub p: &'a Params,
    pub sample: &'a Sample,
    pub x: &'a Vector,
    /// The driveline with what was learnt.
    pub model: Speeds,
    /// J_out as believed [kg·m²].
    pub j_out: f64,
}

/// The states that move after a step, the rows of Φ, and the mean slope of ω_e, ω_o over it [rad/s²].
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    pub moved: Vector6<f64>,
    pub rows: Rows<N>,
    pub slope: [f64; 2],
}

impl<'a> View<'a> {
    /// `scale`: of the damper, which is believed as the engine torque is [1].
    pub fn new(
        p: &'a Params,
        sample: &'a Sample,
        x: &'a Vector,
        engaged: Option<usize>,
        scale: f64,
    ) -> Self {
        let nominal = Speeds::new(p, sample.gear);
        let free = Speeds {
            j_ed: nominal.j_ed * (1.0 + x[DELTA]),
            j_out: nominal.j_out * (1.0 + x[LAMBDA]),
            j_v: nominal.j_v * (1.0 + x[NU]),
            k: nominal.k * (1.0 + x[KAPPA]),
            c: nominal.c * (1.0 + x[GAMMA]),
            drag: p.road.load_torque_slope(x[W_W], 0.0),
            ..nominal
        };
        Self {
            p,
            sample,
            x,
            model: free.behind(p, engaged, scale),
            j_out: nominal.j_out,
        }
    }

    /// T_r: drag and rolling resistance on the level [N·m].
    pub fn resistance(&self) -> f64 {
        self.p.road.load_torque(self.x[W_W], 0.0)
    }

    /// T_a = T_o − T_v − T_r − T_b: what accelerates the vehicle [N·m].
    pub fn pull(&self) -> f64 {
        let (x, c) = (self.x, self.model.c);
        let t_o = x[T_S] + c * (x[W_O] - x[W_W]);
        t_o - x[T_V] - self.resistance() - brake(self.p, self.sample)
    }

    /// Engine torque with its offset [N·m].
    pub fn engine_torque(&self) -> f64 {
        self.sample.t_e + self.x[BETA]
    }

    /// T_y as the inertia that was learnt makes it [N·m].
    fn synchroniser_torque(&self) -> f64 {
        self.sample.t_y * (1.0 + self.x[LAMBDA])
    }

    /// The slope of the states that move, shape (4).
    fn slope(&self, t: [f64; 2]) -> Vector4<f64> {
        let x = self.x;
        let own = self.resistance() - self.model.drag * x[W_W];
        let load = x[T_V] + own + brake(self.p, self.sample);
        let (t_e, t_y) = (self.engine_torque(), self.synchroniser_torque());
        let torques = Vector5::new(t_e, t[0], t[1], load, t_y);
        self.model.a() * x.fixed_rows::<4>(0) + self.model.b() * torques
    }

    /// How all other states change the slope, shape (4, 15), of which the last 11 columns count.
    ///
    /// `slope` and `twist` ω_o − ω_w: their means over the step, which makes Φ exact to h³.
    fn effects(&self, slope: &Vector4<f64>, twist: f64) -> Moving<N> {
        let (x, model, b) = (self.x, &self.model, self.model.b());
        let mut by = Moving::<N>::zeros();
        by.fixed_columns_mut::<3>(T_C)
            .copy_from(&b.fixed_columns::<3>(1));
        by.set_column(BETA, &b.column(0));
        by[(W_E, DELTA)] = -slope[W_E] / (1.0 + x[DELTA]);
        by[(W_O, LAMBDA)] = -slope[W_O] * self.j_out / model.j_out;
        by[(W_W, NU)] = -slope[W_W] / (1.0 + x[NU]);
        by[(T_S, KAPPA)] = slope[T_S] / (1.0 + x[KAPPA]);
        let damping = model.c * twist / (1.0 + x[GAMMA]);
        by[(W_O, GAMMA)] = -damping / model.j_out;
        by[(W_W, GAMMA)] = damping / model.j_v;
        by
    }

    /// The motion over a step `h` [s] with the parameters held.
    ///
    /// `seen`: slopes of ω_e, ω_o that δ and λ are seen by, given the mean slopes over the step less that of T_y,
    /// which shows nothing of λ.
    pub fn motion(&self, h: f64, seen: impl FnOnce([f64; 2]) -> [f64; 2]) -> Motion {
        let (x, flow) = (self.x, Flow::new(&self.model, h));
        let ([e, o], mut t) = (self.model.twist(), [x[T_C], x[T_C + 1]]);
        let wound = |x: &Vector4<f64>| 0.5 * h * (e * x[W_E] + o * x[W_O]);
        let now = x.fixed_rows::<4>(0).into_owned();
        if let Some(i) = self.model.engaged {
            t[i] += wound(&now);
        }
        let change = flow.gamma * self.slope(t);
        let moved = now + change;
        if let Some(i) = self.model.engaged {
            t[i] += wound(&moved);
        }
        let twist = 0.5 * (x[W_O] - x[W_W] + moved[W_O] - moved[W_W]);
        let mut mean = change / h;
        let slope = [mean[W_E], mean[W_O] - self.sample.t_y / self.j_out];
        [mean[W_E], mean[W_O]] = seen(slope);
        Motion {
            moved: Vector6::new(moved[0], moved[1], moved[2], moved[3], t[0], t[1]),
            rows: with_damper(&flow.rows(&self.effects(&mean, twist)), &self.model, h),
            slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ACTING, N, Vector, View};
    use crate::Params;
    use crate::observer::Sample;
    use nalgebra::Vector6;

    /// Step of the central differences, in units of the state.
    const STEP: f64 = 1e-4;

    fn sample() -> Sample {
        Sample {
            t_e: 60.0,
            omega_e: 180.0,
            omega_c: [170.0, 110.0],
            omega_w: 9.3,
            gear: [1, 2],
            t_brake: 40.0,
            t_y: -30.0,
            ..Sample::default()
        }
    }

    fn state() -> Vector {
        Vector::from([
            181.0, 9.5, 9.3, 700.0, 42.0, -11.0, 260.0, 1.5, -0.1, 0.01, 0.07, -0.15, 0.1, -0.1,
            30.0,
        ])
    }

    /// Central difference of `f` by state `j` about `about`.
    fn slope<T>(f: impl Fn(&Vector) -> T, about: &Vector, j: usize) -> T
    where
        T: core::ops::Sub<Output = T> + core::ops::Div<f64, Output = T>,
    {
        let [up, down] = [STEP, -STEP].map(|step| {
            let mut x = *about;
            x[j] += step;
            f(&x)
        });
        (up - down) / (2.0 * STEP)
    }

    /// In every state, at 33 km/h and where rolling resistance turns about; the rows leave out h³.
    #[test]
    fn rows_of_phi_are_the_derivative_of_the_motion() {
        let (p, sample) = (Params::TABLE_1, sample());
        let units = Vector6::new(1.0, 1.0, 1.0, 500.0, 50.0, 50.0);
        let cases = [
            (None, 9.3, 1e-3, 1e-4),
            (None, 9.3, 1e-2, 1e-2),
            (Some(0), 9.3, 1e-3, 2e-4),
            (Some(1), 9.3, 1e-3, 2e-4),
            (None, 0.02, 1e-3, 1e-4),
            (None, -0.1, 1e-3, 1e-4),
        ];
        for (engaged, omega_w, h, tolerance) in cases {
            let mut x = state();
            [x[1], x[2]] = [omega_w + 0.2, omega_w];
            let motion =
                |x: &Vector| View::new(&p, &sample, x, engaged, 1.0).motion(h, |slope| slope);
            let rows = motion(&x).rows;
            for j in 0..N {
                let truth = slope(|x| motion(x).moved, &x, j).component_div(&units);
                let ours = rows.column(j).component_div(&units);
                assert!(ACTING.contains(&j) || rows.column(j).amax() == 0.0, "{j}");
                let error = (truth - ours).amax() / truth.amax().max(h);
                assert!(
                    error < tolerance,
                    "{engaged:?}, {omega_w} rad/s, h = {h} s, state {j}: {error} {truth} {ours}"
                );
            }
        }
    }

    /// Of every clutch: an offset of T_e stands against T_k, T_s and T_v, and no speed tells it from them. It takes the
    /// clutches open (idle), or a load that is known, to see β.
    #[test]
    fn one_clutch_engaged_hides_the_offset_of_the_engine_torque() {
        const OFFSET: f64 = 2.0;
        let (p, sample) = (Params::TABLE_1, sample());
        for i in [0, 1] {
            let mut x = state();
            x[5 - i] = 0.0;
            let motion = |x: &Vector| {
                View::new(&p, &sample, x, Some(i), 1.0)
                    .motion(1e-3, |slope| slope)
                    .moved
            };
            let before = motion(&x);
            let g = p.g(sample.gear)[i];
            for (j, change) in [(7, 1.0), (4 + i, 1.0), (3, g), (6, g)] {
                x[j] += OFFSET * change;
            }
            let change = motion(&x) - before;
            assert!(change.fixed_rows::<3>(0).amax() < 1e-10, "{change}");
            assert!((change[3] - OFFSET * g).abs() < 1e-9, "{change}");
            assert!((change[4 + i] - OFFSET).abs() < 1e-9, "{change}");
        }
    }

    /// Homogeneity: this factor is what no filter can find from speeds.
    #[test]
    fn one_common_factor_on_all_torques_and_parameters_changes_no_speed() {
        const FACTOR: f64 = 1.07;
        let (p, sample) = (Params::TABLE_1, sample());
        let mut scaled = Params {
            j_e: FACTOR * p.j_e,
            j_d: FACTOR * p.j_d,
            j_ct: p.j_ct.map(|j| FACTOR * j),
            j_o: FACTOR * p.j_o,
            j_v: FACTOR * p.j_v,
            k_o: FACTOR * p.k_o,
            c_o: FACTOR * p.c_o,
            k_t: p.k_t.map(|k| FACTOR * k),
            ..p
        };
        scaled.road.m_v *= FACTOR;
        scaled.road.rho_air *= FACTOR;
        let mut stronger = sample;
        stronger.t_e *= FACTOR;
        stronger.t_brake *= FACTOR;
        stronger.t_y *= FACTOR;
        let mut x = state();
        for j in [3, 4, 5, 6, 7] {
            x[j] *= FACTOR;
        }
        let motion = |p, sample, x| {
            View::new(p, sample, x, None, 1.0)
                .motion(1e-3, |slope| slope)
                .moved
        };
        let (one, other) = (
            motion(&p, &sample, &state()),
            motion(&scaled, &stronger, &x),
        );
        let speeds = (one - other).fixed_rows::<3>(0).amax();
        assert!(speeds < 1e-10, "{one} {other}");
        assert!((other[3] / one[3] - FACTOR).abs() < 1e-10);
    }
}
