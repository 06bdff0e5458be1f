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

/// Argument beyond which tanh is 1 to the last bit.
const SATURATED: f64 = 22.0;
/// Change of an argument up to which the Padé approximant of tanh of it, x (945 + 105 x² + x⁴) over
/// 945 + 420 x² + 15 x⁴, is exact to round-off: its error is x¹⁰/10⁷ of it.
const NEAR: f64 = 0.1;

impl RoadParams {
    /// T_v of (11): load torque at the wheel [N·m], positive when it brakes forward motion.
    ///
    /// `omega_w`: wheel speed [rad/s]. `phi`: road grade [rad].
    pub fn load_torque(&self, omega_w: f64, phi: f64) -> f64 {
        let v = self.r_w * omega_w;
        let drag = 0.5 * self.rho_air * self.a_v * self.c_drag * v * v.abs();
        let roll = self.rolling(phi) * self.direction(omega_w);
        self.r_w * (self.weight() * ComplexField::sin(phi) + drag + roll)
    }

    /// The part of (11) that is smooth in the wheel speed [N·m]: without a rolling resistance that is
    /// dry friction.
    ///
    /// `omega_w`: wheel speed [rad/s]. `phi`: road grade [rad].
    /// Returns its slope by ω_w [N·m·s/rad] as well.
    #[inline(always)]
    pub(crate) fn smooth_load(&self, omega_w: f64, grade: &Grade) -> (f64, f64) {
        if self.v_eps > 0.0 {
            return self.smeared_load(omega_w, grade, |ratio| grade.direction_at(ratio));
        }
        let (force, slope) = self.flowing(self.r_w * omega_w, grade);
        (self.r_w * force, self.r_w * self.r_w * slope)
    }

    /// The same at the wheel speed that the grade was travelled at; V_ε > 0.
    #[inline(always)]
    pub(crate) fn smeared_load_here(&self, omega_w: f64, grade: &Grade) -> (f64, f64) {
        self.smeared_load(omega_w, grade, |_| grade.direction)
    }

    /// The same at a wheel speed near that which the grade was travelled at; V_ε > 0.
    #[inline(always)]
    pub(crate) fn smeared_load_near(&self, omega_w: f64, grade: &Grade) -> (f64, f64) {
        self.smeared_load(omega_w, grade, |ratio| grade.direction_near(ratio))
    }

    /// `direction`: tanh of V/V_ε.
    #[inline(always)]
    fn smeared_load(
        &self,
        omega_w: f64,
        grade: &Grade,
        direction: impl FnOnce(f64) -> f64,
    ) -> (f64, f64) {
        let v = self.r_w * omega_w;
        let (force, slope) = self.flowing(v, grade);
        let roll = self.weight() * grade.cos * self.c_rr;
        let direction = direction(v / self.v_eps);
        let roll_slope = roll * (1.0 - direction * direction) / self.v_eps;
        (
            self.r_w * (force + roll * direction),
            self.r_w * self.r_w * (slope + roll_slope),
        )
    }

    /// Grade and drag [N], and the slope of both over V [N·s/m].
    #[inline(always)]
    fn flowing(&self, v: f64, grade: &Grade) -> (f64, f64) {
        let drag = 0.5 * self.rho_air * self.a_v * self.c_drag * v.abs();
        (self.weight() * grade.sin + drag * v, 2.0 * drag)
    }

    /// Rolling resistance that is dry friction [N·m], ≥ 0; 0 where V_ε smooths it.
    pub(crate) fn dry_rolling(&self, grade: &Grade) -> f64 {
        if self.v_eps > 0.0 {
            0.0
        } else {
            self.r_w * self.weight() * grade.cos * self.c_rr
        }
    }

    /// ∂T_v/∂ω_w of (11) [N·m·s/rad]; a dry rolling resistance has none.
    ///
    /// `omega_w`: wheel speed [rad/s]. `phi`: road grade [rad].
    pub fn load_torque_slope(&self, omega_w: f64, phi: f64) -> f64 {
        let v = self.r_w * omega_w;
        let drag = self.rho_air * self.a_v * self.c_drag * v.abs();
        let roll = self.rolling(phi) * self.direction_slope(omega_w) / self.r_w;
        self.r_w * self.r_w * (drag + roll)
    }

    /// tanh(V/V_ε): direction of travel as rolling resistance sees it [1]; sgn(V) with V_ε = 0.
    pub fn direction(&self, omega_w: f64) -> f64 {
        if self.v_eps > 0.0 {
            ComplexField::tanh(self.r_w * omega_w / self.v_eps)
        } else {
            sign(omega_w)
        }
    }

    /// Derivative of [`Self::direction`] by the wheel speed [s/rad].
    pub fn direction_slope(&self, omega_w: f64) -> f64 {
        if self.v_eps > 0.0 {
            let direction = self.direction(omega_w);
            (1.0 - direction * direction) * self.r_w / self.v_eps
        } else {
            0.0
        }
    }

    /// M_v g [N].
    pub(crate) fn weight(&self) -> f64 {
        self.m_v * Self::GRAVITY
    }

    fn rolling(&self, phi: f64) -> f64 {
        self.weight() * ComplexField::cos(phi) * self.c_rr
    }
}

/// A road grade with its sine and cosine, and the direction of travel at a speed: they seldom change from one step
/// to the next, or were just computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grade {
    phi: f64,
    pub(crate) sin: f64,
    pub(crate) cos: f64,
    /// V/V_ε and its tanh.
    ratio: f64,
    direction: f64,
}

