//! An instance of a model: life cycle, checked access to its variables, steps. No C in here.
//!
//! A call that returns an error has changed nothing, except when the model itself failed: then the
//! instance is in [`State::Error`] until it is reset or a saved state is restored. A step that is too long for
//! the model is no such failure.

use crate::row::{Row, row, rows};
use crate::saved::Saved;
use crate::value::{Sealed as _, Value, as_many, find, finite, settable};
use crate::{Call, Error, Failure, Log, Model, State};

mod finite;
mod loaded;
mod plain;
mod strings;
mod tangent;
pub use tangent::provides_directional_derivatives;

/// Communication points may differ from the model's time by this much, relative to max(1 s, |t|):
/// far above the rounding of any sum of steps, far below any step.
pub const TIME_TOLERANCE: f64 = 1e-9;

/// A model in its life cycle.
#[derive(Clone)]
pub struct Instance<M: Model> {
    now: Saved<M>,
    /// The last step that was asked for, and what it was taken as [s].
    step: [f64; 2],
    /// Outputs on demand were asked for after the last step.
    wanted: bool,
    /// The model as it was loaded from files, if it reads any.
    fresh: Option<Box<M>>,
}

impl<M: Model> Default for Instance<M> {
    fn default() -> Self {
        Self {
            now: Saved::new(),
            step: [0.0; 2],
            wanted: false,
            fresh: None,
        }
    }
}

impl<M: Model> Instance<M> {
    /// Where it stands in its life cycle.
    #[must_use]
    pub const fn state(&self) -> State {
        self.now.state
    }

    /// End of the last step [s].
    #[must_use]
    pub const fn time(&self) -> f64 {
        self.now.time
    }

    /// `fmi2GetRealStatus`: the time under status kind `fmi2LastSuccessfulTime` [s].
    ///
    /// # Errors
    /// For another kind, and before the first communication point.
    pub fn last_successful_time(&self, kind: i32) -> Result<f64, Error> {
        const LAST_SUCCESSFUL_TIME: i32 = 2;
        self.permit(Call::GetRealStatus)?;
        if kind == LAST_SUCCESSFUL_TIME {
            Ok(self.now.time)
        } else {
            Err(Error::NoStatus(kind))
        }
    }

    /// Whether the life cycle allows a call now.
    ///
    /// # Errors
    /// [`Error::IllegalCall`] when it does not.
    pub fn permit(&self, call: Call) -> Result<(), Error> {
        let state = self.now.state;
        if call.legal().contains(&state) {
            Ok(())
        } else {
            Err(Error::IllegalCall { call, state })
        }
    }

    /// `fmi2SetupExperiment`: times in seconds. Without it a run starts at 0 s and has no end.
    ///
    /// # Errors
    /// When a time is not finite or the stop does not lie after the start.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), Error> {
        self.permit(Call::SetupExperiment)?;
        let end = stop.unwrap_or(f64::MAX);
        if !start.is_finite() || end.is_nan() || end <= start {
            return Err(Error::Experiment { start, stop: end });
        }
        (self.now.start, self.now.time, self.now.stop) = (start, start, end.min(f64::MAX));
        Ok(())
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// When the life cycle does not allow it.
    pub fn enter_initialization(&mut self) -> Result<(), Error> {
        self.permit(Call::EnterInitializationMode)?;
        (self.now.state, self.now.stale) = (State::Initialization, true);
        Ok(())
    }

    /// `fmi2ExitInitializationMode`: initialises, unless reading an output did so already.
    ///
    /// # Errors
    /// When the model cannot start from its parameters.
    pub fn exit_initialization(&mut self, log: &mut Log<'_>) -> Result<(), Error> {
        self.permit(Call::ExitInitializationMode)?;
        self.refresh(log)?;
        self.now.state = State::StepComplete;
        Ok(())
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// When the life cycle does not allow it.
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.permit(Call::Terminate)?;
        self.now.state = State::Terminated;
        Ok(())
    }

