//! A clutch in the terms of (23), (24): T_c = μ f_n · r_c N θ_m.

use crate::observer::instant::Instant;

/// Actuator and map of one clutch at an instant, in the terms of (23).
#[derive(Debug, Clone, Copy)]
pub struct Lever {
    /// r_c N θ_m [m²]; 0 below the touch point.
    pub arm: f64,
    /// f_n = F_map/θ_m [N/m].
    pub f_n: f64,
}

impl Lever {
    /// Lever of clutch `i`.
    ///
    /// Deviation: below the touch point the clutch transmits nothing and ε̂ is frozen; the paper would
    /// see a phantom torque there. A wet clutch takes the position that gives its force.
    pub fn new(now: &Instant<'_>, i: usize) -> Self {
        let (clutch, force) = (&now.p.clutch[i], now.force[i]);
        let open = Self { arm: 0.0, f_n: 0.0 };
        if force <= 0.0 {
            return open;
        }
        let theta = clutch.map.position(force);
        if theta <= 0.0 {
            return open;
        }
        Self {
            arm: clutch.r_c_n * theta,
            f_n: force / theta,
        }
    }
}
