//! The noise of the speeds, as the innovations of `calibrating` tell it.
//!
//! A filter that takes quiet speeds for noisy ones trusts its model for too long, and what is wrong with its parameters
//! stays in its torques. Innovations ν have the noise of the speeds and all that the model lacks:
//!
//! ```text
//! σ̂² = mean of ν² over 0.1 s        σ = σ̂, but at least 0.2 of what is believed and at most all of it
//! ```
//!
//! In a handover σ of engine and gearbox is what is believed: clutches break away from one sample to the next, and the
//! engine swings against the damper behind them, which is no state of the filter while they slip. The wheels, behind the
//! drive shaft, feel none of it, and σ of ω_w is the mean of its own ν² alone. How well the torque of the drive shaft
//! is known after the handover rests on it: its change is k_o ∫ (ω_o − ω_w) dt, and ω_o is measured by two shafts that turn
//! g times as fast. Nor is σ less than what inputs that are held
//! over a step miss, a few N·m on J_e: at 100 Hz that is all of it. Speeds that are counted have passed a filter
//! ([`encoder`](crate::observer::encoder)): what is left of their noise is not white, and innovations do not show it.

use crate::observer::instant::Instant;
use crate::observer::{Settings, Visit, within};
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
    /// σ̂² of a measured speed, and of ω_w by itself [(rad/s)²], shape (2).
    pub variance: [f64; 2],
}

impl Heard {
    /// Nothing heard yet: the deviation that is believed [rad/s].
    pub fn new(believed: f64) -> Self {
        Self {
            variance: [believed * believed; 2],
        }
    }

    /// Deviations of ω_e, ω_c1, ω_c2 and of ω_w in a sample `h` [s] after the last one [rad/s], shape (2).
    pub fn sensor(&self, settings: &Settings, now: &Instant<'_>, h: f64) -> [f64; 2] {
        let believed = settings.calibrating.sensor;
        if settings.encoder != [0.0; 4] {
            return [believed; 2];
        }
        let least = (QUIET * believed).max(HELD * h).min(believed);
        let [speed, wheel] = self
            .variance
            .map(|heard| within(ComplexField::sqrt(heard), least, believed));
        if now.pressed() == [true; 2] {
            return [believed, wheel];
        }
        [speed; 2]
    }

    /// Deviation of a speed over the one that is `believed` [1], in handovers and of counted speeds as well.
    pub fn quiet(&self, believed: f64) -> f64 {
        let [speed, _] = self.variance;
        (ComplexField::sqrt(speed) / believed).clamp(QUIET, 1.0)
    }

    /// Hears the innovations of ω_e, ω_o, ω_w [rad/s], shape (3); that of ω_o is of both input shafts, g ω_o.
    pub fn listen(&mut self, g: [f64; 2], innovation: [f64; 3], believed: f64, h: f64) {
        let ([one, two], [e, o, w]) = (g, innovation);
        let mean = (e * e + o * o * (one * one + two * two) + w * w) / 3.0;
        let most = LOUD * believed;
        for (heard, square) in self.variance.iter_mut().zip([mean, w * w]) {
            *heard += (square.min(most * most) - *heard) * (h / (h + MEMORY));
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { variance } = self;
        variance.iter_mut().for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::Heard;
    use crate::Params;
    use crate::observer::instant::Instant;
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

    /// Deviations after 1000 innovations of `size` [rad/s] at every sensor, of which both input shafts tell ω_o.
    fn after(size: f64, positions: [f64; 2], h: f64) -> [f64; 2] {
        let (p, mut heard) = (Params::TABLE_1, Heard::new(BELIEVED));
        let g = p.g([1, 2]);
        let o = size / f64::hypot(g[0], g[1]);
        for _ in 0..1000 {
            heard.listen(g, [size, -o, size], BELIEVED, h);
        }
        heard.sensor(&Settings::CASE_1, &Instant::new(&p, &sample(positions)), h)
    }

    #[test]
    fn noise_is_heard_between_a_fifth_of_what_is_believed_and_all_of_it() {
        for (size, expected) in [(0.0, 0.02), (0.05, 0.05), (0.3, 0.1)] {
            for told in after(size, [5e-3, 0.0], H) {
                assert!((told - expected).abs() < 1e-4, "{size}: {told} rad/s");
            }
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
        let [told, wheel] = heard.sensor(&Settings::CASE_1, &Instant::new(&p, &clutch_1), H);
        assert!((told - 0.02).abs() < 1e-9 && wheel == told);
    }

    #[test]
    fn over_long_steps_it_is_what_is_believed() {
        assert_eq!(after(0.0, [5e-3, 0.0], 1e-2), [BELIEVED; 2]);
        assert_eq!(after(0.0, [5e-3, 5e-3], 1e-2), [BELIEVED; 2]);
        assert!((after(0.0, [5e-3, 0.0], 5e-3)[0] - 0.05).abs() < 1e-4);
    }

    #[test]
    fn in_a_handover_only_the_wheel_is_heard_and_by_itself() {
        let quiet = after(0.0, [5e-3, 5e-3], H);
        assert!(
            quiet[0] == BELIEVED && (quiet[1] - 0.02).abs() < 1e-9,
            "{quiet:?}"
        );
        let (p, mut heard) = (Params::TABLE_1, Heard::new(BELIEVED));
        for _ in 0..1000 {
            heard.listen(p.g([1, 2]), [0.3, 0.1, 0.05], BELIEVED, H);
        }
        let told = heard.sensor(
            &Settings::CASE_1,
            &Instant::new(&p, &sample([5e-3, 5e-3])),
            H,
        );
        assert!(
            told[0] == BELIEVED && (told[1] - 0.05).abs() < 1e-4,
            "{told:?}"
        );
    }

    #[test]
    fn counted_speeds_are_as_noisy_as_their_filter_says() {
        let counted = Settings {
            encoder: [0.0, 0.0, 0.0, 1024.0],
            ..Settings::CASE_1
        };
        let sample = sample([5e-3, 0.0]);
        let told = Heard::default().sensor(&counted, &Instant::new(&Params::TABLE_1, &sample), H);
        assert_eq!(told, [BELIEVED; 2]);
    }
}
