//! Speeds that leap: single samples that are wrong.
//!
//! Inertia bounds how far a speed goes in a step. A reading beyond that, as a glitch of a bus or of a sensor makes it,
//! is not believed: the speed goes on as it did for a step and is held there, until the readings are back within
//!
//! ```text
//! |ω − ω_held| ≤ Δ + a h + a' t_held + Δ_tick        t_held: time held so far; a = 0 of a reading that is exactly 0
//! ```
//!
//! or have been beyond it for 20 ms: what stays is no glitch, and [`monitor`](super::monitor) says what is wrong with
//! it. a' is larger than a, so that a motion which really is faster than a is believed one step late, and a wrong sample
//! has but one step to be within the limit. Not held are the first sample after a start, a shaft on its way to the speed
//! of a gear that is coming in ([`shift`](super::shift)), and ticks of an encoder that is told, known, or that there may
//! be: Δ_tick = 2 · 2π/(n h), n a whole number ([`encoder`](super::encoder)).
//!
//! **Proof: none**, that a reading within the limit is right; a speed within it passes by every bit.
//!
//! ```
//! use dct_driveline::observer::{Sample, leap::Leaps};
//!
//! let at = |omega_e: f64| Sample { omega_e, ..Sample::default() };
//! let mut leaps = Leaps::default();
//! leaps.start(&at(150.0));
//! assert!(leaps.step(&at(150.1), 1e-3, || [0.0; 4]).is_none());
//! let held = leaps.step(&at(0.0), 1e-3, || [0.0; 4]).unwrap();
//! assert!((held.omega_e - 150.2).abs() < 1e-9);
//! assert!(leaps.step(&at(150.3), 1e-3, || [0.0; 4]).is_none());
//! ```

use crate::observer::{SPEEDS, Sample, Visit, lasting};

/// Δ: what noise may move a speed by between two samples [rad/s]: seven deviations where sensors are noisy by 0.1 rad/s.
const NOISE: f64 = 1.0;
/// a of ω_e, ω_c1, ω_c2, ω_w [rad/s²]: the fastest of our drives has 980 on an input shaft and 7 on the wheels.
const FAST: [f64; SPEEDS] = [1e3, 1e3, 1e3, 1e2];
/// a' of the same [rad/s²]. A motion of a'/2 is believed with its second sample: 1000 N·m on an engine of 0.2 kg·m².
const FASTER: [f64; SPEEDS] = [1e4, 1e4, 1e4, 1e3];
/// Time for which a speed is held [s].
pub const LONGEST: f64 = lasting(0.02);

/// The speeds that are believed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Leaps {
    /// ω_e, ω_c1, ω_c2, ω_w believed last [rad/s], shape (4).
    last: [f64; SPEEDS],
    /// Those of the sample before [rad/s], shape (4).
    before: [f64; SPEEDS],
    /// The step from there [s]; 0 if there is none.
    h: f64,
    /// Time for which each has been held [s], shape (4).
    held: [f64; SPEEDS],
}

impl Leaps {
    /// At a first sample. The next one is believed whatever it is: the first may be a start value.
    pub fn start(&mut self, sample: &Sample) {
        *self = Self {
            last: sample.speeds(),
            before: sample.speeds(),
            h: 0.0,
            held: [LONGEST; SPEEDS],
        };
    }

    /// The sample `h` [s] after the last one with the speeds that are held; nothing if none is.
    ///
    /// Speeds that are no numbers, or a step that is none, change nothing.
    ///
    /// `freedom`: by how much more each speed may leap [rad/s], shape (4); asked for where one does.
    pub fn step(
        &mut self,
        sample: &Sample,
        h: f64,
        freedom: impl FnOnce() -> [f64; SPEEDS],
    ) -> Option<Sample> {
        let now = sample.speeds();
        let passes = h > 0.0 && h < f64::INFINITY;
        let steady = (0..SPEEDS).fold(passes, |steady, j| {
            steady & ((now[j] - self.last[j]).abs() <= reach(now[j], j, h))
        });
        if steady {
            (self.before, self.h) = (self.last, h);
            (self.last, self.held) = (now, [0.0; SPEEDS]);
            return None;
        }
        self.hold(sample, h, freedom())
    }

