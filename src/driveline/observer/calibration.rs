//! What `calibrating` learns: errors of parameters, the mass of the vehicle, friction over position.

use crate::observer::friction_map::POINTS;

/// Number of parameters told: α, β, δ, w, κ, γ, λ, ν.
pub const PARAMETERS: usize = 8;

/// What was learnt of the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Calibration {
    /// α [1], β [N·m], δ [1], w [rad/s], κ, γ, λ, ν [1], shape (8).
    pub value: [f64; PARAMETERS],
    /// Their standard deviations, shape (8).
    pub deviation: [f64; PARAMETERS],
    /// Mass of the vehicle [kg] and its standard deviation [kg], shape (2): all that J_v is more than believed is
    /// mass. From accelerations alone, so no grade need be known.
    pub mass: [f64; 2],
    /// μ at five positions of each clutch [1], shape (2, 5).
    pub friction: [[f64; POINTS]; 2],
    /// Their standard deviations [1], shape (2, 5).
    pub friction_deviation: [[f64; POINTS]; 2],
}
