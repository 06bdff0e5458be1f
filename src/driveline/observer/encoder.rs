//! Speeds from encoders: ticks counted over a step say the angle to one tick, and its slope badly.
//!
//! A tick of 2π/n turns a speed counted over h into steps of 2π/(n h): 1.5 rad/s for n = 4096 at 1 kHz. No such
//! error adds up, as what one step misses the next one counts. So the counted angle is followed, not the speed:
//!
//! ```text
//! θ' = ω,  ω' = a,  a' = white noise of intensity S;      Δθ counted = ω_measured h,  variance (2π/n)²/12
//! ```
//!
//! by a Kalman filter per sensor, on θ̂ less the counted angle, which stays within a tick. ω̂ holds for the end of
//! the step: the half step by which a count is late is made good, and a steady acceleration leaves no lag; of a
//! sudden one S lets ω̂ follow with the bandwidth
//!
//! ```text
//! ω_b = (S/(r τ))^(1/6)      r = (2π/n)²/12,  τ = 2π/(n |ω|) between ticks, at least h and at most 0.1 s
//! ```
//!
//! as the angle's error is new with each tick, not with each step. The error of ω̂, σ² = 3 ω_b³ r τ, stays for
//! 1/ω_b, so a filter that takes every sample as new has to believe σ² · 2/(ω_b h) = 6 ω_b² r τ/h.
//!
//! **Proof: of optimality** for this motion, were the error of a tick white and Gaussian; it is neither at a
//! standstill, where a sensor may move by a tick unseen.
//!
//! ```
//! use dct_driveline::observer::{Sample, Settings, encoder::Encoders};
//!
//! let settings = Settings { encoder: [4096.0; 4], ..Settings::CASE_1 };
//! let tick = core::f64::consts::TAU / 4096.0;
//! let mut encoders = Encoders::default();
//! encoders.start(&Sample::default());
//! // 10 rad/s: 6 or 7 ticks in 1 ms
//! for k in 0..200 {
//!     let [before, after] = [k, k + 1].map(|k| (f64::from(k) * 10e-3 / tick).floor());
//!     let omega_w = (after - before) * tick / 1e-3;
//!     encoders.step(&settings, &Sample { omega_w, ..Sample::default() }, 1e-3);
//! }
//! let (sample, _) = encoders.step(&settings, &Sample { omega_w: 10.0, ..Sample::default() }, 1e-3).unwrap();
//! assert!((sample.omega_w - 10.0).abs() < 0.05);
//! ```

use crate::observer::filter::Belief;
use crate::observer::monitor::PATIENCE;
use crate::observer::ticks::Ticks;
use crate::observer::{SPEEDS, Sample, Settings, Visit};
use core::f64::consts::TAU;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// S of each sensor [(rad/s²)²/s]: what clutches and drive shaft do to the acceleration of engine and input
/// shafts, and, less by the square of a low gear's ratio, to that of the wheels.
const JERK: [f64; SPEEDS] = [3000.0, 3000.0, 3000.0, 10.0];
/// Longest time between ticks that is believed [s].
const RARE: f64 = 0.1;
/// Deviation of the acceleration at the start [rad/s²].
const ACCELERATION: f64 = 30.0;
/// Step over which the speed at the start is taken as counted [s].
const STEP: f64 = 1e-3;
/// Difference from ω̂ below which a reading that stands still is taken as it is [rad/s].
const ALIKE: f64 = 0.02;

/// The encoder of one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Encoder {
    /// θ̂ less the counted angle [rad], ω̂ [rad/s], â [rad/s²].
    belief: Belief<3>,
    /// The last reading [rad/s].
    last: f64,
    /// Time for which the reading has not changed [s].
    still: f64,
}

impl Default for Encoder {
    fn default() -> Self {
        Self::at(0.0)
    }
}

impl Encoder {
    /// At a first reading [rad/s]; deviations follow with the first step.
    fn at(reading: f64) -> Self {
        Self {
            belief: Belief::new(Vector3::new(0.0, reading, 0.0), Vector3::zeros()),
            last: reading,
            still: 0.0,
        }
    }

