//! One rung of the ladder: motion, work and losses over a fixed span, linear and quadratic in z.
//!
//! With z = (x, v, v') the state moves to x + X z. Below the rows of X stand those of the work
//! integrals, so one pass over the columns gives motion and work:
//!
//! ```text
//! rows 0..10   x(t) − x(0)
//! rows 10..14  ∫ ω dτ     of ω_e, slip 1, slip 2, ω_w: what T_e, T_c1, T_c2, T_v work on; of a shaft
//!                         that is synchronised ω_c − g ω_o in place of the slip
//! rows 14..18  ∫ τ ω dτ   of the same
//! ```
//!
//! Doubling a span (`rung_builder.rs`) uses Ψ = (I + X over the states, v + t v' for torques): every row r obeys
//! r(2t) = r(t) + r(t) Ψ(t), but for the moments, which also gain t times the angles of the second
//! half. Losses are a quadratic form, F(2t) = F(t) + Ψᵀ F(t) Ψ.
//!
//! A finished rung keeps the rows that every step needs together, those of the slips, which only a
//! slipping clutch needs, apart, and the losses packed: see `rung_loss.rs`.

use nalgebra::SVector;

use crate::plant_matrices::{AUGMENTED, C, D, STATES, State, TORQUES, Torques, W};
use crate::rung_builder::Builder;
use crate::rung_loss::Loss;

/// First row of the angles.
pub(crate) const ANGLE: usize = STATES;
/// First row of the moments.
pub(crate) const MOMENT: usize = ANGLE + TORQUES;
pub(crate) const ROWS: usize = MOMENT + TORQUES;
/// First ramp among the columns.
pub(crate) const RAMP: usize = STATES + TORQUES;
/// Rows of every step: states, angles of ω_e and ω_w, moments of ω_w and ω_e.
const MAIN: usize = STATES + 4;
/// Those rows among all of them, behind the states.
const WORKED: [usize; 4] = [ANGLE, ANGLE + 3, MOMENT + 3, MOMENT];
/// The rows of slipping clutches: angles and moments of the slips.
const SLIPS: [usize; 4] = [ANGLE + 1, ANGLE + 2, MOMENT + 1, MOMENT + 2];

/// State, torques and their ramps, shape (18).
pub type Augmented = SVector<f64, AUGMENTED>;
pub(crate) type Columns<const N: usize> = [[f64; N]; AUGMENTED];

/// Where a rung leads from z: change of the state, angles and moments of ω_e and ω_w.
#[derive(Debug, Clone, Copy)]
pub struct Motion([f64; MAIN]);

impl Motion {
    /// x(t).
    pub fn end(&self, z: &Augmented) -> State {
        let z = entries(z);
        State::from(core::array::from_fn::<f64, STATES, _>(|i| z[i] + self.0[i]))
    }

    /// ω_w(t) [rad/s].
    pub fn wheel_speed(&self, z: &Augmented) -> f64 {
        z[W] + self.0[W]
    }

    /// ∫ ω_w dτ [rad] and ∫ τ ω_w dτ [rad·s], shape (2): what a constant torque and a ramp on the wheels work on.
    pub(crate) const fn wheel_angles(&self) -> [f64; 2] {
        let [.., angle, moment, _] = self.0;
        [angle, moment]
    }

    /// Slip 1, slip 2 and ω_w at the end [rad/s], shape (3): what T_c1, T_c2 and T_v work on.
    pub(crate) fn worked_speeds(&self, z: &Augmented) -> [f64; 3] {
        let x = self.end(z);
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }
}

/// Motion over one level of the ladder with one choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct Rung {
    /// Time the rung spans [s].
    pub t: f64,
    /// What each entry of z adds to the motion.
    columns: Columns<MAIN>,
    /// What reads angles and moments of both slips from z: rows.
    slips: [[f64; AUGMENTED]; 4],
    loss: Loss,
}

