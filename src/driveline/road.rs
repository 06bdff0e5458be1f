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

use crate::Params;
use crate::params::RoadParams;
use crate::tanh::{self, NEAR, SATURATED, tanh};

/// Correction of ω_w [rad/s] whose square, the error left by Newton's step on the load, is below round-off.
pub(crate) const LOAD_SETTLED: f64 = 1e-8;
/// What one step of Newton's on a slow load may leave in ω_w [rad/s]: round-off.
const LOAD_LEFT: f64 = 1e-15;

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
    /// `omega_w`: wheel speed [rad/s].
    /// Returns its slope by ω_w [N·m·s/rad] as well.
    #[inline(always)]
    pub(crate) fn smooth_load(&self, omega_w: f64, grade: &Grade) -> (f64, f64) {
        if grade.is_fast(omega_w) && self.v_eps > 0.0 {
            grade.fast_load(omega_w)
        } else if self.v_eps > 0.0 {
            grade.slow_load(omega_w, tanh(grade.sharpness * omega_w))
        } else {
            grade.flowing(omega_w)
        }
    }

    /// Share of the weight's torque on the level that is a rolling resistance by dry friction [1]; 0 where V_ε smooths it.
    pub(crate) const fn dry_rolling(&self) -> f64 {
        if self.v_eps > 0.0 { 0.0 } else { self.c_rr }
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
            tanh(self.r_w * omega_w / self.v_eps)
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

    /// Largest torques of the weight, r_w M_v g, and of rolling resistance [N·m], and of drag over the square of ω_w
    /// [N·m·s²/rad²].
    pub fn sizes(&self) -> [f64; 3] {
        let weight = self.r_w * self.weight();
        [weight, weight * self.c_rr, self.drag()]
    }

    /// ½ ρ A_v C_D r_w³ [N·m·s²/rad²].
    fn drag(&self) -> f64 {
        0.5 * self.rho_air * self.a_v * self.c_drag * self.r_w * self.r_w * self.r_w
    }

    fn rolling(&self, phi: f64) -> f64 {
        self.weight() * ComplexField::cos(phi) * self.c_rr
    }
}

/// A road grade, and the load (11) on it over the wheel speed: both seldom change from one step to the next.
///
/// ```text
/// T_v = climb + drag ω_w |ω_w| + roll tanh(V/V_ε)
/// ```
///
/// Beyond `fast` the tanh is ±1 to the last bit, and the load a parabola.
#[derive(Debug, Clone, Copy)]
pub struct Grade {
    phi: f64,
    /// r_w M_v g sin φ [N·m].
    pub(crate) climb: f64,
    /// r_w M_v g cos φ [N·m].
    pub(crate) level: f64,
    /// ½ ρ A_v C_D r_w³ [N·m·s²/rad²].
    drag: f64,
    /// r_w M_v g cos φ C_rr [N·m].
    roll: f64,
    /// r_w/V_ε [s/rad].
    sharpness: f64,
    /// Wheel speed whose V/V_ε is [`SATURATED`] [rad/s].
    fast: f64,
    /// The rolling resistance is smooth, and no friction varies: between events a step takes no decisions.
    pub(crate) plain: bool,
    /// Bound of |∂²T_v/∂ω_w²| [N·m·s²/rad²].
    bend: f64,
    /// tanh of V/V_ε where the wheels last travelled slowly.
    direction: f64,
}

/// What is known of a road is no part of a state: plants do not differ by it.
impl PartialEq for Grade {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Grade {
    /// None that a road has: the first one is taken in its place.
    pub(crate) const NONE: Self = Self {
        phi: f64::INFINITY,
        climb: 0.0,
        level: 0.0,
        drag: 0.0,
        roll: 0.0,
        sharpness: 0.0,
        fast: 0.0,
        plain: false,
        bend: 0.0,
        direction: 0.0,
    };

    /// A grade of `phi` [rad]; this one where it is the same.
    #[inline(always)]
    pub(crate) fn at(&self, p: &Params, phi: f64) -> Self {
        let mut grade = *self;
        grade.become_of(p, phi);
        grade
    }

