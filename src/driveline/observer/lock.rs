//! Which clutches are fully engaged, from measured slip and actuators.

use crate::Params;
use crate::observer::Sample;

/// Slip below which a clutch may be engaged [rad/s]; damper vibration stays below it.
pub const SLIP: f64 = 3.0;
/// Time for which it has to be [s].
const TIME: f64 = 0.03;

/// How long each clutch has been pressed without slip [s], shape (2).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lock {
    /// Time pressed without slip [s], shape (2), at most the time that it takes.
    pub since: [f64; 2],
}

impl Lock {
    /// Takes a sample `h` [s] after the last one.
    pub fn step(&mut self, p: &Params, sample: &Sample, h: f64) {
        let g = p.g(sample.gear);
        for (i, slip) in sample.slip().into_iter().enumerate() {
            let pressed = p.clutch[i].force(sample.actuation[i]) > 0.0;
            let together = pressed && slip.abs() < SLIP && g[i] != 0.0;
            self.since[i] = if together {
                (self.since[i] + h).min(TIME)
            } else {
                0.0
            };
        }
    }

    /// Fully engaged clutches, shape (2).
    pub fn engaged(&self) -> [bool; 2] {
        self.since.map(|since| since >= TIME)
    }

    /// The one clutch that is engaged while the other is open: (20) holds.
    pub fn alone(&self, p: &Params, sample: &Sample) -> Option<usize> {
        let open = [0, 1].map(|i| p.clutch[i].force(sample.actuation[i]) <= 0.0);
        match (self.engaged(), open) {
            ([true, _], [_, true]) => Some(0),
            ([_, true], [true, _]) => Some(1),
            _ => None,
        }
    }
}
