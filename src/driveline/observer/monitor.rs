//! Inputs that make every estimate worthless: a speed that is missing, a signal that is frozen, an
//! innovation that stays large, by itself or for what the filter expects, a friction that stays at its bound.
//!
//! A speed may stand still for good reasons, so frozen means: not one bit has changed for 0.1 s though
//! something that moves with it has. Shafts with a gear in and the wheel move together; the engine moves
//! with its torque, and with an engaged clutch.

use crate::Params;
use crate::observer::instant::Instant;
use crate::observer::{SPEEDS, Sample, Visit, lasting};
use core::fmt;

/// Time for which a fault has to last before it is told [s].
pub const PATIENCE: f64 = lasting(0.1);
/// Motion of its partners, added up, that a standing signal cannot follow: output side [rad/s].
const MOVED: f64 = 0.5;
/// Motion of a clutch that an engine engaged with it must follow [rad/s].
const ENGINE_MOVED: f64 = 5.0;
/// Change of torque that an engine must follow [N·m].
const TORQUE_MOVED: f64 = 5.0;
/// A shaft turns [rad/s, output side]: a partner that reads exactly 0 is missing.
const TURNS: f64 = 5.0;
/// Torque of an engine that turns [N·m].
const RUNS: f64 = 10.0;
/// Largest |x1 − x̂1| and |x2 − x̂2| of an observer that follows [rad/s], shape (2).
const FOLLOWS: [f64; 2] = [50.0, 10.0];

/// Innovation² over its expected variance of a filter that is wrong about itself [1]: five deviations.
const SURPRISE: f64 = 25.0;

/// Why an estimate cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// A sample or a step that is no number.
    NotFinite = 1,
    /// A speed reads 0 though what moves with it turns.
    NoSpeed = 2,
    /// A speed does not change though what moves with it does.
    Frozen = 3,
    /// A friction, or an error that `calibrating` learns, has been at its physical bound.
    Saturated = 4,
    /// The innovation has been beyond what a driveline can do.
    Diverged = 5,
    /// The innovation has been far beyond what the filter expects of it.
    Inconsistent = 6,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "an input is no number",
            Self::NoSpeed => "a speed reads 0 though what moves with it turns",
            Self::Frozen => "a speed is frozen though what moves with it changes",
            Self::Saturated => "what is learnt is at its physical bound",
            Self::Diverged => "the innovation is beyond what a driveline can do",
            Self::Inconsistent => "the innovation is far beyond what the filter expects",
        })
    }
}

/// What the monitor remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Monitor {
    /// Last values of ω_e, ω_c1, ω_c2, ω_w [rad/s], shape (4).
    pub last: [f64; SPEEDS],
    /// Time for which each has not changed [s], shape (4).
    pub still: [f64; SPEEDS],
    /// All speeds and T_e when speed j changed last, shape (4, 5).
    pub then: [[f64; SPEEDS + 1]; SPEEDS],
    /// Output side per unit of ω_c1, ω_c2, ω_w [1], shape (3); 0 in neutral.
    pub scale: [f64; 3],
    /// Time for which a speed has been missing [s].
    pub missing: f64,
    /// Time for which a speed has been frozen beyond [`PATIENCE`] [s].
    pub frozen: f64,
    /// Time for which the innovation has been too large [s].
    pub diverged: f64,
    /// Time for which a friction has been at its bound [s].
    pub saturated: f64,
    /// Time for which a filter has been wrong about itself [s].
    pub inconsistent: f64,
}

impl Monitor {
    /// Begins to watch at a sample.
    #[cold]
    #[inline(never)]
    pub fn start(&mut self, p: &Params, sample: &Sample) {
        *self = Self {
            last: sample.speeds(),
            then: [signals(sample); SPEEDS],
            scale: scale(p.g(sample.gear)),
            ..*self
        };
        self.still = [0.0; SPEEDS];
    }

    /// Takes an instant `h` [s] after the last one.
    ///
    /// `engaged`: engaged clutches, shape (2). `innovation`: of x1 and x2 [rad/s], shape (2).
    pub fn step(&mut self, now: &Instant<'_>, engaged: [bool; 2], innovation: [f64; 2], h: f64) {
        let Instant { p, sample, g, .. } = *now;
        if self.scale != scale(g) {
            self.start(p, sample);
        }
        for (j, now) in sample.speeds().into_iter().enumerate() {
            if now == self.last[j] {
                self.still[j] += h;
            } else {
                (self.still[j], self.then[j]) = (0.0, signals(sample));
            }
        }
        self.last = sample.speeds();
        let lasts = |time: f64, bad: bool| if bad { time + h } else { 0.0 };
        self.missing = lasts(self.missing, self.is_missing(sample));
        self.frozen = lasts(self.frozen, self.is_frozen(sample, engaged));
        let large = (0..2).any(|i| innovation[i].abs() > FOLLOWS[i]);
        self.diverged = lasts(self.diverged, large);
    }

    /// Takes the mean of innovation² over its expected variance [1], `h` [s] after the last one.
    pub fn doubt(&mut self, surprise: f64, h: f64) {
        let doubtful = surprise > SURPRISE;
        self.inconsistent = if doubtful { self.inconsistent + h } else { 0.0 };
    }

