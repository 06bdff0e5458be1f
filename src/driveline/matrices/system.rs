//! One set of matrices: the driveline with no clutch engaged, and with some of them.

use nalgebra::{ArrayStorage, Matrix2, SMatrix};

use crate::matrices::mobility::Mobility;
use crate::matrices::rows::{Row, Rows};
use crate::matrices::springs::{Spring, spring_torque};
use crate::matrices::state::{
    C, D, E, SPEEDS, STATES, State, TORQUES, TWIST_D, Torques, W, slip_row, synchroniser_row,
};

/// The driveline with one choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct System {
    /// A of x' = A x + B v, shape (10, 10).
    pub a: SMatrix<f64, STATES, STATES>,
    /// B of x' = A x + B v, shape (10, 4); zero in the columns of engaged clutches.
    pub b: SMatrix<f64, STATES, TORQUES>,
    /// T_c = `t_c_x` x + `t_c_v` v, shape (2, 10).
    pub t_c_x: SMatrix<f64, 2, STATES>,
    /// T_c = `t_c_x` x + `t_c_v` v, shape (2, 4).
    pub t_c_v: SMatrix<f64, 2, TORQUES>,
    /// Speed change per slip removed by an impulse in the engaged clutches, shape (10, 2).
    pub projection: SMatrix<f64, STATES, 2>,
    /// What guards watch.
    pub rows: Rows,
}

impl System {
    /// Nothing moves.
    pub(super) const EMPTY: Self = Self {
        a: zeros(),
        b: zeros(),
        t_c_x: zeros(),
        t_c_v: zeros(),
        projection: zeros(),
        rows: Rows::ZERO,
    };

    /// x' [rad/s², rad/s], shape (10).
    pub fn derivative(&self, x: &State, v: &Torques) -> State {
        self.a * x + self.b * v
    }

    /// One entry of [`Self::derivative`].
    pub fn rate(&self, state: usize, x: &State, v: &Torques) -> f64 {
        let by_state: f64 = (0..STATES).map(|j| self.a[(state, j)] * x[j]).sum();
        let by_torque: f64 = (0..TORQUES).map(|q| self.b[(state, q)] * v[q]).sum();
        by_state + by_torque
    }

    /// T_c1, T_c2 [N·m], shape (2): entry of v, or the constraint torque of an engaged clutch.
    pub fn clutch_torque(&self, x: &State, v: &Torques) -> [f64; 2] {
        (self.t_c_x * x + self.t_c_v * v).into()
    }

    /// What guards watch, from the matrices.
    ///
    /// `g`: ratios of the gears that are in, else 0. `j_ct`: inertias of the input shafts with them [kg·m²].
    fn watched(&self, g: [f64; 2], j_ct: [f64; 2]) -> Rows {
        let System {
            a, b, t_c_x, t_c_v, ..
        } = self;
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
        Rows {
            mesh: [0, 1].map(mesh),
            torque: [0, 1].map(|i| row(t_c_x, t_c_v, i)),
            torque_rate: [0, 1].map(|i| row(&rate_x, &rate_v, i)),
            slip_rate: [0, 1].map(slip),
            wheel_rate: Row::new(&a.row(W).into_owned(), &b.row(W).into_owned()),
        }
    }
}

/// The driveline with no clutch engaged.
pub(super) struct Open {
    a: SMatrix<f64, STATES, STATES>,
    b: SMatrix<f64, STATES, TORQUES>,
    mobility: Mobility,
}

