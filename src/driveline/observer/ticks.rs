//! How many ticks an encoder has, from the speeds that it gives.
//!
//! A speed counted over a step is a whole number of ticks in it, ω h = n 2π/N, exact but for rounding. So the angle of a
//! tick is the greatest common divisor of all |ω h|, by Euclid's algorithm, and N is a whole number. A speed that is not
//! counted has none: the divisor falls below that of any coarse encoder with its second or third sample, and from then on
//! nothing more is asked.
//!
//! A divisor alone proves little: a script may hold round numbers, and a bus rounds speeds as well. But counting rounds
//! the angle, not the speed, so a steady speed is told by n and n + 1 in turn, and a speed that falls again as it rose,
//! by a tick, within a few steps does so against any inertia. It takes [`ENOUGH`] such turns; beside an encoder that was
//! recognised a whole N will do, so that a wheel is known with its first tick.
//!
//! Ticks finer than the noise that every method bears are left alone: 2π/(N h) < √6 · 0.1 rad/s. A speed that is rounded
//! that coarsely *and* noisy would be taken for a counted one, which smooths it; to tell a very fine encoder undoes it.

use crate::observer::Visit;
use core::f64::consts::TAU;
use nalgebra::ComplexField;

/// Speed of one tick in a step from which it is worth knowing [rad/s]: its error q/√6 is a noise of 0.1 rad/s.
const COARSE: f64 = 0.25;
/// Part of a tick by which a multiple may be missed [1]: rounding.
const ROUNDING: f64 = 1e-6;
/// Part of one by which the number of ticks may miss a whole number [1].
const WHOLE: f64 = 1e-3;
/// Turns of a speed that is counted.
const ENOUGH: f64 = 20.0;
/// Divisor of a speed that is not counted.
const NONE: f64 = -1.0;

/// What is known of one encoder.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ticks {
    /// Divisor of all angles so far [rad]; 0 before the first, negative if there is none.
    tick: f64,
    /// The last reading [rad/s].
    pub last: f64,
    /// Its last change [rad/s].
    change: f64,
    /// Turns since the divisor is what it is [1], at most those that it takes.
    turns: f64,
}

impl Ticks {
    /// At a first reading [rad/s], over a step that is not known.
    pub fn at(reading: f64) -> Self {
        Self {
            last: reading,
            ..Self::default()
        }
    }

    /// Takes the next `reading` [rad/s], counted over `h` [s] if it is; `beside`: another encoder was recognised.
    pub fn step(&mut self, reading: f64, h: f64, beside: bool) {
        if self.is_none() {
            return;
        }
        self.divide((reading * h).abs(), COARSE * h);
        self.turn(reading);
        if beside && self.whole().is_some() {
            self.turns = ENOUGH;
        }
    }

    /// Angle of a tick [rad] if a `reading` [rad/s] over `h` [s] is counted, as all before it may have been.
    pub fn tick_with(mut self, reading: f64, h: f64) -> Option<f64> {
        self.step(reading, h, false);
        self.whole().map(|ticks| TAU / ticks)
    }

    /// The speed is not counted, for all that will come.
    pub fn is_none(&self) -> bool {
        self.tick < 0.0
    }

    /// Ticks per revolution, once they are known.
    pub fn known(&self) -> Option<f64> {
        self.whole().filter(|_| self.turns >= ENOUGH)
    }

    /// Ticks per revolution by the divisor, if they are whole.
    fn whole(&self) -> Option<f64> {
        if self.tick <= 0.0 {
            return None;
        }
        let ticks = TAU / self.tick;
        let whole = ComplexField::round(ticks);
        ((ticks - whole).abs() < WHOLE).then_some(whole)
    }

    /// The divisor of all angles, `angle` [rad] included, if it is not below the `least` one [rad].
    fn divide(&mut self, angle: f64, least: f64) {
        if angle == 0.0 {
            return;
        }
        if self.tick == 0.0 {
            self.tick = angle;
        }
        let mut rest = remainder(angle, self.tick);
        while self.tick >= least && rest > ROUNDING * self.tick {
            (self.tick, rest) = (rest, remainder(self.tick, rest));
            self.turns = 0.0;
        }
        if self.tick < least {
            (self.tick, self.turns) = (NONE, 0.0);
        }
    }

    /// Counts a reading that goes back from where the last one went.
    fn turn(&mut self, reading: f64) {
        let change = reading - self.last;
        if change * self.change < 0.0 {
            self.turns = (self.turns + 1.0).min(ENOUGH);
        }
        if change != 0.0 {
            (self.last, self.change) = (reading, change);
        }
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            tick,
            last,
            change,
            turns,
        } = self;
        for value in [tick, last, change, turns] {
            visit(value);
        }
    }
}