    /// `fmi2GetReal` and its kin: the values, in the order of their references.
    ///
    /// Outputs are computed first when something was set since. Everything is checked before the
    /// first value is handed out.
    ///
    /// # Errors
    /// For a reference of another type, a value that is not finite, and when the model fails.
    pub fn get<'a, T: Value>(
        &'a mut self,
        references: &'a [u32],
        log: &mut Log<'_>,
    ) -> Result<impl Iterator<Item = T> + use<'a, M, T>, Error> {
        self.permit(T::GET)?;
        let (mut computed, mut on_demand) = (false, false);
        for &reference in references {
            let (row, _) = find::<M, T>(reference)?;
            computed |= row.computed;
            on_demand |= row.on_demand;
        }
        if computed && self.now.stale || on_demand {
            self.refresh(log)?;
        }
        let model = &mut self.now.model;
        for &reference in references {
            let (row, field) = find::<M, T>(reference)?;
            field(model).number(row.name)?;
        }
        let value = |&reference| {
            let (_, field) = find::<M, T>(reference).ok()?;
            Some(*field(model))
        };
        Ok(references.iter().filter_map(value))
    }

    /// `fmi2SetReal` and its kin: checks everything, then writes everything.
    ///
    /// # Errors
    /// For another number of values than of references, a reference of another type or one that is there twice, a row
    /// that may not be set now, and a value out of range.
    pub fn set<T: Value>(
        &mut self,
        references: &[u32],
        values: impl ExactSizeIterator<Item = T> + Clone,
    ) -> Result<(), Error> {
        self.permit(T::SET)?;
        as_many(references.len(), values.len())?;
        distinct::<M>(references)?;
        for (&reference, value) in references.iter().zip(values.clone()) {
            let (row, _) = find::<M, T>(reference)?;
            settable(row, self.now.state)?;
            value.check(row)?;
        }
        for (&reference, value) in references.iter().zip(values) {
            let (_, field) = find::<M, T>(reference)?;
            *field(&mut self.now.model) = value;
            self.now.stale = true;
        }
        Ok(())
    }

    /// `fmi2SetRealInputDerivatives`: first derivatives of inputs; each stays until it is set anew.
    ///
    /// # Errors
    /// For other numbers of orders or values than of references, an order other than 1, a row without a rate, and a
    /// value that is not finite.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Error> {
        self.permit(Call::SetRealInputDerivatives)?;
        as_many(references.len(), orders.len())?;
        as_many(references.len(), values.len())?;
        distinct::<M>(references)?;
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (row, _) = derivative::<M>(reference, order, |row| row.rate)?;
            finite(row.name, value)?;
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let (_, rate) = derivative::<M>(reference, order, |row| row.rate)?;
            *rate(&mut self.now.model) = value;
            self.now.stale = true;
        }
        Ok(())
    }

    /// `fmi2GetRealOutputDerivatives`: first derivatives of outputs.
    ///
    /// # Errors
    /// For another number of orders than of references, an order other than 1 and a row without a slope.
    pub fn output_derivatives<'a>(
        &'a mut self,
        references: &'a [u32],
        orders: &'a [i32],
        log: &mut Log<'_>,
    ) -> Result<impl Iterator<Item = f64> + use<'a, M>, Error> {
        self.permit(Call::GetRealOutputDerivatives)?;
        as_many(references.len(), orders.len())?;
        for (&reference, &order) in references.iter().zip(orders) {
            derivative::<M>(reference, order, |row| row.slope)?;
        }
        self.refresh(log)?;
        let mut copy = self.now.model.clone();
        self.now.model.slopes(&mut copy);
        let value = move |(&reference, &order)| {
            let (_, slope) = derivative::<M>(reference, order, |row| row.slope).ok()?;
            Some(*slope(&mut copy))
        };
        Ok(references.iter().zip(orders).filter_map(value))
    }

    /// `fmi2DoStep`: from communication point `time` over `step` [s].
    ///
    /// # Errors
    /// When the step does not start at the model's time, does not advance it or leads past the stop
    /// time, and when the model fails.
    pub fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Error> {
        self.permit(Call::DoStep)?;
        let (step, end) = self.legal_step(time, step)?;
        self.advance(time, step, end, log)
    }

    /// A copy of everything: the FMU state.
    ///
    /// # Errors
    /// When what the model computed, outputs on demand with it, is not all numbers: no state is read back from that.
    pub fn save(&mut self) -> Result<Saved<M>, Error> {
        self.permit(Call::GetFMUstate)?;
        self.now.catch_up();
        self.now.check_numbers()?;
        Ok(self.now.clone())
    }

    /// Goes back to a saved state, life cycle included.
    ///
    /// # Errors
    /// None in the present life cycle.
    pub fn restore(&mut self, saved: &Saved<M>) -> Result<(), Error> {
        self.permit(Call::SetFMUstate)?;
        self.now = saved.clone();
        Ok(())
    }

    /// Size and end of a legal step [s]. The end is the importer's own, bit for bit, unless the step
    /// misses the stop time by rounding: then it ends there.
    fn legal_step(&self, time: f64, step: f64) -> Result<(f64, f64), Error> {
        let (current, stop) = (self.now.time, self.now.stop);
        let tolerance = TIME_TOLERANCE * current.abs().max(1.0);
        let starts_here = (time - current).abs() <= tolerance;
        if !starts_here {
            return Err(Error::StepTime { time, current });
        }
        let end = time + step;
        let advances = time < end && end < f64::INFINITY;
        if !advances {
            return Err(Error::StepSize { step, time });
        }
        if end <= stop {
            return Ok((step, end));
        }
        if end > stop + TIME_TOLERANCE * stop.abs().max(1.0) || time >= stop {
            return Err(Error::PastStop { end, stop });
        }
        Ok((stop - time, stop))
    }

    /// Computes what depends on values that were set since the last computation.
    fn refresh(&mut self, log: &mut Log<'_>) -> Result<(), Error> {
        if !self.now.stale {
            self.now.catch_up();
            return Ok(());
        }
        match self.now.state {
            State::Instantiated | State::Error => return Ok(()),
            State::Initialization => {
                let start = self.now.start;
                self.now
                    .model
                    .initialize(start, log)
                    .map_err(|failure| self.fail(failure))?;
                if M::STEPS_STAY_FINITE {
                    self.now.stale = false;
                    return Ok(());
                }
            }
            State::StepComplete | State::Terminated => self.now.model.update_outputs(),
        }
        (self.now.stale, self.now.late) = (false, false);
        self.demand_finite()
    }

    /// No importer shall be handed a NaN that the model did not notice.
    #[inline(always)]
    fn demand_finite(&mut self) -> Result<(), Error> {
        if finite::surely(&mut self.now.model) {
            return Ok(());
        }
        self.look_for_no_number()
    }

    #[cold]
    #[inline(never)]
    fn look_for_no_number(&mut self) -> Result<(), Error> {
        for row in rows::<M>().filter(|row| row.computed) {
            let Some(field) = f64::field(&row.access) else {
                continue;
            };
            if !field(&mut self.now.model).is_finite() {
                let failure = Failure::Diverged {
                    variable: row.name,
                    time: self.now.time,
                };
                return Err(self.fail(failure));
            }
        }
        Ok(())
    }

    /// A step that is too long has changed nothing: the importer may try a shorter one.
    #[cold]
    fn fail(&mut self, failure: Failure) -> Error {
        if !matches!(failure, Failure::StepTooLong { .. }) {
            self.condemn();
        }
        Error::Model(failure)
    }
}