    /// What is wrong now, the plainest cause first.
    pub fn fault(&self) -> Option<Fault> {
        let causes = [
            (self.missing, Fault::NoSpeed),
            (self.frozen, Fault::Frozen),
            (self.diverged, Fault::Diverged),
            (self.saturated, Fault::Saturated),
            (self.inconsistent, Fault::Inconsistent),
        ];
        let lasting = |(time, _): &&(f64, Fault)| *time >= PATIENCE;
        causes.iter().find(lasting).map(|(_, fault)| *fault)
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            last,
            still,
            then,
            scale,
            missing,
            frozen,
            diverged,
            saturated,
            inconsistent,
        } = self;
        let rows = then.iter_mut().flatten();
        let all = last.iter_mut().chain(still).chain(rows).chain(scale);
        all.chain([missing, frozen, diverged, saturated, inconsistent])
            .for_each(visit);
    }

    /// A speed reads exactly 0 though what moves with it turns.
    fn is_missing(&self, sample: &Sample) -> bool {
        let [e, output @ ..] = sample.speeds();
        let stands = (0..3).any(|i| self.scale[i] != 0.0 && output[i] == 0.0);
        let turns = (0..3).any(|i| (self.scale[i] * output[i]).abs() > TURNS);
        e == 0.0 && sample.t_e > RUNS || stands && turns
    }

    /// A speed has not changed a bit though what moves with it has.
    fn is_frozen(&self, sample: &Sample, engaged: [bool; 2]) -> bool {
        let now = signals(sample);
        let moved = |j: usize, k: usize| (now[k] - self.then[j][k]).abs();
        let partners = |j: usize| {
            let linked = (1..SPEEDS).filter(|k| *k != j);
            self.scale[j - 1] != 0.0
                && linked.map(|k| self.scale[k - 1] * moved(j, k)).sum::<f64>() > MOVED
        };
        let engine = || {
            moved(0, SPEEDS) > TORQUE_MOVED
                || (0..2).any(|i| engaged[i] && moved(0, 1 + i) > ENGINE_MOVED)
        };
        // A brake holds the wheel at exactly 0 while the shafts before it wind up.
        let held = sample.omega_w == 0.0 && sample.t_brake > 0.0;
        let moves = |j| if j == 0 { engine() } else { partners(j) };
        (0..SPEEDS - usize::from(held)).any(|j| self.still[j] >= PATIENCE && moves(j))
    }
}

/// All speeds and T_e.
fn signals(sample: &Sample) -> [f64; SPEEDS + 1] {
    let [e, one, two, w] = sample.speeds();
    [e, one, two, w, sample.t_e]
}

/// Output side per unit of ω_c1, ω_c2, ω_w [1], shape (3); 0 in neutral.
fn scale(g: [f64; 2]) -> [f64; 3] {
    let [one, two] = g.map(|g| if g == 0.0 { 0.0 } else { 1.0 / g });
    [one, two, 1.0]
}

#[cfg(test)]
mod tests {
    use super::{Fault, Monitor};
    use crate::Params;
    use crate::observer::Sample;
    use crate::observer::instant::Instant;

    const P: Params = Params::TABLE_1;
    const H: f64 = 1e-3;

    /// Drive in first gear with clutch 1 engaged that speeds up; `spoil` sees time [s] and sample.
    fn drive(spoil: fn(f64, &mut Sample)) -> Option<Fault> {
        let mut monitor = Monitor::default();
        for k in 0..1000 {
            let time = f64::from(k) * H;
            let omega_w = 8.0 + 2.0 * time;
            let mut sample = Sample {
                t_e: 60.0 + 20.0 * time,
                omega_e: 18.0 * omega_w,
                omega_c: [18.0 * omega_w, 11.52 * omega_w],
                omega_w,
                gear: [1, 2],
                ..Sample::default()
            };
            spoil(time, &mut sample);
            if k == 0 {
                monitor.start(&P, &sample);
            }
            monitor.step(&Instant::new(&P, &sample), [true, false], [0.0; 2], H);
        }
        monitor.fault()
    }

    #[test]
    fn a_drive_has_no_fault() {
        assert_eq!(drive(|_, _| {}), None);
    }

    #[test]
    fn a_frozen_speed_is_found() {
        let freezes: [fn(f64, &mut Sample); 4] = [
            |_, sample| sample.omega_e = 144.0,
            |_, sample| sample.omega_c[0] = 144.0,
            |_, sample| sample.omega_c[1] = 92.0,
            |_, sample| sample.omega_w = 8.0,
        ];
        for freeze in freezes {
            assert_eq!(drive(freeze), Some(Fault::Frozen));
        }
    }

    #[test]
    fn a_missing_speed_is_found() {
        let cuts: [fn(f64, &mut Sample); 4] = [
            |_, sample| sample.omega_e = 0.0,
            |_, sample| sample.omega_c[0] = 0.0,
            |_, sample| sample.omega_c[1] = 0.0,
            |_, sample| sample.omega_w = 0.0,
        ];
        for cut in cuts {
            assert_eq!(drive(cut), Some(Fault::NoSpeed));
        }
    }

    #[test]
    fn a_short_drop_and_a_shaft_in_neutral_are_no_fault() {
        assert_eq!(
            drive(|time, sample| {
                if time > 0.95 {
                    sample.omega_w = 0.0;
                }
            }),
            None
        );
        assert_eq!(
            drive(|_, sample| {
                sample.gear = [1, 0];
                sample.omega_c[1] = 0.0;
            }),
            None
        );
    }
}