/// What is missing from `angle` to the nearest multiple of `tick` [rad].
fn remainder(angle: f64, tick: f64) -> f64 {
    (angle - ComplexField::round(angle / tick) * tick).abs()
}

#[cfg(test)]
mod tests {
    use super::Ticks;
    use core::f64::consts::TAU;

    const H: f64 = 1e-3;

    /// Ticks found in 3 s of readings [rad/s] that follow the time [s], and when [s].
    fn found(h: f64, reading: impl Fn(f64) -> f64) -> Option<(f64, f64)> {
        let mut ticks = Ticks::at(reading(0.0));
        let times = (1..).map(|k| f64::from(k) * h);
        times.take_while(|time| *time < 3.0).find_map(|time| {
            ticks.step(reading(time), h, false);
            ticks.known().map(|n| (n, time))
        })
    }

    /// A speed counted by `n` ticks over `h` [s] of an angle [rad] that follows the time [s].
    fn counted(n: f64, h: f64, angle: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 {
        let tick = TAU / n;
        move |time| {
            let [before, after] = [time - h, time].map(|time| (angle(time) / tick + 1e-6).floor());
            (after - before) * tick / h
        }
    }

    /// Engine, and a wheel that starts from a standstill after 1 s.
    #[test]
    fn coarse_encoders_are_recognised() {
        let wheel = |time: f64| (time - 1.0).max(0.0).powi(2);
        for n in [60.0, 512.0, 1024.0, 4096.0, 10_000.0] {
            let engine = found(H, counted(n, H, |time| 90.0 * time + 7.0 * time * time));
            assert!(
                engine.is_some_and(|(found, time)| found == n && time < 0.5),
                "{n}: {engine:?}"
            );
        }
        let slow = found(H, counted(1024.0, H, wheel));
        assert!(slow.is_some_and(|(found, _)| found == 1024.0), "{slow:?}");
        let at_100_hz = found(1e-2, counted(256.0, 1e-2, |time| 90.0 * time));
        assert!(
            at_100_hz.is_some_and(|(found, _)| found == 256.0),
            "{at_100_hz:?}"
        );
    }

    #[test]
    fn speeds_that_are_not_counted_have_no_ticks() {
        let smooth = |time: f64| 90.0 + 20.0 * (3.0 * time).sin();
        let chatter = |time: f64| 90.0 + 0.2 * (900.0 * time).sin();
        let ramp = |time: f64| (90.0 + 30.0 * time).round();
        let rpm = |time: f64| (800.0 + 300.0 * time).round() * TAU / 60.0;
        let square = |time: f64| {
            if (500.0 * time).fract() < 0.5 {
                90.0
            } else {
                100.0
            }
        };
        let fine = counted(1e5, H, |time| 90.0 * time);
        for reading in [
            &smooth as &dyn Fn(f64) -> f64,
            &chatter,
            &ramp,
            &rpm,
            &square,
            &fine,
        ] {
            assert_eq!(found(H, reading), None);
            assert_eq!(found(1e-2, reading), None);
        }
    }

    /// The reading of a tick that is no multiple of the divisor corrects it; one of no encoder ends the search.
    #[test]
    fn a_divisor_is_corrected_and_given_up() {
        let tick = TAU / 1000.0 / H;
        let mut ticks = Ticks::at(0.0);
        let mut turning = |counts: u32| {
            for k in 0..60 {
                ticks.step(tick * f64::from(20 + counts * (k % 2)), H, false);
            }
            let known = ticks.known();
            ticks.step(if counts == 2 { tick * 21.0 } else { 0.123 }, H, false);
            (known, ticks.known())
        };
        assert_eq!(turning(2), (Some(500.0), None));
        assert_eq!(turning(1), (Some(1000.0), None));
        assert_eq!(turning(1), (None, None));
    }

    #[test]
    fn beside_an_encoder_a_wheel_is_known_with_its_first_tick_or_not_counted() {
        let tick = TAU / 1024.0 / H;
        for (first, known) in [(tick, Some(1024.0)), (1e-9, None), (0.9 * tick, None)] {
            let mut ticks = Ticks::at(0.0);
            for reading in [0.0, 0.0, first] {
                ticks.step(reading, H, true);
            }
            assert_eq!(ticks.known(), known, "{first}");
        }
    }
}
