//! Which gears are in, from the gears that are preselected and the speeds.
//!
//! A preselected gear is synchronised for some 0.1 s before it connects its shaft with the output, and
//! while a clutch transmits the gearbox ignores what is preselected. A production car reports neither.
//!
//! What a synchroniser does to the output is known nevertheless: with its clutch open, nothing else turns the
//! input shaft, whose speed is measured:
//!
//! ```text
//! J_cti ω̇_ci = −T_si   ⇒   T_y = Σ g_i T_si = −Σ g_i J_cti Δω_ci/h             over a step h, from (4), (5)
//! ```
//!
//! The sum over the steps of an event is its impulse whatever the step, and noise of ω_ci goes out of it. It holds
//! of a gear that has come in as well, so a gear taken as in a sample late costs nothing; one taken as in early loses
//! the rest of the impulse.
//!
//! ```
//! use dct_driveline::observer::{Sample, shift::Shift};
//! use dct_driveline::Params;
//!
//! let (p, mut shift) = (Params::TABLE_1, Shift::default());
//! let mut sample = Sample { omega_c: [180.0, 0.0], omega_w: 10.0, gear: [1, 0], ..Sample::default() };
//! shift.start(&sample);
//! sample.gear = [1, 2];
//! assert_eq!(shift.step(&p, &sample, 1e-3).gear, [1, 0]);
//! sample.omega_c[1] = 1.0;
//! let rubbing = shift.step(&p, &sample, 1e-3);
//! assert!((rubbing.t_y + 11.52 * 0.1 * 1000.0).abs() < 1e-9);
//! sample.omega_c[1] = 115.3;
//! assert_eq!(shift.step(&p, &sample, 1e-3).gear, [1, 2]);
//! ```

use crate::Params;
use crate::observer::{Sample, Visit};

/// Difference from the speed of a gear at which it is taken as in, once it falls no more [rad/s]: noise of speed
/// sensors, seen through the ratio of a low gear.
const ALIKE: f64 = 3.0;

/// What is known of the gears.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shift {
    /// Gears that are in or are being synchronised, shape (2).
    gear: [i32; 2],
    /// Whether they are in, shape (2).
    is_in: [bool; 2],
    /// ω_ci − g_i ω_o at the last sample, where a gear is being synchronised [rad/s], shape (2).
    difference: [f64; 2],
    /// ω_c1, ω_c2 of the last sample [rad/s], shape (2).
    omega_c: [f64; 2],
}

impl Shift {
    /// At the start of a run the preselected gears are in.
    pub fn start(&mut self, sample: &Sample) {
        *self = Self {
            gear: sample.gear,
            is_in: [true; 2],
            difference: [0.0; 2],
            omega_c: sample.omega_c,
        };
    }

    /// The sample `h` [s] after the last one with the gears that are in, and T_y.
    pub fn step(&mut self, p: &Params, sample: &Sample, h: f64) -> Sample {
        if !sample.may_enter(h) {
            return *sample;
        }
        let mut t_y = 0.0;
        if sample.gear != self.gear || self.is_in != [true; 2] {
            t_y = self.follow(p, sample) / h;
        }
        self.omega_c = sample.omega_c;
        Sample {
            gear: [0, 1].map(|i| if self.is_in[i] { self.gear[i] } else { 0 }),
            t_y,
            ..*sample
        }
    }

    /// Follows gears that change; returns the impulse of synchronisers at the output [N·m·s].
    #[inline(never)] // gears change rarely
    fn follow(&mut self, p: &Params, sample: &Sample) -> f64 {
        let mut impulse = 0.0;
        for i in [0, 1] {
            if !is_open(p, sample, i) {
                continue; // neither goes a gear out nor comes one in
            }
            if sample.gear[i] != self.gear[i] {
                (self.gear[i], self.is_in[i]) = (sample.gear[i], false);
                self.difference[i] = self.left(p, sample, i);
            }
            if !self.is_in[i] {
                let faster = sample.omega_c[i] - self.omega_c[i];
                impulse -= p.g(self.gear)[i] * p.j_ct[i] * faster;
            }
            let left = self.left(p, sample, i);
            let last = self.difference[i];
            let met = left * last < 0.0;
            self.is_in[i] |= met || left.abs() < ALIKE && left.abs() >= last.abs();
            self.difference[i] = left;
        }
        impulse
    }