    #[cold]
    #[inline(never)]
    fn hold(&mut self, sample: &Sample, h: f64, freedom: [f64; SPEEDS]) -> Option<Sample> {
        if !sample.may_enter(h) {
            return None;
        }
        let now = sample.speeds();
        let last = self.last;
        for j in 0..SPEEDS {
            let far = reach(now[j], j, h) + FASTER[j] * self.held[j] + freedom[j];
            let leaps = (now[j] - self.last[j]).abs() > far;
            if leaps && self.held[j] < LONGEST {
                if self.held[j] == 0.0 && self.h > 0.0 {
                    self.last[j] += (last[j] - self.before[j]) / self.h * h;
                }
                self.held[j] += h;
            } else {
                (self.last[j], self.held[j]) = (now[j], 0.0);
            }
        }
        (self.before, self.h) = (last, h);
        self.holds().then(|| sample.with_speeds(self.last))
    }

    /// Some speed is held.
    pub fn holds(&self) -> bool {
        self.held != [0.0; SPEEDS]
    }

    /// Time for which ω_e, ω_c1, ω_c2, ω_w have been held [s], and at what [rad/s], shapes (4).
    pub fn held(&self) -> [[f64; SPEEDS]; 2] {
        [self.held, self.last]
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            last,
            before,
            h,
            held,
        } = self;
        let rows = last.iter_mut().chain(before).chain(held);
        rows.chain([h]).for_each(visit);
    }
}