/// The driveline with no clutch engaged.
///
/// `synchroniser_ratio`: g_i of gears that shafts are synchronised to, else 0, shape (2).
pub(super) fn open_driveline(
    springs: &[Spring; 4],
    mobility: Mobility,
    synchroniser_ratio: [f64; 2],
) -> Open {
    let mut a = SMatrix::<f64, STATES, STATES>::zeros();
    let torque = spring_torque(springs);
    for (j, spring) in springs.iter().enumerate() {
        let acts = mobility * spring.act;
        let mut speeds = a.fixed_rows_mut::<SPEEDS>(0);
        speeds -= acts * torque.row(j);
        a.fixed_view_mut::<1, SPEEDS>(TWIST_D + j, 0)
            .copy_from(&spring.rate.transpose());
    }
    let mut acts = SMatrix::<f64, SPEEDS, TORQUES>::zeros();
    acts[(E, 0)] = 1.0;
    for (i, ratio) in synchroniser_ratio.into_iter().enumerate() {
        let acting = if ratio == 0.0 {
            slip_row(i)
        } else {
            synchroniser_row(i, ratio)
        };
        acts.set_column(1 + i, &-acting);
    }
    acts[(W, 3)] = -1.0;
    let mut b = SMatrix::<f64, STATES, TORQUES>::zeros();
    b.fixed_rows_mut::<SPEEDS>(0).copy_from(&(mobility * acts));
    Open { a, b, mobility }
}

/// The open driveline with the clutches of `set` (bit i: clutch i) held at zero slip.
///
/// `g`: ratios of the gears that are in, else 0. `j_ct`: inertias of the input shafts with them [kg·m²].
pub(super) fn engaged_driveline(open: &Open, set: usize, g: [f64; 2], j_ct: [f64; 2]) -> System {
    let Open { a, b, mobility } = open;
    let stuck = [0, 1].map(|clutch| set >> clutch & 1 == 1);
    let mut rows = SMatrix::<f64, 2, STATES>::zeros();
    let mut free = *b;
    let mut t_c_v = SMatrix::<f64, 2, TORQUES>::zeros();
    for clutch in [0, 1] {
        if stuck[clutch] {
            rows.fixed_view_mut::<1, SPEEDS>(clutch, 0)
                .copy_from(&slip_row(clutch).transpose());
            free.column_mut(1 + clutch).fill(0.0);
        } else {
            t_c_v[(clutch, 1 + clutch)] = 1.0;
        }
    }
    let speeds = rows.fixed_columns::<SPEEDS>(0).transpose();
    let inverse = inverse_of_stuck(&(speeds.transpose() * mobility * speeds), stuck);
    let mut projection = SMatrix::<f64, STATES, 2>::zeros();
    projection
        .fixed_rows_mut::<SPEEDS>(0)
        .copy_from(&(mobility * speeds * inverse));
    let t_c_x = inverse * rows * a;
    t_c_v += inverse * rows * free;
    let act = b.fixed_columns::<2>(1);
    let mut b = free;
    b.fixed_columns_mut::<2>(1).fill(0.0);
    let (a, b) = (a + act * t_c_x, b + act * t_c_v);
    let system = System {
        rows: Rows::ZERO,
        a,
        b,
        t_c_x,
        t_c_v,
        projection,
    };
    System {
        rows: system.watched(g, j_ct),
        ..system
    }
}

/// Inverse on the engaged clutches, zero elsewhere, shape (2, 2).
fn inverse_of_stuck(m: &Matrix2<f64>, stuck: [bool; 2]) -> Matrix2<f64> {
    match stuck {
        [true, true] => m.try_inverse().unwrap_or_default(),
        [one, two] => Matrix2::from_diagonal(
            &[(one, m[(0, 0)]), (two, m[(1, 1)])]
                .map(|(is, m)| if is { 1.0 / m } else { 0.0 })
                .into(),
        ),
    }
}

/// Zeros that the compiler can make.
pub(super) const fn zeros<const R: usize, const C: usize>() -> SMatrix<f64, R, C> {
    SMatrix::from_array_storage(ArrayStorage([[0.0; R]; C]))
}

#[cfg(test)]
mod tests {
    use crate::Params;
    use crate::matrices::Systems;
    use crate::matrices::state::{C, D, State, Torques, W};

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
}