    /// ω_ci − g_i ω_o [rad/s], ω_o from the other shaft if its gear is in, from the wheels otherwise.
    fn left(&self, p: &Params, sample: &Sample, i: usize) -> f64 {
        let (g, other) = (p.g(self.gear), 1 - i);
        let omega_o = if self.is_in[other] && g[other] != 0.0 {
            sample.omega_c[other] / g[other]
        } else {
            sample.omega_w
        };
        sample.omega_c[i] - g[i] * omega_o
    }

    /// Whether shaft `i`, whose gear is coming in, is between its last speed and that of the gear in a sample, or has met
    /// it: a synchroniser brings it there at once, or as fast as it likes.
    pub fn is_on_its_way(&self, p: &Params, sample: &Sample, i: usize) -> bool {
        let mut next = *self;
        next.gear[i] = sample.gear[i];
        let waits = !self.is_in[i] || next.gear[i] != self.gear[i];
        if !waits || p.g(next.gear)[i] == 0.0 || !is_open(p, sample, i) {
            return false;
        }
        let left = next.left(p, sample, i);
        let before = left + self.omega_c[i] - sample.omega_c[i];
        left.abs() < ALIKE || left * before > 0.0 && left.abs() < before.abs()
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Self {
            gear,
            is_in,
            difference,
            omega_c,
        } = self;
        for gear in gear {
            let mut number = f64::from(*gear);
            visit(&mut number);
            *gear = whole(number);
        }
        for is_in in is_in {
            super::visit_switch(is_in, visit);
        }
        let speeds = difference.iter_mut().chain(omega_c);
        speeds.for_each(visit);
    }
}

/// The number of a gear that was saved.
fn whole(number: f64) -> i32 {
    (-16..=16)
        .find(|gear| f64::from(*gear) == number)
        .unwrap_or(0)
}

/// Clutch `i` transmits nothing.
fn is_open(p: &Params, sample: &Sample, i: usize) -> bool {
    p.clutch[i].force(sample.actuation[i]) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::Shift;
    use crate::Params;
    use crate::observer::Sample;
    use crate::params::Actuation;

    const P: Params = Params::TABLE_1;

    /// Momentum that the output receives while shaft 1 is brought from neutral to first gear [N·m·s], and the
    /// sum of what every sample of `count` told.
    fn impulse(count: u32, noise: f64, position: f64) -> f64 {
        let (h, mut shift) = (0.2 / f64::from(count), Shift::default());
        let sample = |k: u32| Sample {
            omega_c: [
                180.0 * f64::from(k) / f64::from(count) + noise * f64::from(k % 2),
                115.2,
            ],
            omega_w: 10.0,
            actuation: [position, 0.0].map(|position| Actuation {
                position,
                pressure: 0.0,
            }),
            gear: if k == 0 { [0, 2] } else { [1, 2] },
            ..Sample::default()
        };
        shift.start(&sample(0));
        (1..=count)
            .map(|k| shift.step(&P, &sample(k), h).t_y * h)
            .sum()
    }

    /// Whatever the step and the noise of the speed: −g J_ct Δω_c.
    #[test]
    fn impulse_of_a_synchroniser_is_what_its_shaft_gained() {
        let expected = -18.0 * P.j_ct[0] * 180.0;
        for count in [10, 20, 200] {
            let told = impulse(count, 0.0, 0.0);
            assert!((told / expected - 1.0).abs() < 1e-12, "{count}: {told}");
            assert!((impulse(count, 0.1, 0.0) - told).abs() < 0.2 * 18.0 * P.j_ct[0]);
        }
    }

    #[test]
    fn a_pressed_clutch_lets_the_synchroniser_go() {
        assert_eq!(impulse(200, 0.0, 5e-3), 0.0);
    }

    #[test]
    fn a_sample_that_is_no_number_changes_nothing() {
        let mut shift = Shift::default();
        let sample = Sample {
            omega_c: [180.0, 115.2],
            omega_w: 10.0,
            gear: [1, 2],
            ..Sample::default()
        };
        shift.start(&sample);
        let before = shift;
        let lost = Sample {
            omega_c: [f64::NAN, 0.0],
            gear: [1, 0],
            ..sample
        };
        shift.step(&P, &lost, 1e-3);
        assert_eq!(shift, before);
    }
}