/// How far speed `j` goes to a `reading` in `h` [s] [rad/s].
///
/// What reads exactly 0 came to rest, slowly, or is not there.
fn reach(reading: f64, j: usize, h: f64) -> f64 {
    let a = if reading == 0.0 { 0.0 } else { FAST[j] };
    NOISE + a * h
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Leaps};
    use crate::observer::{SPEEDS, Sample};

    const H: f64 = 1e-3;

    fn at(speeds: [f64; SPEEDS]) -> Sample {
        Sample::default().with_speeds(speeds)
    }

    /// Steps of 1 ms for which a speed `j` is held that leaps from 100 rad/s and then goes by `readings` [rad/s].
    fn held(j: usize, freedom: f64, readings: impl Iterator<Item = f64>) -> usize {
        let mut leaps = Leaps::default();
        let mut speeds = [100.0; SPEEDS];
        leaps.start(&at(speeds));
        assert!(leaps.step(&at(speeds), H, || [0.0; SPEEDS]).is_none());
        let is_held = |reading: &f64| {
            speeds[j] = *reading;
            let believed = leaps.step(&at(speeds), H, || [freedom; SPEEDS]);
            assert_eq!(believed.is_some(), leaps.holds());
            believed.is_some()
        };
        readings.take_while(is_held).count()
    }

    #[test]
    fn what_leaps_and_stays_is_believed_after_20_ms_and_what_comes_back_at_once() {
        for j in 0..SPEEDS {
            assert_eq!(held(j, 0.0, [1e4; 50].into_iter()), 20, "speed {j}");
            assert_eq!(held(j, 0.0, [0.0, 0.0, 100.1].into_iter()), 2, "speed {j}");
            assert_eq!(held(j, 99.0, [0.0].into_iter()), 0, "speed {j}");
        }
    }

    /// A steady acceleration [rad/s²] from one sample to the next, of an engine and of the wheels.
    #[test]
    fn a_motion_is_believed_at_once_or_a_step_late() {
        for (j, acceleration, late) in [(0, 1.9e3, 0), (0, 2.1e3, 1), (0, 5e3, 1), (3, 1e3, 0)] {
            let readings = (1..).map(|k| 100.0 + acceleration * H * f64::from(k));
            assert_eq!(held(j, 0.0, readings.take(50)), late, "{j}: {acceleration}");
        }
    }

    /// One wrong sample of speeds that rise steadily, with steps [s] that differ.
    #[test]
    fn a_speed_goes_on_as_it_did_for_a_step() {
        let line = |time: f64| at([90.0 + 64.0 * time; SPEEDS]);
        let mut leaps = Leaps::default();
        leaps.start(&line(0.0));
        let mut time = 0.0;
        for (h, wrong) in [(H, false), (H, false), (4.0 * H, true), (H, false)] {
            time += h;
            let sample = if wrong { at([0.0; SPEEDS]) } else { line(time) };
            let believed = leaps.step(&sample, h, || [0.0; SPEEDS]);
            assert_eq!(believed.is_some(), wrong, "{time} s");
            let missed = believed.map(|sample| sample.omega_w - line(time).omega_w);
            assert!(
                missed.is_none_or(|missed| missed.abs() < 1e-12),
                "{missed:?}"
            );
        }
    }

    /// 5 rad/s within 10 ms are believed, but not of a speed that is nothing then.
    #[test]
    fn a_speed_does_not_leap_to_nothing() {
        for (reading, held) in [(0.0, true), (1e-9, false)] {
            let mut leaps = Leaps::default();
            leaps.start(&at([5.0; SPEEDS]));
            assert!(
                leaps
                    .step(&at([5.0; SPEEDS]), 1e-2, || [0.0; SPEEDS])
                    .is_none()
            );
            let sample = Sample {
                omega_e: reading,
                ..at([5.0; SPEEDS])
            };
            assert_eq!(leaps.step(&sample, 1e-2, || [0.0; SPEEDS]).is_some(), held);
        }
    }

    #[test]
    fn the_first_sample_after_a_start_is_believed() {
        let mut leaps = Leaps::default();
        leaps.start(&at([0.0; SPEEDS]));
        assert!(
            leaps
                .step(&at([90.0; SPEEDS]), H, || [0.0; SPEEDS])
                .is_none()
        );
        assert!(
            leaps
                .step(&at([0.0; SPEEDS]), H, || [0.0; SPEEDS])
                .is_some()
        );
    }

    /// Neither a number that is none nor a step that is none moves what is believed.
    #[test]
    fn a_sample_that_may_not_enter_leaves_everything_as_it_was() {
        let mut leaps = Leaps::default();
        leaps.start(&at([90.0; SPEEDS]));
        assert!(
            leaps
                .step(&at([90.0; SPEEDS]), H, || [0.0; SPEEDS])
                .is_none()
        );
        let before = leaps;
        for (speed, h) in [
            (91.0, f64::INFINITY),
            (91.0, 0.0),
            (f64::NAN, H),
            (f64::INFINITY, H),
            (0.0, f64::NAN),
            (0.0, -H),
        ] {
            assert!(
                leaps
                    .step(&at([speed; SPEEDS]), h, || [0.0; SPEEDS])
                    .is_none()
            );
            assert_eq!(leaps, before, "{speed} rad/s, {h} s");
        }
    }

    /// However long the step, a single sample is held.
    #[test]
    fn a_single_sample_is_held_at_any_step() {
        for h in [1e-4, H, 1e-2, LONGEST, 0.02] {
            let mut leaps = Leaps::default();
            leaps.start(&at([900.0; SPEEDS]));
            for (speed, held) in [(900.0, false), (0.0, true), (900.0, false)] {
                let believed = leaps.step(&at([speed; SPEEDS]), h, || [0.0; SPEEDS]);
                let expected = held.then(|| at([900.0; SPEEDS]));
                assert_eq!(believed, expected, "{h} s");
            }
        }
    }
}