    /// Whether it is a grade of `phi` [rad].
    #[inline(always)]
    pub(crate) const fn is_of(&self, phi: f64) -> bool {
        phi == self.phi
    }

    /// Becomes a grade of `phi` [rad] with parameters that are the same at every call.
    #[inline(always)]
    pub(crate) fn become_of(&mut self, p: &Params, phi: f64) {
        if !self.is_of(phi) {
            self.turn(p, phi);
        }
    }

    #[cold]
    #[inline(never)]
    fn turn(&mut self, p: &Params, phi: f64) {
        let road = &p.road;
        let (r_w, weight) = (road.r_w, road.weight());
        self.phi = phi;
        self.climb = r_w * weight * ComplexField::sin(phi);
        self.level = r_w * weight * ComplexField::cos(phi);
        self.drag = road.drag();
        self.roll = self.level * road.c_rr;
        self.sharpness = r_w / road.v_eps;
        self.bend = self.roll * self.sharpness * self.sharpness + 2.0 * self.drag;
        self.fast = SATURATED * road.v_eps / r_w;
        self.plain = road.v_eps > 0.0 && !p.friction_varies();
    }

    /// Load where the wheels turn at `omega_w` [rad/s], V_ε > 0, with its slope: see [`RoadParams::smooth_load`].
    #[inline(always)]
    pub(crate) fn travel(&mut self, omega_w: f64) -> (f64, f64) {
        if self.is_fast(omega_w) {
            self.fast_load(omega_w)
        } else {
            self.travel_slowly(omega_w)
        }
    }

    #[cold]
    #[inline(never)] // most speeds do not need it
    fn travel_slowly(&mut self, omega_w: f64) -> (f64, f64) {
        self.direction = tanh(self.sharpness * omega_w);
        self.slow_load(omega_w, self.direction)
    }

    /// Load where tanh of V/V_ε is `direction`.
    #[inline(always)]
    fn slow_load(&self, omega_w: f64, direction: f64) -> (f64, f64) {
        let (flow, slope) = self.flowing(omega_w);
        let roll_slope = self.roll * (1.0 - direction * direction) * self.sharpness;
        (flow + self.roll * direction, slope + roll_slope)
    }

    /// Whether the rolling resistance has all of its direction.
    #[inline(always)]
    fn is_fast(&self, omega_w: f64) -> bool {
        omega_w.abs() > self.fast
    }

    /// Load at such a speed.
    #[inline(always)]
    fn fast_load(&self, omega_w: f64) -> (f64, f64) {
        let (flow, slope) = self.flowing(omega_w);
        (flow + flipped(self.roll, omega_w), slope)
    }

    /// Ramp of T_v [N·m/s] over `t` [s] that meets its end, where the wheels stay fast and one step along the tangent's
    /// chord finds it: the parabola is above the tangent by drag Δω_w².
    ///
    /// `slope`: of T_v at the start. `held`: change of ω_w if T_v stays as it is [rad/s]. `gain`: what the ramp adds.
    #[inline(always)]
    pub(crate) fn fast_ramp(
        &self,
        omega_w: f64,
        slope: f64,
        held: f64,
        gain: f64,
        t: f64,
    ) -> Option<f64> {
        let share = 1.0 / (t - slope * gain);
        let tangent = slope * held * share;
        let change = held + gain * tangent;
        let correction = flipped(self.drag, omega_w) * change * change * share;
        let settled = (gain * correction).abs() < LOAD_SETTLED;
        let fast = omega_w.abs() - change.abs() > self.fast;
        (settled && fast).then_some(tangent + correction)
    }

