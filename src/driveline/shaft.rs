//! Road load (11): what the vehicle puts against the wheels.
//!
//! T_v = r_w [ M_v g sin φ + ½ ρ A_v C_D V|V| + M_v g cos φ C_rr tanh(V/V_ε) ],  V = r_w ω_w
//!
//! ```
//! use dct_driveline::Params;
//!
//! let road = Params::TABLE_1.road;
//! assert_eq!(road.load_torque(0.0, 0.0), 0.0);
//! assert!(road.load_torque(0.0, 0.05) > 200.0); // uphill
//! ```

use nalgebra::ComplexField;

use crate::params::RoadParams;

impl RoadParams {
    /// T_v of (11): load torque at the wheel [N·m], positive when it brakes forward motion.
    ///
    /// `omega_w`: wheel speed [rad/s]. `phi`: road grade [rad].
    pub fn load_torque(&self, omega_w: f64, phi: f64) -> f64 {
        let v = self.r_w * omega_w;
        let drag = 0.5 * self.rho_air * self.a_v * self.c_drag * v * v.abs();
        let roll = self.rolling(phi) * ComplexField::tanh(v / Self::V_EPS);
        self.r_w * (self.weight() * ComplexField::sin(phi) + drag + roll)
    }

    /// ∂T_v/∂ω_w of (11) [N·m·s/rad].
    ///
    /// `omega_w`: wheel speed [rad/s]. `phi`: road grade [rad].
    pub fn load_torque_slope(&self, omega_w: f64, phi: f64) -> f64 {
        let v = self.r_w * omega_w;
        let drag = self.rho_air * self.a_v * self.c_drag * v.abs();
        let roll = self.rolling(phi) * self.direction_slope(omega_w) / self.r_w;
        self.r_w * self.r_w * (drag + roll)
    }

    /// tanh(V/V_ε): direction of travel as rolling resistance and brakes see it [1].
    pub fn direction(&self, omega_w: f64) -> f64 {
        ComplexField::tanh(self.r_w * omega_w / Self::V_EPS)
    }

    /// Derivative of [`Self::direction`] by the wheel speed [s/rad].
    pub fn direction_slope(&self, omega_w: f64) -> f64 {
        let direction = self.direction(omega_w);
        (1.0 - direction * direction) * self.r_w / Self::V_EPS
    }

    fn weight(&self) -> f64 {
        self.m_v * Self::GRAVITY
    }

    fn rolling(&self, phi: f64) -> f64 {
        self.weight() * ComplexField::cos(phi) * self.c_rr
    }
}

#[cfg(test)]
mod tests {
    use crate::Params;

    #[test]
    fn slope_is_the_derivative() {
        let road = Params::TABLE_1.road;
        let step = 1e-5;
        for omega_w in [-40.0, -0.1, 0.0, 0.03, 1.0, 90.0] {
            let up = road.load_torque(omega_w + step, 0.04);
            let down = road.load_torque(omega_w - step, 0.04);
            let slope = road.load_torque_slope(omega_w, 0.04);
            assert!(
                ((up - down) / (2.0 * step) - slope).abs() < 1e-5,
                "{omega_w} rad/s"
            );
        }
    }

    #[test]
    fn load_opposes_motion_on_the_level() {
        let road = Params::TABLE_1.road;
        for omega_w in [0.01, 1.0, 50.0] {
            assert!(road.load_torque(omega_w, 0.0) > 0.0);
            assert_eq!(
                road.load_torque(-omega_w, 0.0),
                -road.load_torque(omega_w, 0.0)
            );
        }
    }
}
