//! Temperature of a clutch: one node that friction heats and its surroundings cool.
//!
//! ```text
//! C T' = P − G (T − T_a),   P friction power [W], C capacity [J/K], G conductance [W/K], T_a ambient or oil [K]
//! ```
//!
//! μ_k and μ_s become θ(T) times themselves, θ linear between the points of a table, constant outside.
//! Over a block of motion of length t with friction work W the power is taken as W/t, for which
//!
//! ```text
//! T(t) = T_a + (T − T_a) e^{−x} + W/C · (1 − e^{−x})/x,   x = G t/C
//! ```
//!
//! is exact: with G = 0 the node holds every joule of friction, whatever the steps.
//!
//! Deviation: the paper has no temperature; with C = 0, as in [`Thermal::OFF`], there is none.
//!
//! ```
//! use dct_driveline::thermal::Thermal;
//!
//! let lining = Thermal { capacity: 5e3, conductance: 20.0, ..Thermal::OFF };
//! assert!((lining.after(300.0, 10e3, 0.1) - 302.0).abs() < 0.01); // 10 kJ in 5 kJ/K
//! ```

use nalgebra::ComplexField;

/// Number of points of the factor over temperature.
pub const FADE_POINTS: usize = 4;

/// One thermal node, and what its temperature makes of the friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermal {
    /// C: heat capacity [J/K]; 0: there is no thermal model, the temperature stays ambient.
    pub capacity: f64,
    /// G: conductance to ambient or oil [W/K].
    pub conductance: f64,
    /// T_a: temperature of ambient or oil [K].
    pub ambient: f64,
    /// Temperature of the clutch at the start [K]; 0: that of ambient.
    pub start: f64,
    /// Temperatures of the points of θ [K], shape (FADE_POINTS), ascending strictly, or all 0: θ is 1.
    pub temperature: [f64; FADE_POINTS],
    /// θ [1], shape (FADE_POINTS), ≥ 0.
    pub factor: [f64; FADE_POINTS],
}

impl Thermal {
    /// No thermal model.
    pub const OFF: Self = Self {
        capacity: 0.0,
        conductance: 0.0,
        ambient: 293.15,
        start: 0.0,
        temperature: [0.0; FADE_POINTS],
        factor: [1.0; FADE_POINTS],
    };

    /// Whether the node is there.
    pub const fn is_on(&self) -> bool {
        self.capacity > 0.0
    }

    /// Temperature [K] at the start of a run.
    pub const fn at_start(&self) -> f64 {
        if self.is_on() && self.start > 0.0 {
            self.start
        } else {
            self.ambient
        }
    }

    /// θ [1] and dθ/dT [1/K] at a temperature [K].
    pub fn at(&self, temperature: f64) -> (f64, f64) {
        let knots = &self.temperature;
        if !self.is_on() || knots[FADE_POINTS - 1] <= 0.0 {
            return (1.0, 0.0);
        }
        let right = knots
            .iter()
            .take_while(|knot| **knot <= temperature)
            .count();
        if right == 0 || right == FADE_POINTS {
            return (self.factor[right.saturating_sub(1)], 0.0);
        }
        let left = right - 1;
        let slope = (self.factor[right] - self.factor[left]) / (knots[right] - knots[left]);
        (
            self.factor[left] + slope * (temperature - knots[left]),
            slope,
        )
    }

    /// T' [K/s] with a friction power [W].
    pub fn rate(&self, temperature: f64, power: f64) -> f64 {
        if !self.is_on() {
            return 0.0;
        }
        (power - self.conductance * (temperature - self.ambient)) / self.capacity
    }

    /// Temperature [K] after `t` [s] in which friction did `work` [J].
    pub fn after(&self, temperature: f64, work: f64, t: f64) -> f64 {
        if !self.is_on() {
            return self.ambient;
        }
        let x = self.conductance * t / self.capacity;
        let lost = -ComplexField::exp_m1(-x);
        let kept = if x > 0.0 { lost / x } else { 1.0 };
        temperature + kept * work / self.capacity - lost * (temperature - self.ambient)
    }
}

#[cfg(test)]
mod tests {
    use super::Thermal;

    const NODE: Thermal = Thermal {
        capacity: 4e3,
        conductance: 25.0,
        temperature: [300.0, 400.0, 500.0, 600.0],
        factor: [1.0, 1.0, 0.8, 0.5],
        ..Thermal::OFF
    };

    /// Heated by 3 kW from T_a for 200 s, then left alone for 300 s, in steps of any length.
    #[test]
    fn heating_and_cooling_are_the_closed_form() {
        let (time, power) = (NODE.capacity / NODE.conductance, 3e3);
        let closed = |t: f64| {
            let hot = |t: f64| power / NODE.conductance * (1.0 - (-t / time).exp());
            let rise = if t <= 200.0 {
                hot(t)
            } else {
                hot(200.0) * (-(t - 200.0) / time).exp()
            };
            NODE.ambient + rise
        };
        for (step, count) in [(0.01, 50_000_u32), (1.0, 500), (100.0, 5)] {
            let mut temperature = NODE.ambient;
            for k in 1..=count {
                let t = f64::from(k) * step;
                let power = if t <= 200.0 + 0.5 * step { power } else { 0.0 };
                temperature = NODE.after(temperature, power * step, step);
                assert!(
                    (temperature - closed(t)).abs() < 1e-8,
                    "{t} s: {temperature} K"
                );
            }
        }
    }

    #[test]
    fn the_rate_is_the_slope_of_the_motion() {
        let step = 1e-4;
        let slope = (NODE.after(450.0, 2e3 * step, step) - 450.0) / step;
        assert!((slope - NODE.rate(450.0, 2e3)).abs() < 1e-5, "{slope} K/s");
    }

    #[test]
    fn friction_fades_as_the_table_says() {
        let cases = [
            (200.0, 1.0, 0.0),
            (450.0, 0.9, -2e-3),
            (500.0, 0.8, -3e-3),
            (700.0, 0.5, 0.0),
        ];
        for (temperature, factor, slope) in cases {
            let found = NODE.at(temperature);
            assert!((found.0 - factor).abs() < 1e-12 && (found.1 - slope).abs() < 1e-12);
        }
        let off = Thermal {
            capacity: 0.0,
            ..NODE
        };
        assert_eq!(
            (off.at(700.0), off.after(700.0, 1e3, 1.0)),
            ((1.0, 0.0), off.ambient)
        );
    }
}
