//! The driveline (1)-(10) as matrices, one set per choice of engaged clutches.
//!
//! With x the state and v = (T_e, T_c1, T_c2, T_v) the torques, the open driveline is
//! x' = A x + B v. An engaged clutch replaces its entry of v by the constraint torque that keeps
//! d/dt (ω_d − ω_ci) = 0; both engaged is the 2×2 case of the same formula.
//!
//! Springs act through the transpose of the row that reads their rate of twist, but where a gear mesh
//! loses power (`plant/mesh.rs`), and inertias through the mobility W (`plant/mobility.rs`). The rigid variant,
//! with ω_ci = g_i ω_o, differs from the compliant one in W alone.
//!
//! While a shaft is synchronised its clutch is open, so its entry of v is free: it carries the torque of
//! the synchroniser, which acts on ω_ci − g_i ω_o in place of the slip.

use nalgebra::{Matrix2, SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::plant::mobility::{Mobility, mobility};
pub use crate::plant::rows::{Row, Rows};
use crate::plant::springs::{Spring, spring_torque, springs, storage, viscous};

/// Number of states: ω_e ω_d ω_c1 ω_c2 ω_o ω_w, then the twists of damper, transfer shafts, drive
/// shaft.
pub const STATES: usize = 10;
/// Number of speeds among the states.
pub const SPEEDS: usize = 6;
/// Number of torques: T_e, T_c1, T_c2, T_v.
pub const TORQUES: usize = 4;
/// State, torques and their ramps.
pub const AUGMENTED: usize = STATES + 2 * TORQUES;

/// Index of ω_e in the state.
pub const E: usize = 0;
/// Index of ω_d in the state.
pub const D: usize = 1;
/// Index of ω_c1 in the state; ω_c2 follows.
pub const C: usize = 2;
/// Index of ω_o in the state.
pub const O: usize = 4;
/// Index of ω_w in the state.
pub const W: usize = 5;
/// Index of the damper's twist θ_e − θ_d in the state.
pub const TWIST_D: usize = 6;
/// Index of the first transfer shaft's twist in the state; the second follows.
pub const TWIST_T: usize = 7;
/// Index of the drive shaft's twist θ_o − θ_w in the state.
pub const TWIST_O: usize = 9;

/// State of the driveline, shape (10).
pub type State = SVector<f64, STATES>;
/// T_e, T_c1, T_c2, T_v [N·m], shape (4).
pub type Torques = SVector<f64, TORQUES>;

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
}

/// The coupled driveline: what holds for every choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct Systems {
    /// What is connected to what.
    pub coupling: Coupling,
    /// ω_ci = g_i ω_o holds exactly; 0 where it does not (compliant, neutral), shape (2).
    pub rigid_ratio: [f64; 2],
    /// g_i of the gear that is in; 0 in neutral, shape (2).
    pub ratio: [f64; 2],
    /// g_i of the gear that a shaft is synchronised to; 0 where none is, shape (2).
    pub synchroniser_ratio: [f64; 2],
    /// By engaged clutches: none, clutch 1, clutch 2, both.
    pub by_stuck: [System; 4],
    /// Damper, transfer shafts 1 and 2, drive shaft: rows that read their torque, shape (4, 10).
    pub spring_torque: SMatrix<f64, 4, STATES>,
    /// Power lost in dampers, Σ c·rate², as a quadratic form of the state, shape (10, 10).
    pub viscous: SMatrix<f64, STATES, STATES>,
    /// 1 − η^s: the share of i_fi T_ti that gears that lose power do not pass on, shape (2).
    pub(crate) mesh_loss: [f64; 2],
    /// Twice the stored energy is Σ `storage` x², shape (10).
    pub storage: State,
}

/// Rows that read ω_d − ω_ci from the speeds, shape (6).
pub(crate) fn slip_row(clutch: usize) -> SVector<f64, SPEEDS> {
    let mut row = SVector::zeros();
    row[D] = 1.0;
    row[C + clutch] = -1.0;
    row
}

