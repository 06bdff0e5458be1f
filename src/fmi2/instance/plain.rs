//! An ordinary exchange, without a second look at it.

use super::{Instance, TIME_TOLERANCE};
use crate::ffi::real::{self, Other};
use crate::{Error, Log, Model, State};

impl<M: Model> Instance<M> {
    /// End [s] of a step that needs no second look: one that is legal, and ends where it says. No stop is beyond
    /// the largest number, so the end is finite.
    #[inline(always)]
    pub(crate) fn plain_step(&self, time: f64, step: f64) -> Option<f64> {
        let (current, end) = (self.now.time, time + step);
        let plain = self.now.state == State::StepComplete
            && (time - current).abs() <= TIME_TOLERANCE * current.abs().max(1.0)
            && time < end
            && end <= self.now.stop;
        plain.then_some(end)
    }

    /// [`Self::get`] of Reals where that needs no second look; else it returns false, and what it wrote is void.
    #[inline(always)]
    pub(crate) fn get_plainly(&mut self, references: &[u32], values: &mut [f64]) -> bool {
        !self.now.stale && real::get(&mut self.now, &mut self.wanted, references, values)
    }

    /// [`Self::get`] of another type where that needs no second look; else it does nothing and returns false.
    #[inline(always)]
    pub(crate) fn get_others_plainly<T: Other, A: From<T>>(
        &mut self,
        references: &[u32],
        values: &mut [A],
    ) -> bool {
        !self.now.stale && real::get_others::<M, T, A>(&mut self.now, references, values)
    }

    /// [`Self::set`] of Reals where that needs no second look; else it does nothing and returns false.
    #[inline(always)]
    pub(crate) fn set_plainly(&mut self, references: &[u32], values: &[f64]) -> bool {
        let plain =
            self.now.state == State::StepComplete && real::set(&mut self.now, references, values);
        if plain {
            self.now.stale = true;
        }
        plain
    }

    /// A legal step, which leads from `time` to `end` [s].
    #[inline(always)]
    pub(crate) fn advance(
        &mut self,
        time: f64,
        step: f64,
        end: f64,
        log: &mut Log<'_>,
    ) -> Result<(), Error> {
        if step != self.step[0] {
            self.step = [step, nominal(step)];
        }
        self.now
            .model
            .step(time, self.step[1], log)
            .map_err(|failure| self.fail(failure))?;
        (self.now.time, self.now.stale, self.now.late) = (end, false, true);
        if M::STEPS_STAY_FINITE {
            Ok(())
        } else {
            self.demand_finite()
        }
    }

    /// Puts an end to an instance whose model failed, or in whose middle Rust panicked: nothing plain passes.
    pub(crate) fn condemn(&mut self) {
        (self.now.state, self.now.stale) = (State::Error, true);
    }
}

/// A step [s] in whole picoseconds, where that changes it by less than an importer's rounding may.
///
/// Importers reckon steps as differences of times: 0.009999999999999787 s, then 0.010000000000000675 s.
/// As 0.01 s they are one and the same, so that a model may keep what it worked out for a step size,
/// and every importer gets the same bits.
pub(super) fn nominal(step: f64) -> f64 {
    const PICOSECONDS: f64 = 1e12; // in a second
    const WHOLE: f64 = 1.0 / f64::EPSILON; // added and taken off again it rounds to a whole number
    let given = step * PICOSECONDS;
    let whole = (given + WHOLE) - WHOLE;
    if (given - whole).abs() <= TIME_TOLERANCE * given {
        whole / PICOSECONDS
    } else {
        step
    }
}