impl Rung {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        columns: [[0.0; MAIN]; AUGMENTED],
        slips: [[0.0; AUGMENTED]; 4],
        loss: Loss::ZERO,
    };

    /// Becomes what was built.
    pub(crate) fn take(&mut self, built: &Builder) {
        self.t = built.t;
        for (j, column) in built.columns.iter().enumerate() {
            let (states, worked) = self.columns[j].split_at_mut(STATES);
            states.copy_from_slice(&column[..STATES]);
            worked.copy_from_slice(&WORKED.map(|row| column[row]));
            for (to, row) in self.slips.iter_mut().zip(SLIPS) {
                to[j] = column[row];
            }
        }
        self.loss.pack(&built.loss);
    }

    /// Motion from z; torques and ramps that are zero cost nothing.
    #[inline(always)]
    pub fn motion(&self, z: &Augmented) -> Motion {
        let (mut rows, z) = ([0.0; MAIN], entries(z));
        for (column, z) in self.columns[..=STATES].iter().zip(z) {
            add(&mut rows, column, *z);
        }
        for (column, &z) in self.columns[STATES + 1..].iter().zip(&z[STATES + 1..]) {
            if z != 0.0 {
                add(&mut rows, column, z);
            }
        }
        Motion(rows)
    }

    /// Adds what a ramp of the load [N·m/s] does to a motion without one.
    pub fn add_load_ramp(&self, motion: &mut Motion, ramp: f64) {
        add(&mut motion.0, &self.columns[AUGMENTED - 1], ramp);
    }

    /// ∂ω_w(t) / ∂T_v' [s²/(kg·m²)]: effect of the ramp of the load on the wheel speed.
    pub fn wheel_speed_by_load_ramp(&self) -> f64 {
        self.columns[AUGMENTED - 1][W]
    }

    /// Adds what a ramp [N·m/s] of torque `q` of T_e, T_c1, T_c2, T_v does to a motion without it.
    pub(crate) fn add_ramp(&self, motion: &mut Motion, q: usize, ramp: f64) {
        add(&mut motion.0, &self.columns[RAMP + q], ramp);
    }

    /// Effect of the ramp of torque `q` on [`Motion::worked_speeds`] [s²/(kg·m²)], shape (3).
    pub(crate) fn worked_speeds_by_ramp(&self, q: usize) -> [f64; 3] {
        let x = &self.columns[RAMP + q];
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }

    /// Work of T_e, T_c1, T_c2, T_v on ω_e, slip 1, slip 2, ω_w [J], shape (4).
    ///
    /// `motion`: the motion from z.
    #[inline(always)]
    pub fn work(&self, z: &Augmented, motion: &Motion) -> Torques {
        let (z, [.., angle_e, angle_w, moment_w, moment_e]) = (entries(z), motion.0);
        let friction = |i: usize| {
            let (torque, ramp) = (z[STATES + 1 + i], z[RAMP + 1 + i]);
            if torque == 0.0 && ramp == 0.0 {
                return 0.0;
            }
            torque * dot(&self.slips[i], z) + ramp * dot(&self.slips[2 + i], z)
        };
        Torques::from([
            z[STATES] * angle_e + z[RAMP] * moment_e,
            friction(0),
            friction(1),
            z[STATES + 3] * angle_w + z[RAMP + 3] * moment_w,
        ])
    }

    /// Energy lost in the dampers from z [J].
    #[inline(always)]
    pub fn viscous_loss(&self, z: &Augmented) -> f64 {
        self.loss.of(z)
    }
}

/// The entries of z, whose number the compiler knows.
const fn entries(z: &Augmented) -> &[f64; AUGMENTED] {
    &z.data.0[0]
}

/// `sum` + `scale` · `column`, which may be shorter; inlined, so that a chain of these keeps the sum in registers.
#[inline(always)]
pub(crate) fn add<const N: usize, const M: usize>(
    sum: &mut [f64; N],
    column: &[f64; M],
    scale: f64,
) {
    for (sum, entry) in sum.iter_mut().zip(column) {
        *sum += entry * scale;
    }
}

/// Σ a b over the entries of `a`, in two lanes.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (pairs, rest) = a.as_chunks::<2>();
    let (others, _) = b.as_chunks::<2>();
    let mut lanes = [0.0; 2];
    for ([a0, a1], [b0, b1]) in pairs.iter().zip(others) {
        lanes[0] += a0 * b0;
        lanes[1] += a1 * b1;
    }
    let last = rest.iter().zip(&b[2 * pairs.len()..]).map(|(a, b)| a * b);
    lanes[0] + lanes[1] + last.sum::<f64>()
}