/// Row that reads ω_ci − g_i ω_o from the speeds, shape (6).
pub(crate) fn synchroniser_row(shaft: usize, g: f64) -> SVector<f64, SPEEDS> {
    let mut row = SVector::zeros();
    row[C + shaft] = 1.0;
    row[O] = -g;
    row
}

/// ω_d − ω_ci [rad/s], shape (2).
pub fn slip(x: &State) -> [f64; 2] {
    [x[D] - x[C], x[D] - x[C + 1]]
}

impl Systems {
    /// Matrices of the driveline with what is connected; two gears stand for turning wheels.
    pub fn new(p: &Params, coupling: impl Into<Coupling>) -> Self {
        let mut systems = Self::EMPTY;
        systems.connect(p, coupling.into());
        systems
    }

    /// Turns these into those of another coupling, in place: a caller's stack may have no room for two.
    #[inline(never)] // what it takes of the stack is free again after it
    pub(crate) fn connect(&mut self, p: &Params, coupling: Coupling) {
        let springs = springs(p, coupling);
        self.coupling = coupling;
        self.rigid_ratio = rigid_ratio(p, coupling);
        self.ratio = p.g(coupling.gear_in());
        self.synchroniser_ratio = synchroniser_ratio(p, coupling);
        self.spring_torque = spring_torque(&springs);
        self.viscous = viscous(&springs);
        self.mesh_loss = p.mesh_loss(coupling);
        self.storage = storage(p, coupling, &springs);
        let open = open_driveline(&springs, mobility(p, coupling), self.synchroniser_ratio);
        for set in 0..3 {
            self.engage(p, &open, set);
        }
        let tied = coupling.tied(p).map(|coupling| {
            open_driveline(&springs, mobility(p, coupling), self.synchroniser_ratio)
        });
        self.engage(p, tied.as_ref().unwrap_or(&open), 3);
    }

    #[inline(never)]
    fn engage(&mut self, p: &Params, open: &Open, set: usize) {
        let (g, j_ct) = (self.ratio, p.j_ct_in(self.coupling.gear_in()));
        let rows = |system: &System| Rows::new(system, g, j_ct);
        self.by_stuck[set] = engaged_driveline(open, self.coupling.engageable(set), rows);
    }

    /// Whether gear meshes lose power, so that ω_o itself costs some.
    pub(crate) fn meshes_lose(&self) -> bool {
        self.mesh_loss != [0.0; 2]
    }

    /// Power lost in dampers and meshes [W] with the clutches of `set` (bit i: clutch i) engaged.
    pub fn power_lost(&self, set: usize, x: &State, v: &Torques) -> f64 {
        let lost = Row::sum(&self.by_stuck[set & 3].rows.mesh, self.mesh_loss);
        (self.viscous * x).dot(x) + x[O] * lost.of(x, v)
    }

    /// Kinetic and elastic energy [J].
    #[inline(never)] // a function of its own has registers for it
    pub fn stored_energy(&self, x: &State) -> f64 {
        let (storage, x) = (&self.storage.data.0[0], &x.data.0[0]);
        let mut lanes = [0.0; 2];
        for (storage, x) in storage.as_chunks::<2>().0.iter().zip(x.as_chunks::<2>().0) {
            lanes[0] += storage[0] * (x[0] * x[0]);
            lanes[1] += storage[1] * (x[1] * x[1]);
        }
        0.5 * (lanes[0] + lanes[1])
    }
}

/// g_i of the gear in where transfer shafts are rigid, else 0, shape (2).
pub(crate) fn rigid_ratio(p: &Params, coupling: Coupling) -> [f64; 2] {
    if p.rigid {
        p.g(coupling.gear_in())
    } else {
        [0.0; 2]
    }
}

/// g_i of the gear that a shaft is synchronised to; 0 where none is, shape (2).
fn synchroniser_ratio(p: &Params, coupling: Coupling) -> [f64; 2] {
    let g = p.g(coupling.gear);
    [0, 1].map(|i| if coupling.synchronising[i] { g[i] } else { 0.0 })
}

