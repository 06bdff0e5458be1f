//! Which gears are in, from the gears that are preselected and the speeds.
//!
//! A preselected gear is synchronised for some 0.1 s before it connects its shaft with the output, and
//! while a clutch transmits the gearbox ignores what is preselected. A production car reports neither.
//!
//! ```
//! use dct_driveline::observer::{Sample, shift::Shift};
//! use dct_driveline::Params;
//!
//! let (p, mut shift) = (Params::TABLE_1, Shift::default());
//! let mut sample = Sample { omega_c: [180.0, 0.0], omega_w: 10.0, gear: [1, 0], ..Sample::default() };
//! shift.start(&sample);
//! sample.gear = [1, 2];
//! assert_eq!(shift.step(&p, &sample).gear, [1, 0]);
//! sample.omega_c[1] = 115.2;
//! assert_eq!(shift.step(&p, &sample).gear, [1, 2]);
//! ```

use crate::Params;
use crate::observer::{Sample, Visit};

/// Difference from the speed of a gear at which it is taken as in [rad/s]: noise of speed sensors, seen
/// through the ratio of a low gear.
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
}

impl Shift {
    /// At the start of a run the preselected gears are in.
    pub fn start(&mut self, sample: &Sample) {
        (self.gear, self.is_in, self.difference) = (sample.gear, [true; 2], [0.0; 2]);
    }

    /// The sample with the gears that are in.
    pub fn step(&mut self, p: &Params, sample: &Sample) -> Sample {
        if sample.gear != self.gear || self.is_in != [true; 2] {
            self.follow(p, sample);
        }
        Sample {
            gear: [0, 1].map(|i| if self.is_in[i] { self.gear[i] } else { 0 }),
            ..*sample
        }
    }

    #[inline(never)] // gears change rarely
    fn follow(&mut self, p: &Params, sample: &Sample) {
        for i in [0, 1] {
            if p.clutch[i].force(sample.actuation[i]) > 0.0 {
                continue; // neither goes a gear out nor comes one in
            }
            if sample.gear[i] != self.gear[i] {
                (self.gear[i], self.is_in[i]) = (sample.gear[i], false);
                self.difference[i] = self.left(p, sample, i);
            }
            let left = self.left(p, sample, i);
            self.is_in[i] |= left.abs() < ALIKE || left * self.difference[i] < 0.0;
            self.difference[i] = left;
        }
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

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        for gear in &mut self.gear {
            let mut number = f64::from(*gear);
            visit(&mut number);
            *gear = whole(number);
        }
        for is_in in &mut self.is_in {
            super::visit_switch(is_in, visit);
        }
        self.difference.iter_mut().for_each(visit);
    }
}

/// The number of a gear that was saved.
fn whole(number: f64) -> i32 {
    (-16..=16)
        .find(|gear| f64::from(*gear) == number)
        .unwrap_or(0)
}