    /// ω̂ `h` [s] after the last reading, and the deviation [rad/s] to be believed of it.
    ///
    /// `tick` [rad], `jerk`: S.
    fn step(&mut self, tick: f64, jerk: f64, reading: f64, h: f64) -> [f64; 2] {
        let r = tick * tick / 12.0;
        if self.belief.p[(0, 0)] == 0.0 {
            let speed = ComplexField::sqrt(2.0 * r) / STEP;
            let sigma = Vector3::new(ComplexField::sqrt(r), speed, ACCELERATION);
            self.belief = Belief::new(self.belief.x, sigma);
        }
        self.still = if reading == self.last {
            self.still + h
        } else {
            0.0
        };
        self.last = reading;
        self.predict(jerk, reading, h);
        let between = (tick / self.belief.x[1].abs()).min(RARE).max(h);
        let variance = r * between / h;
        let behind = -self.belief.x[0];
        self.belief.correct(&[(0, 1.0)], behind, variance);
        self.settle(reading);
        [self.belief.x[1], believed(jerk, r * between, h)]
    }

    fn predict(&mut self, jerk: f64, reading: f64, h: f64) {
        let Belief { x, p } = &mut self.belief;
        let phi = Matrix3::new(1.0, h, h * h / 2.0, 0.0, 1.0, h, 0.0, 0.0, 1.0);
        *x = phi * *x - Vector3::new(reading * h, 0.0, 0.0);
        let moved = phi * *p * phi.transpose() + noise(h) * jerk;
        *p = (moved + moved.transpose()) * 0.5;
    }

    /// A reading that stands still is the speed: it is told as it is, so that one that is frozen can be told.
    fn settle(&mut self, reading: f64) {
        let x = &mut self.belief.x;
        if self.still >= PATIENCE && (x[1] - reading).abs() < ALIKE {
            (x[1], x[2]) = (reading, 0.0);
        }
    }

    fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            belief,
            last,
            still,
        } = self;
        belief.x.iter_mut().for_each(&mut *visit);
        belief.p.iter_mut().for_each(&mut *visit);
        visit(last);
        visit(still);
    }
}

/// Covariance that an acceleration of intensity 1 brings over `h` [s], shape (3, 3).
fn noise(h: f64) -> Matrix3<f64> {
    let [h2, h3] = [h * h, h * h * h];
    let (speed, angle) = (h3 / 3.0, h2 * h3 / 20.0);
    let (mixed, slope, far) = (h2 * h2 / 8.0, h2 / 2.0, h3 / 6.0);
    Matrix3::new(
        angle, mixed, far, //
        mixed, speed, slope, //
        far, slope, h,
    )
}

/// √(6 ω_b² r τ/h) [rad/s] for r τ = `intensity` [rad² s].
fn believed(jerk: f64, intensity: f64, h: f64) -> f64 {
    let bandwidth = ComplexField::cbrt(ComplexField::sqrt(jerk / intensity));
    bandwidth * ComplexField::sqrt(6.0 * intensity / h)
}

/// The encoders of the four speeds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Encoders {
    sensors: [Encoder; SPEEDS],
    /// What the speeds tell of encoders that nobody told of.
    ticks: [Ticks; SPEEDS],
}

impl Encoders {
    /// Begins at a sample.
    pub fn start(&mut self, sample: &Sample) {
        self.sensors = sample.speeds().map(Encoder::at);
        self.ticks = sample.speeds().map(Ticks::at);
    }

    /// Ticks that were recognised in ω_e, ω_c1, ω_c2, ω_w [1], shape (4); 0 without.
    pub fn recognised(&self) -> [f64; SPEEDS] {
        self.ticks.map(|ticks| ticks.known().unwrap_or(0.0))
    }

    /// Ticks of encoder `j`: those `told`, or those that its `reading` [rad/s] shows; 0 without.
    fn ticks(&mut self, j: usize, told: f64, reading: f64, h: f64) -> f64 {
        if told > 0.0 {
            return told;
        }
        let beside = self.ticks.iter().any(|ticks| ticks.known().is_some());
        let ticks = &mut self.ticks[j];
        let (before, last) = (ticks.known(), ticks.last);
        ticks.step(reading, h, beside);
        if ticks.known() != before {
            self.sensors[j] = Encoder::at(last);
        }
        ticks.known().unwrap_or(0.0)
    }

    /// The sample `h` [s] after the last one with the speeds that its counts mean, and the settings with the
    /// deviation that a filter has to believe and the ticks that were recognised; nothing if no speed is counted.
    pub fn step(
        &mut self,
        settings: &Settings,
        sample: &Sample,
        h: f64,
    ) -> Option<(Sample, Settings)> {
        let told = settings.encoder.iter().any(|ticks| *ticks > 0.0);
        if told || self.may_count() {
            self.count(settings, sample, h)
        } else {
            None
        }
    }

    /// Some speed may be counted by ticks that it tells itself.
    pub fn may_count(&self) -> bool {
        !self.ticks.iter().all(Ticks::is_none)
    }

