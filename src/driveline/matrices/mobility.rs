//! The mobility of the driveline: accelerations = W·(torques on the six inertias).
//!
//! Where nothing is rigid W = J⁻¹. Rigid shafts follow the output, ω_ci = g_i ω_o, and give it g_i η^s of
//! the torque that turns them (`plant/mesh.rs`), so that
//!
//! ```text
//! J_out ω̇_o = Σ g_i η_i^s T(ω_ci) + T(ω_o),     J_out = J_o + Σ g_i² η_i^s J_cti
//! ```
//!
//! What stands, held by the brake or jammed, does not move: its rows are zero.

use nalgebra::{SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::matrices::state::{C, O, SPEEDS, W};

/// Accelerations by torques on the six inertias, shape (6, 6).
pub(crate) type Mobility = SMatrix<f64, SPEEDS, SPEEDS>;

/// W, shape (6, 6).
pub(crate) fn mobility(p: &Params, coupling: Coupling) -> Mobility {
    let gear = coupling.gear_in();
    let j_ct = p.j_ct_in(gear);
    let j = [p.j_e, p.j_d, j_ct[0], j_ct[1], p.j_o, p.j_v];
    let mut mobility = Mobility::from_diagonal(&SVector::from(j.map(|j| 1.0 / j)));
    if coupling.held {
        mobility[(W, W)] = 0.0;
    }
    if coupling.jammed {
        mobility[(O, O)] = 0.0;
    }
    if p.rigid {
        follow_output(p, coupling, j_ct, &mut mobility);
    }
    mobility
}

/// Lets shafts with a gear follow the output.
fn follow_output(p: &Params, coupling: Coupling, j_ct: [f64; 2], mobility: &mut Mobility) {
    let (gear, g) = (coupling.gear_in(), p.g(coupling.gear_in()));
    let (mut moves, mut j_out) = (SVector::<f64, SPEEDS>::zeros(), p.j_o);
    let mut acts = moves;
    (moves[O], acts[O], mobility[(O, O)]) = (1.0, 1.0, 0.0);
    for i in (0..2).filter(|i| g[*i] != 0.0) {
        let passed = g[i] * p.mesh_factor(i, gear[i], coupling.power[i]);
        (moves[C + i], acts[C + i], mobility[(C + i, C + i)]) = (g[i], passed, 0.0);
        j_out += g[i] * passed * j_ct[i];
    }
    if !coupling.jammed {
        *mobility += moves * acts.transpose() / j_out;
    }
}
