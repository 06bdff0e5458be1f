//! Springs, dampers and inertias of the driveline: what stores energy and what loses it.

use nalgebra::{SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::plant_matrices::{C, D, E, O, SPEEDS, STATES, State, TWIST_D, W};

/// One torsional spring-damper: T = k·twist + c·rate, rate = `rate`·speeds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spring {
    pub(crate) rate: SVector<f64, SPEEDS>,
    k: f64,
    c: f64,
}

/// Kinetic and elastic energy [J] without a [`Systems`] at hand.
pub(crate) fn stored_energy(p: &Params, coupling: Coupling, x: &State) -> f64 {
    let storage = storage(p, coupling, &springs(p, coupling.gear_in()));
    0.5 * storage.dot(&x.component_mul(x))
}

pub(crate) fn springs(p: &Params, gear: [i32; 2]) -> [Spring; 4] {
    let between = |from: usize, to: usize| {
        let mut rate = SVector::zeros();
        rate[from] = 1.0;
        rate[to] = -1.0;
        rate
    };
    let transfer = |shaft: usize| {
        let mut rate = SVector::zeros();
        let i_t = p.i_t(shaft, gear[shaft]);
        if p.rigid || i_t == 0.0 {
            return Spring {
                rate,
                k: 0.0,
                c: 0.0,
            };
        }
        rate[C + shaft] = 1.0 / i_t;
        rate[O] = -p.i_f[shaft];
        Spring {
            rate,
            k: p.k_t[shaft],
            c: p.c_t[shaft],
        }
    };
    [
        Spring {
            rate: between(E, D),
            k: p.k_d,
            c: p.c_d,
        },
        transfer(0),
        transfer(1),
        Spring {
            rate: between(O, W),
            k: p.k_o,
            c: p.c_o,
        },
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
