//! The driveline (1)-(10) as matrices, one set per choice of engaged clutches.
//!
//! With x the state and v = (T_e, T_c1, T_c2, T_v) the torques, the open driveline is
//! x' = A x + B v. An engaged clutch replaces its entry of v by the constraint torque that keeps
//! d/dt (ω_d − ω_ci) = 0; both engaged is the 2×2 case of the same formula.
//!
//! Springs act through the transpose of the row that reads their rate of twist, but where a gear mesh
//! loses power (`plant/mesh.rs`), and inertias through the mobility W (`matrices/mobility.rs`). The rigid variant,
//! with ω_ci = g_i ω_o, differs from the compliant one in W alone.
//!
//! While a shaft is synchronised its clutch is open, so its entry of v is free: it carries the torque of
//! the synchroniser, which acts on ω_ci − g_i ω_o in place of the slip.

pub(crate) mod mobility;
mod rows;
pub(crate) mod springs;
pub(crate) mod state;
mod system;

use nalgebra::SMatrix;

use crate::Params;
use crate::coupling::Coupling;
use crate::matrices::mobility::mobility;
pub use crate::matrices::rows::{Row, Rows};
use crate::matrices::springs::{spring_torque, springs, storage, viscous};
pub use crate::matrices::state::{
    C, D, E, O, SPEEDS, STATES, State, TORQUES, TWIST_D, TWIST_O, TWIST_T, Torques, W, slip,
};
pub use crate::matrices::system::System;
use crate::matrices::system::{Open, engaged_driveline, open_driveline, zeros};

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

impl Systems {
    /// Nothing is connected and nothing moves.
    pub(crate) const EMPTY: Self = Self {
        coupling: Coupling {
            gear: [0; 2],
            synchronising: [false; 2],
            held: false,
            power: [0; 2],
            jammed: false,
        },
        rigid_ratio: [0.0; 2],
        ratio: [0.0; 2],
        synchroniser_ratio: [0.0; 2],
        by_stuck: [System::EMPTY; 4],
        spring_torque: zeros(),
        viscous: zeros(),
        mesh_loss: [0.0; 2],
        storage: zeros(),
    };

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
        self.mesh_loss = mesh_loss(p, coupling);
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
        self.by_stuck[set] = engaged_driveline(open, self.coupling.engageable(set), g, j_ct);
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

/// 1 − η^s of both shafts [1], shape (2): what is lost of the torque.
fn mesh_loss(p: &Params, coupling: Coupling) -> [f64; 2] {
    let (gear, power) = (coupling.gear_in(), coupling.power);
    [0, 1].map(|i| 1.0 - p.mesh_factor(i, gear[i], power[i]))
}

/// g_i of the gear that a shaft is synchronised to; 0 where none is, shape (2).
fn synchroniser_ratio(p: &Params, coupling: Coupling) -> [f64; 2] {
    let g = p.g(coupling.gear);
    [0, 1].map(|i| if coupling.synchronising[i] { g[i] } else { 0.0 })
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