/// Refuses a variable that is to be set twice in one call. A bit per reference tells those that may
/// be there twice; only they are looked for.
fn distinct<M: Model>(references: &[u32]) -> Result<(), Error> {
    let mut seen = 0_u64;
    for (index, &reference) in references.iter().enumerate() {
        let bit = 1 << (reference % u64::BITS);
        if seen & bit != 0 && references.iter().take(index).any(|r| *r == reference) {
            return Err(duplicate::<M>(reference));
        }
        seen |= bit;
    }
    Ok(())
}

#[cold]
fn duplicate<M: Model>(reference: u32) -> Error {
    let variable = row::<M>(reference).map_or("a value reference", |row| row.name);
    Error::Duplicate { variable }
}

type Reals<M> = fn(&mut M) -> &mut f64;

fn derivative<M: Model>(
    reference: u32,
    order: i32,
    choose: fn(&Row<M>) -> Option<Reals<M>>,
) -> Result<(&'static Row<M>, Reals<M>), Error> {
    let (row, _) = find::<M, f64>(reference)?;
    let field = choose(row).filter(|_| order == 1);
    field.map(|field| (row, field)).ok_or(Error::NoDerivative {
        variable: row.name,
        order,
    })
}

#[cfg(test)]
mod constant;
#[cfg(test)]
mod on_demand;
#[cfg(test)]
mod tests;
