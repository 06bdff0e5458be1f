//! Springs, dampers and inertias of the driveline: what stores energy and what loses it.

use nalgebra::{SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::matrices::state::{C, D, E, O, SPEEDS, STATES, State, TWIST_D, TWIST_O, TWIST_T, W};

/// One torsional spring-damper: T = k·twist + c·rate, rate = `rate`·speeds; it acts on them by −T·`act`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spring {
    pub(crate) rate: SVector<f64, SPEEDS>,
    /// `rate`, but where a gear mesh between spring and inertia loses power.
    pub(crate) act: SVector<f64, SPEEDS>,
    k: f64,
    c: f64,
}

/// Kinetic and elastic energy [J] without a [`Systems`] at hand.
pub(crate) fn stored_energy(p: &Params, coupling: Coupling, x: &State) -> f64 {
    let storage = storage(p, coupling, &springs(p, coupling));
    0.5 * storage.dot(&x.component_mul(x))
}

impl Spring {
    /// A spring between two inertias.
    fn between(from: usize, to: usize, k: f64, c: f64) -> Self {
        let mut rate = SVector::zeros();
        rate[from] = 1.0;
        rate[to] = -1.0;
        let act = rate;
        Self { rate, act, k, c }
    }

    /// A transfer shaft; nothing where it is rigid or in neutral.
    fn transfer(p: &Params, shaft: usize, gear: i32, power: i8) -> Self {
        let (mut rate, i_t) = (SVector::zeros(), p.i_t(shaft, gear));
        if p.rigid || i_t == 0.0 {
            let (act, k, c) = (rate, 0.0, 0.0);
            return Self { rate, act, k, c };
        }
        rate[C + shaft] = 1.0 / i_t;
        rate[O] = -p.i_f[shaft];
        let mut act = rate;
        act[O] *= p.mesh_factor(shaft, gear, power);
        let (k, c) = (p.k_t[shaft], p.c_t[shaft]);
        Self { rate, act, k, c }
    }

    /// Torque [N·m] of a transfer shaft from a state, or its rate from the state's rate.
    fn torque(&self, twist: usize, x: &State) -> f64 {
        let rate: f64 = (0..SPEEDS).map(|j| self.rate[j] * x[j]).sum();
        self.k * x[twist] + self.c * rate
    }
}

/// T_t1, T_t2 [N·m] of compliant shafts, shape (2), from a state, or their rates from the state's rate.
pub(crate) fn transfer_torques(p: &Params, gear: [i32; 2], x: &State) -> [f64; 2] {
    [0, 1].map(|i| Spring::transfer(p, i, gear[i], 0).torque(TWIST_T + i, x))
}

/// T_o of (10) [N·m] from a state, or its rate from the state's rate.
pub(crate) fn drive_shaft_torque(p: &Params, x: &State) -> f64 {
    p.k_o * x[TWIST_O] + p.c_o * (x[O] - x[W])
}

pub(crate) fn springs(p: &Params, coupling: Coupling) -> [Spring; 4] {
    let (gear, power) = (coupling.gear_in(), coupling.power);
    [
        Spring::between(E, D, p.k_d, p.c_d),
        Spring::transfer(p, 0, gear[0], power[0]),
        Spring::transfer(p, 1, gear[1], power[1]),
        Spring::between(O, W, p.k_o, p.c_o),
    ]
}

pub(crate) fn spring_torque(springs: &[Spring; 4]) -> SMatrix<f64, 4, STATES> {
    let mut rows = SMatrix::<f64, 4, STATES>::zeros();
    for (j, spring) in springs.iter().enumerate() {
        rows.fixed_view_mut::<1, SPEEDS>(j, 0)
            .copy_from(&(spring.c * spring.rate.transpose()));
        rows[(j, TWIST_D + j)] = spring.k;
    }
    rows
}

/// Power lost in dampers as a quadratic form of the state.
pub(crate) fn viscous(springs: &[Spring; 4]) -> SMatrix<f64, STATES, STATES> {
    let mut form = SMatrix::<f64, STATES, STATES>::zeros();
    for spring in springs {
        let mut speeds = form.fixed_view_mut::<SPEEDS, SPEEDS>(0, 0);
        speeds += spring.c * spring.rate * spring.rate.transpose();
    }
    form
}

pub(crate) fn storage(p: &Params, coupling: Coupling, springs: &[Spring; 4]) -> State {
    let [damper, shaft_1, shaft_2, drive] = springs.map(|spring| spring.k);
    let j_ct = p.j_ct_in(coupling.gear_in());
    let j = [p.j_e, p.j_d, j_ct[0], j_ct[1], p.j_o, p.j_v];
    State::from([
        j[0], j[1], j[2], j[3], j[4], j[5], damper, shaft_1, shaft_2, drive,
    ])
}
