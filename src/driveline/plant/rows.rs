//! Rows that read one quantity of the driveline from its state and torques: what guards watch.

use nalgebra::{RowSVector, SMatrix};

use crate::plant::matrices::{
    C, D, E, O, STATES, State, System, Systems, TORQUES, TWIST_D, TWIST_O, TWIST_T, Torques, W,
};

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

    fn new(x: &RowSVector<f64, STATES>, v: &RowSVector<f64, TORQUES>) -> Self {
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

    /// Rows of a system whose own are still to be made.
    ///
    /// `g`: ratios of the gears that are in, else 0. `j_ct`: inertias of the input shafts with them [kg·m²].
    pub(crate) fn new(system: &System, g: [f64; 2], j_ct: [f64; 2]) -> Self {
        let System {
            a, b, t_c_x, t_c_v, ..
        } = system;
        let (rate_x, rate_v) = (t_c_x * a, t_c_x * b);
        let row = |x: &SMatrix<f64, 2, STATES>, v: &SMatrix<f64, 2, TORQUES>, i| {
            Row::new(&x.row(i).into_owned(), &v.row(i).into_owned())
        };
        let slip = |i: usize| Row::new(&(a.row(D) - a.row(C + i)), &(b.row(D) - b.row(C + i)));
        let mesh = |i: usize| {
            let (g, j) = (g[i], j_ct[i]);
            Row::new(
                &(g * (t_c_x.row(i) - j * a.row(C + i))),
                &(g * (t_c_v.row(i) - j * b.row(C + i))),
            )
        };
        Self {
            mesh: [0, 1].map(mesh),
            torque: [0, 1].map(|i| row(t_c_x, t_c_v, i)),
            torque_rate: [0, 1].map(|i| row(&rate_x, &rate_v, i)),
            slip_rate: [0, 1].map(slip),
            wheel_rate: Row::new(&a.row(W).into_owned(), &b.row(W).into_owned()),
        }
    }
}

impl Systems {
    /// T_d, T_t1, T_t2, T_o of (3), (4), (5), (10) [N·m], shape (4); 0 in rigid transfer shafts.
    ///
    /// Also the rates of these torques, from the rate of the state.
    pub fn spring_torques(&self, x: &State) -> [f64; 4] {
        [0, 1, 2, 3].map(|j| self.spring_torque_of(j, x))
    }

    /// One of [`Self::spring_torques`].
    #[inline(always)]
    pub(crate) fn spring_torque_of(&self, j: usize, x: &State) -> f64 {
        const PARTNERS: [[usize; 3]; 4] = [
            [E, D, TWIST_D],
            [C, O, TWIST_T],
            [C + 1, O, TWIST_T + 1],
            [O, W, TWIST_O],
        ];
        let entries = PARTNERS[j].map(|i| self.spring_torque[(j, i)] * x[i]);
        entries[0] + entries[1] + entries[2]
    }
}

#[cfg(test)]
mod tests {
    use crate::Params;
    use crate::plant::matrices::{C, D, State, Systems, Torques, W};

    #[test]
    fn rows_read_what_the_matrices_give() {
        let systems = Systems::new(&Params::TABLE_1, [1, 2]);
        let x = State::from([
            200.0, 198.0, 190.0, 150.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ]);
        let v = Torques::from([60.0, 40.0, -25.0, 300.0]);
        for system in &systems.by_stuck {
            let x_dot = system.derivative(&x, &v);
            let rate = system.clutch_torque(&x_dot, &Torques::zeros());
            assert!((system.rows.wheel_rate.of(&x, &v) - x_dot[W]).abs() < 1e-9 * x_dot.amax());
            for i in [0, 1] {
                let torque = system.clutch_torque(&x, &v)[i];
                assert!((system.rows.torque[i].of(&x, &v) - torque).abs() < 1e-9 * torque.abs());
                let slip_rate = system.rows.slip_rate[i].of(&x, &v);
                assert!((slip_rate - (x_dot[D] - x_dot[C + i])).abs() < 1e-9 * x_dot.amax());
                let torque_rate = system.rows.torque_rate[i].of(&x, &v);
                assert!((torque_rate - rate[i]).abs() <= 1e-9 * rate[i].abs());
            }
        }
    }

    #[test]
    fn spring_torques_are_what_their_rows_read() {
        for (rigid, gear) in [(false, [1, 2]), (true, [1, 2]), (false, [0, 2])] {
            let p = Params {
                rigid,
                ..Params::TABLE_1
            };
            let systems = Systems::new(&p, gear);
            let x = State::from([
                200.0, 198.0, 190.0, 150.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
            ]);
            let torques: [f64; 4] = (systems.spring_torque * x).into();
            assert_eq!(systems.spring_torques(&x), torques);
        }
    }
}
