//! Room for the matrices of a driveline, made by the compiler.

use nalgebra::{ArrayStorage, SMatrix};

use crate::coupling::Coupling;
use crate::plant::matrices::{System, Systems};
use crate::plant::rows::Rows;

const fn zeros<const R: usize, const C: usize>() -> SMatrix<f64, R, C> {
    SMatrix::from_array_storage(ArrayStorage([[0.0; R]; C]))
}

impl System {
    const EMPTY: Self = Self {
        a: zeros(),
        b: zeros(),
        t_c_x: zeros(),
        t_c_v: zeros(),
        projection: zeros(),
        rows: Rows::ZERO,
    };
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
}