/// The driveline with no clutch engaged.
struct Open {
    a: SMatrix<f64, STATES, STATES>,
    b: SMatrix<f64, STATES, TORQUES>,
    mobility: Mobility,
}

fn open_driveline(springs: &[Spring; 4], mobility: Mobility, synchroniser_ratio: [f64; 2]) -> Open {
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
fn engaged_driveline(open: &Open, set: usize, read: impl Fn(&System) -> Rows) -> System {
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
        rows: read(&system),
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

#[cfg(test)]
mod tests {
    use super::{C, D, O, State, Systems, Torques};
    use crate::Params;

    const V: [f64; 4] = [60.0, 40.0, -25.0, 300.0];
    /// Terms of a derivative cancel to a thousandth of themselves.
    const ROUND_OFF: f64 = 1e-12;

    fn state() -> State {
        State::from([
            200.0, 198.0, 190.0, 150.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ])
    }

    #[test]
    fn engaged_clutches_keep_their_slip() {
        for rigid in [false, true] {
            let systems = Systems::new(
                &Params {
                    rigid,
                    ..Params::TABLE_1
                },
                [1, 2],
            );
            for set in 0..4_usize {
                let x_dot = systems.by_stuck[set].derivative(&state(), &Torques::from(V));
                for clutch in (0..2).filter(|clutch| set >> clutch & 1 == 1) {
                    assert!((x_dot[D] - x_dot[C + clutch]).abs() < 1e-7, "{rigid} {set}");
                }
            }
        }
    }

    #[test]
    fn constraint_torque_as_an_input_gives_the_same_motion() {
        let systems = Systems::new(&Params::TABLE_1, [1, 2]);
        for set in 0..4_usize {
            let mut v = Torques::from(V);
            let engaged = systems.by_stuck[set].derivative(&state(), &v);
            let t_c = systems.by_stuck[set].clutch_torque(&state(), &v);
            (v[1], v[2]) = (t_c[0], t_c[1]);
            let open = systems.by_stuck[0].derivative(&state(), &v);
            assert!((engaged - open).amax() < 1e-7 * open.amax());
        }
    }

    #[test]
    fn a_rate_is_an_entry_of_the_derivative() {
        let (systems, v) = (Systems::new(&Params::TABLE_1, [1, 2]), Torques::from(V));
        for system in &systems.by_stuck {
            let x_dot = system.derivative(&state(), &v);
            for (i, x_dot) in x_dot.iter().enumerate() {
                let apart = (system.rate(i, &state(), &v) - x_dot).abs();
                assert!(apart <= ROUND_OFF * x_dot.abs().max(1.0), "{i}");
            }
        }
    }

    #[test]
    fn energy_balances_at_every_instant() {
        for rigid in [false, true] {
            let p = Params {
                rigid,
                ..Params::TABLE_1
            };
            let systems = Systems::new(&p, [1, 2]);
            let mut x = state();
            for clutch in [0, 1] {
                if rigid {
                    x[C + clutch] = p.g([1, 2])[clutch] * x[O];
                }
            }
            let v = Torques::from(V);
            let x_dot = systems.by_stuck[0].derivative(&x, &v);
            let stored = systems.storage.component_mul(&x).dot(&x_dot);
            let [one, two] = super::slip(&x);
            let used = v[1] * one + v[2] * two + v[3] * x[5] + (systems.viscous * x).dot(&x);
            assert!((v[0] * x[0] - stored - used).abs() < 1e-6 * used.abs());
        }
    }

    #[test]
    fn neutral_cuts_the_shaft_from_the_output() {
        for rigid in [false, true] {
            let p = Params {
                rigid,
                ..Params::TABLE_1
            };
            let systems = Systems::new(&p, [1, 0]);
            let x_dot = |t_c2: f64| {
                systems.by_stuck[0]
                    .derivative(&State::zeros(), &Torques::from([0.0, 0.0, t_c2, 0.0]))
            };
            assert_eq!(x_dot(50.0)[O], 0.0);
            assert!((x_dot(50.0)[C + 1] - 50.0 / p.j_ct[1]).abs() < 1e-9);
        }
    }
}
