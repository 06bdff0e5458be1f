//! The state of the driveline and the torques on it: which number is which.

use nalgebra::SVector;

/// Number of states: ω_e ω_d ω_c1 ω_c2 ω_o ω_w, then the twists of damper, transfer shafts, drive
/// shaft.
pub const STATES: usize = 10;
/// Number of speeds among the states.
pub const SPEEDS: usize = 6;
/// Number of torques: T_e, T_c1, T_c2, T_v.
pub const TORQUES: usize = 4;

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
