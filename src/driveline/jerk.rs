//! Jerk of the vehicle through a defined filter, and the acceleration it belongs to.
//!
//! The vehicle speed V passes two low-passes of one time constant τ:
//!
//! V1' = (V − V1)/τ,  V2' = (V1 − V2)/τ
//!
//! so V2' = (V1 − V2)/τ is dV/dt behind both of them, and its derivative
//!
//! j = (V − 2 V1 + V2)/τ²
//!
//! is the jerk through 1/(1 + τ s)². Both need no acceleration, which jumps with every torque, so they are
//! functions of states. Over a step V goes straight from its start to its end, for which the two filters
//! are solved exactly: second order in the step, stable at any step.
//!
//! ```
//! use dct_driveline::jerk::JerkFilter;
//!
//! let (mut filter, h, tau) = (JerkFilter::at(0.0), 1e-3, 0.02);
//! let speed = |k: i32| (f64::from(k) * h).powi(2); // acceleration 2 t
//! for k in 0..1000 {
//!     filter.advance(speed(k), speed(k + 1), h, tau);
//! }
//! assert!((filter.jerk(speed(1000), tau) - 2.0).abs() < 1e-3);
//! ```

use nalgebra::ComplexField;

/// V1 and V2 with what a step of the last length needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkFilter {
    /// V1, V2 [m/s], shape (2).
    pub state: [f64; 2],
    step: Step,
}

/// What a step of one length makes of the filters.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    /// h/τ.
    ratio: f64,
    /// exp(−h/τ): what is left of where V1 was.
    decay: f64,
    /// How far V1 and V2 stay behind V, for its change over the step; shape (2).
    lag: [f64; 2],
}

impl Step {
    /// No step.
    const NONE: Self = Self {
        ratio: 0.0,
        decay: 1.0,
        lag: [0.0; 2],
    };

    #[cold]
    #[inline(never)]
    fn new(ratio: f64) -> Self {
        let decay = ComplexField::exp(-ratio);
        let first = (1.0 - decay) / ratio;
        Self {
            ratio,
            decay,
            lag: [first, 2.0 * first - decay],
        }
    }
}

impl JerkFilter {
    /// The filter of a vehicle that has long had speed `v` [m/s].
    pub const fn at(v: f64) -> Self {
        Self {
            state: [v, v],
            step: Step::NONE,
        }
    }

    /// Follows the vehicle over a step.
    ///
    /// `v`, `v_end`: speed at the start and the end of the step [m/s]. `h`: step [s]. `tau`: τ [s], > 0.
    pub fn advance(&mut self, v: f64, v_end: f64, h: f64, tau: f64) {
        let ratio = h / tau;
        if self.step.ratio != ratio {
            self.step = Step::new(ratio);
        }
        let Step { decay, lag, .. } = self.step;
        let ([first, second], change) = (self.state.map(|filtered| filtered - v), v_end - v);
        self.state = [
            v_end + first * decay - change * lag[0],
            v_end + (second + first * ratio) * decay - change * lag[1],
        ];
    }

    /// j [m/s³].
    ///
    /// `v`: speed at the end of the last step [m/s]. `tau`: τ [s].
    pub const fn jerk(&self, v: f64, tau: f64) -> f64 {
        (v - 2.0 * self.state[0] + self.state[1]) / (tau * tau)
    }

    /// dV/dt through the same filter [m/s²]; its own derivative is [`Self::jerk`].
    ///
    /// `tau`: τ [s].
    pub const fn acceleration(&self, tau: f64) -> f64 {
        (self.state[0] - self.state[1]) / tau
    }

    /// dj/dt = (dV/dt − 2 V1' + V2')/τ² [m/s⁴].
    ///
    /// `v`: speed [m/s]. `acceleration`: dV/dt [m/s²], not filtered. `tau`: τ [s].
    pub const fn jerk_rate(&self, v: f64, acceleration: f64, tau: f64) -> f64 {
        let first = (v - self.state[0]) / tau;
        (acceleration - 2.0 * first + self.acceleration(tau)) / (tau * tau)
    }
}

#[cfg(test)]
mod tests {
    use super::{JerkFilter, Step};

    const TAU: f64 = 0.02;

    /// Largest errors over 1 s of V = sin ω t in so many steps, past the transient.
    fn errors(steps: u32, omega: f64) -> [f64; 2] {
        let mut filter = JerkFilter::at(0.0);
        let h = 1.0 / f64::from(steps);
        let (mut worst, gain) = ([0.0_f64; 2], 1.0 / (1.0 + (omega * TAU).powi(2)));
        for k in 0..steps {
            let (start, end) = (f64::from(k) * h, f64::from(k + 1) * h);
            let v = (omega * end).sin();
            filter.advance((omega * start).sin(), v, h, TAU);
            // through 1/(1 + i ω τ)²: amplitude times gain, phase less twice atan ω τ
            let phase = omega * end - 2.0 * (omega * TAU).atan();
            let (a, j) = (
                omega * gain * phase.cos(),
                -omega * omega * gain * phase.sin(),
            );
            if end > 0.5 {
                worst[0] = worst[0].max((filter.acceleration(TAU) - a).abs() / omega);
                worst[1] = worst[1].max((filter.jerk(v, TAU) - j).abs() / omega.powi(2));
            }
        }
        worst
    }

    #[test]
    fn the_filter_is_that_of_its_formula() {
        for omega in [5.0, 50.0, 200.0] {
            let [acceleration, jerk] = errors(100_000, omega);
            assert!(
                acceleration < 1e-5 && jerk < 1e-5,
                "{omega} rad/s: {acceleration} {jerk}"
            );
        }
    }

    #[test]
    fn a_step_is_of_second_order() {
        for (coarse, fine) in errors(1000, 60.0).into_iter().zip(errors(10_000, 60.0)) {
            assert!((80.0..120.0).contains(&(coarse / fine)), "{coarse} {fine}");
        }
    }

    #[test]
    fn rates_are_those_of_differences() {
        let (v, slope, h) = (|t: f64| 3.0 + 2.0 * t, 2.0, 1e-6);
        let mut filter = JerkFilter {
            state: [2.9, 2.7],
            step: Step::NONE,
        };
        let before = (filter.acceleration(TAU), filter.jerk(v(0.0), TAU));
        let rates = (before.1, filter.jerk_rate(v(0.0), slope, TAU));
        filter.advance(v(0.0), v(h), h, TAU);
        let found = (
            (filter.acceleration(TAU) - before.0) / h,
            (filter.jerk(v(h), TAU) - before.1) / h,
        );
        // One-sided differences over h/τ = 5e-5.
        assert!(
            (found.0 - rates.0).abs() < 1e-3 * rates.0.abs(),
            "{found:?} {rates:?}"
        );
        assert!(
            (found.1 - rates.1).abs() < 1e-3 * rates.1.abs(),
            "{found:?} {rates:?}"
        );
    }

    #[test]
    fn a_steady_vehicle_has_no_jerk_at_any_step() {
        let mut filter = JerkFilter::at(12.5);
        for h in [1e-6, 1e-3, 1.0] {
            filter.advance(12.5, 12.5, h, TAU);
            assert_eq!(
                (filter.jerk(12.5, TAU), filter.acceleration(TAU)),
                (0.0, 0.0)
            );
        }
    }
}