    /// The same where they travel slowly and stay near, and one step of Newton's method finds the end.
    ///
    /// `here`: what [`Self::travel`] found at `omega_w`.
    #[inline(always)]
    pub(crate) fn slow_ramp(
        &self,
        omega_w: f64,
        here: (f64, f64),
        held: f64,
        gain: f64,
        t: f64,
    ) -> Option<f64> {
        let rate = here.1 / t; // before `held` is there
        let (ramp, change) = (rate * held, (1.0 + gain * rate) * held);
        let turn = self.sharpness * change;
        let tanh::Fraction { above, below } = tanh::of_sum(self.direction, turn);
        let (flow, slope) = self.flowing(omega_w + change);
        // Times `below`, and times its square: so that one division is enough.
        let missed = (flow - here.0 - ramp * t) * below + self.roll * above;
        let square = below * below;
        let slope = slope * square + self.roll * self.sharpness * (square - above * above);
        let correction = missed * below / (t * square - gain * slope);
        let moved = gain * correction;
        let settled = moved * moved * gain.abs() * self.bend < LOAD_LEFT * t;
        let near = turn.abs() <= NEAR && !self.is_fast(omega_w);
        (settled && near).then_some(ramp + correction)
    }

    /// Climb and drag [N·m], and the slope of both over ω_w [N·m·s/rad].
    #[inline(always)]
    fn flowing(&self, omega_w: f64) -> (f64, f64) {
        let drag = self.drag * omega_w.abs();
        (self.climb + drag * omega_w, drag + drag)
    }
}

/// `value`, with the other sign where `by` is negative.
#[inline(always)]
const fn flipped(value: f64, by: f64) -> f64 {
    f64::from_bits(value.to_bits() ^ by.to_bits() & (-0.0_f64).to_bits())
}

/// sgn x, 0 at 0 [1].
pub(crate) fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::{Grade, LOAD_LEFT, NEAR};
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
    fn the_smooth_load_of_a_smeared_resistance_is_all_of_it_with_its_slope() {
        let road = Params::TABLE_1.road;
        let grade = Grade::NONE.at(&Params::TABLE_1, 0.04);
        for omega_w in [-40.0, -0.1, 0.0, 0.03, 1.0, 90.0] {
            let (load, slope) = road.smooth_load(omega_w, &grade);
            assert!((load - road.load_torque(omega_w, 0.04)).abs() < 1e-9);
            assert!((slope - road.load_torque_slope(omega_w, 0.04)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_ramp_of_a_slow_load_meets_it_at_the_end() {
        let road = Params::TABLE_1.road;
        let mut grade = Grade::NONE.at(&Params::TABLE_1, 0.04);
        let (t, gain) = (1e-3, -4e-9);
        for ratio in [-19.0, -3.0, -0.3, 0.0, 0.01, 0.7, 4.0, 19.0] {
            let omega_w = ratio * road.v_eps / road.r_w;
            let here = grade.travel(omega_w);
            for turn in [-0.12, -0.05, -1e-9, 0.0, 0.02, 0.12, 0.13, 5.0_f64] {
                let held = turn * road.v_eps / road.r_w;
                let ramp = grade.slow_ramp(omega_w, here, held, gain, t);
                assert!(ramp.is_some() || turn.abs() > 0.06, "{ratio} {turn}");
                assert!(ramp.is_none() || turn.abs() < NEAR, "{ratio} {turn}");
                let Some(ramp) = ramp else { continue };
                let (end, _) = road.smooth_load(omega_w + held + gain * ramp, &grade);
                let left = gain * (here.0 + ramp * t - end) / t;
                assert!(left.abs() < LOAD_LEFT, "{ratio} {turn}: {left} rad/s");
            }
        }
        let fast = 20.0 * road.v_eps / road.r_w;
        let here = grade.travel(fast);
        assert_eq!(grade.slow_ramp(fast, here, 0.0, gain, t), None);
    }

    #[test]
    fn dry_rolling_resistance_is_what_the_smooth_load_lacks() {
        let mut p = Params::TABLE_1;
        p.road.v_eps = 0.0;
        let (road, grade) = (p.road, Grade::NONE.at(&p, 0.03));
        let (fast, dry) = (20.0, road.dry_rolling() * grade.level);
        assert!(dry > 0.0 && Params::TABLE_1.road.dry_rolling() == 0.0);
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