impl Grade {
    /// The level road.
    pub(crate) const LEVEL: Self = Self {
        phi: 0.0,
        sin: 0.0,
        cos: 1.0,
        ratio: 0.0,
        direction: 0.0,
    };

    /// A grade of `phi` [rad]; this one where it is the same.
    #[inline(always)]
    pub(crate) fn at(&self, phi: f64) -> Self {
        let mut grade = *self;
        grade.become_of(phi);
        grade
    }

    /// Whether it is a grade of `phi` [rad].
    #[inline(always)]
    pub(crate) const fn is_of(&self, phi: f64) -> bool {
        phi == self.phi
    }

    /// Becomes a grade of `phi` [rad].
    #[inline(always)]
    pub(crate) fn become_of(&mut self, phi: f64) {
        if !self.is_of(phi) {
            self.turn(phi);
        }
    }

    #[cold]
    #[inline(never)]
    fn turn(&mut self, phi: f64) {
        (self.phi, self.sin, self.cos) = (phi, ComplexField::sin(phi), ComplexField::cos(phi));
    }

    /// This grade where the wheels turn at `omega_w` [rad/s].
    #[inline(always)]
    pub(crate) fn travel(&mut self, road: &RoadParams, omega_w: f64) {
        let ratio = road.r_w * omega_w / road.v_eps;
        (self.ratio, self.direction) = (ratio, self.direction_at(ratio));
    }

    /// tanh of V/V_ε at a speed near that of [`Self::travel`].
    #[inline(always)]
    fn direction_near(&self, ratio: f64) -> f64 {
        let change = ratio - self.ratio;
        if ratio.abs() > SATURATED {
            1.0_f64.copysign(ratio)
        } else if change.abs() <= NEAR {
            tanh_of_sum(self.direction, change)
        } else {
            tanh(ratio)
        }
    }

    /// tanh of V/V_ε.
    #[inline(always)]
    fn direction_at(&self, ratio: f64) -> f64 {
        if ratio.abs() > SATURATED {
            1.0_f64.copysign(ratio)
        } else if ratio == self.ratio {
            self.direction
        } else {
            tanh(ratio)
        }
    }
}

/// tanh (a + b) of tanh a and b, |b| ≤ [`NEAR`]: addition theorem with the Padé approximant of tanh b.
#[cold]
#[inline(never)] // most speeds do not need it
fn tanh_of_sum(tanh_a: f64, b: f64) -> f64 {
    let square = b * b;
    let above = b * (945.0 + square * (105.0 + square));
    let below = 945.0 + square * (420.0 + square * 15.0);
    (tanh_a * below + above) / (below + tanh_a * above)
}

#[cold]
#[inline(never)] // most speeds do not need it
fn tanh(ratio: f64) -> f64 {
    ComplexField::tanh(ratio)
}

/// sgn x, 0 at 0 [1].
pub(crate) fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::Grade;
    use crate::Params;
    use crate::params::RoadParams;

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
    fn the_smooth_load_of_a_smeared_resistance_is_all_of_it_with_its_slope() {
        let (road, grade) = (Params::TABLE_1.road, Grade::LEVEL.at(0.04));
        for omega_w in [-40.0, -0.1, 0.0, 0.03, 1.0, 90.0] {
            let (load, slope) = road.smooth_load(omega_w, &grade);
            assert!((load - road.load_torque(omega_w, 0.04)).abs() < 1e-9);
            assert!((slope - road.load_torque_slope(omega_w, 0.04)).abs() < 1e-9);
        }
    }

    #[test]
    fn near_a_speed_the_load_is_what_it_is_there() {
        let road = Params::TABLE_1.road;
        let mut grade = Grade::LEVEL.at(0.04);
        for ratio in [-40.0, -22.05, -3.0, -0.3, 0.0, 0.01, 0.7, 4.0, 21.95, 30.0] {
            let omega_w = ratio * road.v_eps / road.r_w;
            grade.travel(&road, omega_w);
            for change in [-0.3, -0.1, -0.05, -1e-9, 0.0, 0.02, 0.0999, 5.0] {
                let omega_w = (ratio + change) * road.v_eps / road.r_w;
                let (near, near_slope) = road.smeared_load_near(omega_w, &grade);
                let (load, slope) = road.smooth_load(omega_w, &grade);
                assert!((near - load).abs() < 1e-12, "{ratio} {change}");
                assert!((near_slope - slope).abs() < 1e-11, "{ratio} {change}");
            }
        }
    }

    #[test]
    fn dry_rolling_resistance_is_what_the_smooth_load_lacks() {
        let road = RoadParams {
            v_eps: 0.0,
            ..Params::TABLE_1.road
        };
        let grade = Grade::LEVEL.at(0.03);
        let (fast, dry) = (20.0, road.dry_rolling(&grade));
        assert!(dry > 0.0 && Params::TABLE_1.road.dry_rolling(&grade) == 0.0);
        for omega_w in [fast, -fast] {
            let whole = road.smooth_load(omega_w, &grade).0 + dry * omega_w.signum();
            let smeared = Params::TABLE_1.road.load_torque(omega_w, 0.03);
            assert!((whole - smeared).abs() < 1e-9);
        }
        assert_eq!(road.load_torque(0.0, 0.0), 0.0);
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
