//! The noise of the speeds, as the innovations of `calibrating` tell it.
//!
//! A filter that takes quiet speeds for noisy ones trusts its model for too long, and what is wrong with its parameters
//! stays in its torques. Innovations ν have the noise of the speeds and all that the model lacks:
//!
//! ```text
//! σ̂² = mean of ν² over 0.1 s        σ = σ̂, but at least 0.2 of what is believed and at most all of it
//! ```
//!
//! In a handover σ is what is believed: clutches break away from one sample to the next, and the engine swings against
//! the damper behind them, which is no state of the filter while they slip. Nor is σ less than what inputs that are held
//! over a step miss, a few N·m on J_e: at 100 Hz that is all of it. Speeds that are counted have passed a filter
//! ([`encoder`](crate::observer::encoder)): what is left of their noise is not white, and innovations do not show it.

use crate::Params;
use crate::observer::phase::pressed;
use crate::observer::{Sample, Settings, Visit};
use nalgebra::ComplexField;

/// Time constant of the mean [s].
const MEMORY: f64 = 0.1;
/// Least part of the deviation of a speed that is believed [1].
const QUIET: f64 = 0.2;
/// Acceleration that inputs held over a step miss [rad/s²].
const HELD: f64 = 10.0;
/// Innovation beyond which it is a fault and no noise, as a multiple of what is believed [1].
const LOUD: f64 = 10.0;

/// What was heard.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Heard {
    /// σ̂² of a measured speed [(rad/s)²].
    pub variance: f64,
}

impl Heard {
    /// Nothing heard yet: the deviation that is believed [rad/s].
    pub fn new(believed: f64) -> Self {
        Self {
            variance: believed * believed,
        }
    }

    /// Deviation of a speed in a sample `h` [s] after the last one [rad/s].
    pub fn sensor(&self, p: &Params, settings: &Settings, sample: &Sample, h: f64) -> f64 {
        let believed = settings.calibrating.sensor;
        if pressed(p, sample) == [true; 2] || settings.encoder != [0.0; 4] {
            return believed;
        }
        let least = (QUIET * believed).max(HELD * h).min(believed);
        ComplexField::sqrt(self.variance).clamp(least, believed)
    }

    /// Deviation of a speed over the one that is `believed` [1], in handovers and of counted speeds as well.
    pub fn quiet(&self, believed: f64) -> f64 {
        (ComplexField::sqrt(self.variance) / believed).clamp(QUIET, 1.0)
    }

    /// Hears the innovations of ω_e, ω_o, ω_w [rad/s], shape (3); that of ω_o is of both input shafts, g ω_o.
    pub fn listen(&mut self, g: [f64; 2], innovation: [f64; 3], believed: f64, h: f64) {
        let ([one, two], [e, o, w]) = (g, innovation);
        let mean = (e * e + o * o * (one * one + two * two) + w * w) / 3.0;
        let most = LOUD * believed;
        self.variance += (mean.min(most * most) - self.variance) * (h / (h + MEMORY));
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        visit(&mut self.variance);
    }
}

#[cfg(test)]
mod tests {
    use super::Heard;
    use crate::Params;
    use crate::observer::{Sample, Settings};
    use crate::params::Actuation;

    const BELIEVED: f64 = 0.1;
    const H: f64 = 1e-3;

    fn sample(positions: [f64; 2]) -> Sample {
        Sample {
            gear: [1, 2],
            actuation: positions.map(|position| Actuation {
                position,
                pressure: 0.0,
            }),
            ..Sample::default()
        }
    }

    /// Deviation after 1000 innovations of `size` [rad/s] at every sensor, of which both input shafts tell ω_o.
    fn after(size: f64, positions: [f64; 2], h: f64) -> f64 {
        let (p, mut heard) = (Params::TABLE_1, Heard::new(BELIEVED));
        let g = p.g([1, 2]);
        let o = size / f64::hypot(g[0], g[1]);
        for _ in 0..1000 {
            heard.listen(g, [size, -o, size], BELIEVED, h);
        }
        heard.sensor(&p, &Settings::CASE_1, &sample(positions), h)
    }

    #[test]
    fn noise_is_heard_between_a_fifth_of_what_is_believed_and_all_of_it() {
        for (size, expected) in [(0.0, 0.02), (0.05, 0.05), (0.3, 0.1)] {
            let told = after(size, [5e-3, 0.0], H);
            assert!((told - expected).abs() < 1e-4, "{size}: {told} rad/s");
        }
    }

    /// A square that is infinite included.
    #[test]
    fn a_sample_that_is_no_speed_deafens_for_half_a_second() {
        let (p, mut heard) = (Params::TABLE_1, Heard::new(BELIEVED));
        let clutch_1 = sample([5e-3, 0.0]);
        heard.listen([12.0, 7.0], [1e300, 0.0, 0.0], BELIEVED, H);
        for _ in 0..500 {
            heard.listen([12.0, 7.0], [0.0; 3], BELIEVED, H);
        }
        let told = heard.sensor(&p, &Settings::CASE_1, &clutch_1, H);
        assert!((told - 0.02).abs() < 1e-9);
    }

    #[test]
    fn in_a_handover_and_over_long_steps_it_is_what_is_believed() {
        assert_eq!(after(0.0, [5e-3, 5e-3], H), BELIEVED);
        assert_eq!(after(0.0, [5e-3, 0.0], 1e-2), BELIEVED);
        assert!((after(0.0, [5e-3, 0.0], 5e-3) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn counted_speeds_are_as_noisy_as_their_filter_says() {
        let counted = Settings {
            encoder: [0.0, 0.0, 0.0, 1024.0],
            ..Settings::CASE_1
        };
        let told = Heard::default().sensor(&Params::TABLE_1, &counted, &sample([5e-3, 0.0]), H);
        assert_eq!(told, BELIEVED);
    }
}
