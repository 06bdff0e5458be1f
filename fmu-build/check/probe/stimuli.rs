//! Input values that an FMU accepts, and its answers to them.

use super::session::{Run, Session, Variable, values};
use super::value::Value;
use crate::Result;

/// How far a Real is moved, as a share of its range, of its value or of its nominal value.
const SHARE: f64 = 0.01;

/// A variable that can be set, its value, and another one that it accepts.
pub(super) struct Nudge<'a> {
    pub variable: Variable<'a>,
    pub start: Value,
    pub other: Value,
}

/// The inputs that accept another value, and all outputs.
pub(super) struct Stimuli<'a> {
    pub inputs: Vec<Nudge<'a>>,
    pub outputs: Vec<Variable<'a>>,
    step: f64,
}

/// Output values, one row for each communication point.
pub(super) type Rows = Vec<Vec<Value>>;

impl<'a> Stimuli<'a> {
    /// Tries out which inputs accept another value, one by one and then all at once.
    pub(super) fn of(session: &Session<'a>) -> Result<Self> {
        let mut run = session.run()?;
        let mut inputs = Vec::new();
        for variable in session.all("input") {
            let start = variable.get(&run.instance)?;
            let Some(other) = other(&variable, &start) else {
                continue;
            };
            if variable.set(&run.instance, &other).is_ok() {
                variable.set(&run.instance, &start)?;
                let nudge = Nudge {
                    variable,
                    start,
                    other,
                };
                inputs.push(nudge);
            } else {
                drop(run); // after fmi2Error an instance is of no use
                run = session.run()?;
            }
        }
        let mut stimuli = Self {
            inputs,
            outputs: session.all("output"),
            step: session.step(),
        };
        let together = stimuli.nudge(&run).and_then(|()| run.step(stimuli.step));
        if together.is_err() {
            stimuli.inputs.clear();
        }
        Ok(stimuli)
    }

    /// Gives every input its other value.
    pub(super) fn nudge(&self, run: &Run<'_>) -> Result<()> {
        let mut inputs = self.inputs.iter();
        inputs.try_for_each(|input| input.variable.set(&run.instance, &input.other))
    }

    /// Gives every input its start value.
    fn relax(&self, run: &Run<'_>) -> Result<()> {
        let mut inputs = self.inputs.iter();
        inputs.try_for_each(|input| input.variable.set(&run.instance, &input.start))
    }

    /// One step of a run in which inputs change at every fourth communication point.
    pub(super) fn advance(&self, run: &Run<'_>, number: usize) -> Result<Vec<Value>> {
        match number % 8 {
            4 => self.nudge(run)?,
            0 if number > 0 => self.relax(run)?,
            _ => {}
        }
        run.step(self.step)?;
        values(&run.instance, &self.outputs)
    }

    /// The outputs after each of these steps.
    pub(super) fn record(&self, run: &Run<'_>, numbers: std::ops::Range<usize>) -> Result<Rows> {
        numbers.map(|number| self.advance(run, number)).collect()
    }

    /// The first value that differs: its row, its name, and both values.
    pub(super) fn difference(&self, one: &Rows, other: &Rows) -> Option<(usize, String)> {
        for (row, (before, after)) in one.iter().zip(other).enumerate() {
            let pairs = self.outputs.iter().zip(before.iter().zip(after));
            let mut differing = pairs.filter(|(_, (before, after))| !before.same(after));
            if let Some((output, (before, after))) = differing.next() {
                let more = match differing.count() {
                    0 => String::new(),
                    count => format!(" (and {count} more)"),
                };
                let name = output.name();
                return Some((row, format!("{name} is {after}, not {before}{more}")));
            }
        }
        None
    }
}

/// Another value within the limits of a variable.
pub(super) fn other(variable: &Variable<'_>, start: &Value) -> Option<Value> {
    let attributes = variable.attributes;
    let min = attributes.min.unwrap_or(f64::NEG_INFINITY);
    let max = attributes.max.unwrap_or(f64::INFINITY);
    match start {
        Value::Real(value) => {
            let range = max - min;
            let scale = if range.is_finite() {
                range
            } else {
                value.abs().max(variable.nominal())
            };
            let sides = [value + SHARE * scale, value - SHARE * scale];
            let found = sides
                .into_iter()
                .find(|side| (min..=max).contains(side) && side != value);
            found.map(Value::Real)
        }
        Value::Integer(value) => {
            let sides = [value.checked_add(1), value.checked_sub(1)];
            let inside = |side: &i32| (min..=max).contains(&f64::from(*side));
            let mut found = sides.into_iter().flatten().filter(inside);
            found.next().map(Value::Integer)
        }
        Value::Boolean(value) => Some(Value::Boolean(!value)),
        Value::String(_) => None,
    }
}

/// Whether finite differences and slopes make sense for an input.
pub(super) fn is_smooth(nudge: &Nudge<'_>) -> bool {
    nudge.variable.is_smooth()
}
