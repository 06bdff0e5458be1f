//! Rows that read one quantity of the driveline from its state and torques: what guards watch.

use nalgebra::RowSVector;

use crate::matrices::state::{STATES, State, TORQUES, Torques};

/// A quantity that is linear in state and torques.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    x: [f64; STATES],
    v: [f64; TORQUES],
}

impl Row {
    const ZERO: Self = Self {
        x: [0.0; STATES],
        v: [0.0; TORQUES],
    };

    pub(crate) fn new(x: &RowSVector<f64, STATES>, v: &RowSVector<f64, TORQUES>) -> Self {
        Self {
            x: core::array::from_fn(|j| x[j]),
            v: core::array::from_fn(|j| v[j]),
        }
    }

    /// The quantity.
    #[inline(never)] // a function of its own has registers for it
    pub fn of(&self, x: &State, v: &Torques) -> f64 {
        dot(&self.x, &x.data.0[0]) + self.of_torques(v)
    }

    /// What the torques alone make of it.
    pub fn of_torques(&self, v: &Torques) -> f64 {
        dot(&self.v, &v.data.0[0])
    }

    /// What a state makes of it, with a unit of one column of (x, v) added; columns of ramps count nothing.
    pub(crate) fn of_column(&self, x: &State, column: usize) -> f64 {
        let unit = self.x.iter().chain(&self.v).nth(column);
        dot(&self.x, &x.data.0[0]) + unit.copied().unwrap_or(0.0)
    }

    /// What `share` of two quantities amounts to.
    pub(crate) fn sum(rows: &[Self; 2], share: [f64; 2]) -> Self {
        let [one, two] = rows;
        let sum = |one: f64, two: f64| share[0] * one + share[1] * two;
        Self {
            x: core::array::from_fn(|j| sum(one.x[j], two.x[j])),
            v: core::array::from_fn(|q| sum(one.v[q], two.v[q])),
        }
    }

    /// What one state makes of it, by its index, and one torque.
    pub(crate) const fn by_state(&self, j: usize) -> f64 {
        self.x[j]
    }

    /// What torque `q` of T_e, T_c1, T_c2, T_v alone makes of it.
    pub(crate) fn of_torque(&self, q: usize, torque: f64) -> f64 {
        self.v[q] * torque
    }
}

/// Σ a b of an even number of entries, in two lanes.
#[inline(always)]
fn dot<const N: usize>(a: &[f64; N], b: &[f64]) -> f64 {
    let mut lanes = [-0.0; 2]; // what a first sum leaves as it is
    for (a, b) in a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0) {
        lanes[0] += a[0] * b[0];
        lanes[1] += a[1] * b[1];
    }
    lanes[0] + lanes[1]
}

/// The quantities that end a smooth stretch, and the wheels' acceleration.
#[derive(Debug, Clone, Copy)]
pub struct Rows {
    /// T_c1, T_c2 [N·m], shape (2).
    pub torque: [Row; 2],
    /// Rates of T_c1, T_c2 at constant torques [N·m/s], shape (2).
    pub torque_rate: [Row; 2],
    /// d/dt (ω_d − ω_ci) [rad/s²], shape (2).
    pub slip_rate: [Row; 2],
    /// ω̇_w [rad/s²].
    pub wheel_rate: Row,
    /// g_i (T_ci − J_cti ω̇_ci) = i_fi T_ti: what the gear of a shaft would give to the output without loss [N·m],
    /// shape (2).
    pub mesh: [Row; 2],
}

impl Rows {
    /// Rows that read nothing.
    pub(crate) const ZERO: Self = Self {
        torque: [Row::ZERO; 2],
        torque_rate: [Row::ZERO; 2],
        slip_rate: [Row::ZERO; 2],
        wheel_rate: Row::ZERO,
        mesh: [Row::ZERO; 2],
    };
}
