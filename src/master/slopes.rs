//! What inputs do within a communication step: they go on with a slope, where an FMU can follow.
//!
//! An input of an FMU with canInterpolateInputs has its source's value at the beginning of the step
//! and a first derivative (fmi2SetRealInputDerivatives):
//!
//! ```text
//! the scenario                                  towards its value at the end of the step
//! an FMU that was stepped before in this step   from its old output to its new one
//! another FMU                                   its fmi2GetRealOutputDerivatives; none: it holds
//! ```
//!
//! Integers, booleans and discrete reals hold. Other FMUs are fed as ever.

use crate::error::Error;
use crate::part::Part;

/// Slopes of all signals of a run: one `begin` per step, `feed` and `after` per component.
#[derive(Debug)]
pub struct Slopes {
    /// The world at the beginning of the step.
    start: Vec<f64>,
    slopes: Vec<f64>,
    /// 1 for a signal that may have a slope, else 0.
    moving: Vec<f64>,
    /// Components whose output derivatives are asked for.
    givers: Vec<usize>,
    /// Length of the step [s].
    step: f64,
}

impl Slopes {
    /// `moving`: which signals of the world may have a slope.
    pub fn new(parts: &mut [Part], moving: &[bool]) -> Self {
        parts.iter_mut().for_each(Part::steer);
        let read = |giver: &Part| {
            let mut followers = parts.iter().filter(|part| part.follows());
            followers.any(|part| part.gather.reads(&giver.outputs))
        };
        let all = parts.iter().enumerate();
        let givers = all.filter(|(_, part)| part.tells_slopes() && read(part));
        Self {
            givers: givers.map(|(k, _)| k).collect(),
            start: vec![0.0; moving.len()],
            slopes: vec![0.0; moving.len()],
            moving: moving.iter().map(|m| f64::from(u8::from(*m))).collect(),
            step: 1.0,
        }
    }

    /// Starts a step of `step` [s] over which the scenario goes from `now` to `then`.
    pub fn begin(
        &mut self,
        parts: &mut [Part],
        world: &[f64],
        (now, then): (&[f64], &[f64]),
        step: f64,
    ) -> Result<(), Error> {
        self.step = step;
        self.start.copy_from_slice(world);
        self.slopes.fill(0.0);
        for (slope, (now, then)) in self.slopes.iter_mut().zip(now.iter().zip(then)) {
            *slope = (then - now) / step;
        }
        for giver in &self.givers {
            if let Some(part) = parts.get_mut(*giver) {
                let own = self.slopes.get_mut(part.outputs.clone());
                part.get_slopes(own.unwrap_or_default())?;
            }
        }
        let all = self.slopes.iter_mut().zip(&self.moving);
        all.for_each(|(slope, moving)| *slope *= moving);
        Ok(())
    }

    /// Gathers the inputs of a component for the step from `time` [s].
    pub fn feed(&self, part: &mut Part, world: &[f64], time: f64) -> Result<(), Error> {
        if !part.follows() {
            return part.gather.gather(world, time);
        }
        part.gather.gather(&self.start, time)?;
        part.gather.gather_slopes(&self.slopes);
        Ok(())
    }

    /// Lets later components of this step see where the outputs of this one have gone.
    pub fn after(&mut self, part: &Part, world: &[f64]) {
        for k in part.outputs.clone() {
            let at = |values: &[f64]| values.get(k).copied().unwrap_or(f64::NAN);
            let slope = (at(world) - at(&self.start)) * at(&self.moving) / self.step;
            if let Some(place) = self.slopes.get_mut(k) {
                *place = slope;
            }
        }
    }
}