    /// By how much two counts of a steady ω_e, ω_c1, ω_c2, ω_w may differ, each wrong by up to a tick in `h` [s] [rad/s],
    /// shape (4): of encoders that are told, or that the `sample` may come from; 0 without.
    pub fn scatter(&self, settings: &Settings, sample: &Sample, h: f64) -> [f64; SPEEDS] {
        let readings = sample.speeds();
        core::array::from_fn(|j| {
            let told = settings.encoder[j];
            let tick = if told > 0.0 {
                Some(TAU / told)
            } else {
                self.ticks[j].tick_with(readings[j], h)
            };
            tick.map_or(0.0, |tick| 2.0 * tick / h)
        })
    }

    #[inline(never)] // most speeds are not counted
    fn count(
        &mut self,
        settings: &Settings,
        sample: &Sample,
        h: f64,
    ) -> Option<(Sample, Settings)> {
        let usable = sample.may_enter(h);
        if !usable {
            return None;
        }
        let (mut omega, mut sigma, mut encoder) = (sample.speeds(), 0.0_f64, settings.encoder);
        for (j, ticks) in encoder.iter_mut().enumerate() {
            *ticks = self.ticks(j, *ticks, omega[j], h);
            if *ticks > 0.0 {
                let told = self.sensors[j].step(TAU / *ticks, JERK[j], omega[j], h);
                (omega[j], sigma) = (told[0], sigma.max(told[1]));
            }
        }
        if sigma == 0.0 {
            return None;
        }
        let mut settings = Settings {
            encoder,
            ..*settings
        };
        settings.kalman.sigma = settings.kalman.sigma.max(sigma);
        settings.calibrating.sensor = settings.calibrating.sensor.max(sigma);
        Some((sample.with_speeds(omega), settings))
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self { sensors, ticks } = self;
        sensors.iter_mut().for_each(|sensor| sensor.visit(visit));
        ticks.iter_mut().for_each(|ticks| ticks.visit(visit));
    }
}

#[cfg(test)]
mod tests {
    use super::{Encoder, JERK};
    use core::f64::consts::TAU;

    const H: f64 = 1e-3;

    /// Largest error of ω̂ [rad/s] after 1 s at a wheel whose angle [rad] is a function of time [s].
    fn worst(ticks: f64, angle: fn(f64) -> f64, speed: fn(f64) -> f64) -> f64 {
        let (tick, mut encoder) = (TAU / ticks, Encoder::at(speed(0.0)));
        let mut worst = 0.0_f64;
        for k in 0..3000 {
            let [before, after] = [k, k + 1].map(|k| (angle(f64::from(k) * H) / tick).floor());
            let [told, _] = encoder.step(tick, JERK[3], (after - before) * tick / H, H);
            let time = f64::from(k + 1) * H;
            if time > 1.0 {
                worst = worst.max((told - speed(time)).abs());
            }
        }
        worst
    }

    /// A tick over the memory 1/ω_b: 0.09 and 0.24 rad/s, as where speed and steps beat the error of the angle creeps
    /// through a tick. The counts are wrong by up to 1.5 and 6 rad/s.
    #[test]
    fn counts_of_a_steady_speed_and_of_an_acceleration_are_followed() {
        for ticks in [4096.0, 1024.0] {
            let tick = TAU / ticks;
            let limit = tick * (JERK[3] * 12.0 / (tick * tick * H)).powf(1.0 / 6.0);
            let steady = worst(ticks, |t| 7.3 * t, |_| 7.3);
            let faster = worst(ticks, |t| 2.0 * t + t * t, |t| 2.0 + 2.0 * t);
            assert!(
                steady < limit && faster < limit,
                "{steady} {faster} {limit}"
            );
        }
    }

    /// A lag of 1 ms would show as 0.2 rad/s.
    #[test]
    fn an_acceleration_leaves_no_lag() {
        let error = worst(1e6, |t| 100.0 * t * t, |t| 200.0 * t);
        assert!(error < 0.01, "{error} rad/s");
    }

    #[test]
    fn a_reading_that_stands_still_is_told_as_it_is() {
        let mut encoder = Encoder::at(10.0);
        let told = |encoder: &mut Encoder, reading| encoder.step(TAU / 4096.0, 10.0, reading, H)[0];
        for k in 0..1000 {
            told(&mut encoder, 10.0 + 0.1 * f64::from(k % 2));
        }
        for _ in 0..400 {
            told(&mut encoder, 0.0);
        }
        assert_eq!(told(&mut encoder, 0.0), 0.0);
    }
}
