//! An instant: vehicle, sample, and what several parts of an observer need of them, worked out once.

use crate::Params;
use crate::observer::{Sample, forces};

/// A sample of a vehicle, with its ratios and clutch forces.
#[derive(Debug, Clone, Copy)]
pub struct Instant<'a> {
    /// The vehicle.
    pub p: &'a Params,
    /// What is measured.
    pub sample: &'a Sample,
    /// g1, g2 of the gears that are in [1], shape (2); 0 in neutral.
    pub g: [f64; 2],
    /// F_n of both clutches [N], shape (2); 0 below the touch point.
    pub force: [f64; 2],
}

impl<'a> Instant<'a> {
    /// The instant of a sample.
    pub fn new(p: &'a Params, sample: &'a Sample) -> Self {
        Self {
            p,
            sample,
            g: p.g(sample.gear),
            force: forces(p, sample),
        }
    }

    /// r_ci N_i F_n,i: torque of each clutch per unit of friction [N·m], shape (2).
    pub fn levers(&self) -> [f64; 2] {
        [0, 1].map(|i| self.force[i] * self.p.clutch[i].r_c_n)
    }

    /// Clutches above their touch point, shape (2).
    pub fn pressed(&self) -> [bool; 2] {
        self.force.map(|force| force > 0.0)
    }
}
