//! Everything that can go wrong, the sentence the importer's log shows, and its `fmi2Status`.

use crate::number::Number;
use crate::{Call, Category, Failure, State};
use core::fmt;

/// `fmi2Status`, without `fmi2Pending`: every call is finished when it returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// All well.
    Ok = 0,
    /// All well, with a remark in the log.
    Warning = 1,
    /// Refused; nothing changed and the importer may go on with other values.
    Discard = 2,
    /// The call or the model is wrong.
    Error = 3,
    /// The model panicked; its instance is unusable.
    Fatal = 4,
}

/// Why a call was refused.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// The life cycle does not allow the call now.
    IllegalCall {
        /// The call.
        call: Call,
        /// State it came in.
        state: State,
    },
    /// No variable of that type has the value reference.
    UnknownReference {
        /// The value reference.
        reference: u32,
        /// FMI type asked for.
        kind: &'static str,
    },
    /// The variable may not be set in this state.
    NotSettable {
        /// Its name.
        variable: &'static str,
        /// State the call came in.
        state: State,
        /// Why, and what to do.
        remedy: &'static str,
    },
    /// A value is NaN or infinite.
    NotFinite {
        /// Name of the variable or argument.
        variable: &'static str,
        /// Its value.
        value: f64,
    },
    /// A value is below its minimum.
    BelowMin {
        /// Name of the variable.
        variable: &'static str,
        /// Its value.
        value: f64,
        /// Smallest legal value.
        min: f64,
    },
    /// A value is above its maximum.
    AboveMax {
        /// Name of the variable.
        variable: &'static str,
        /// Its value.
        value: f64,
        /// Largest legal value.
        max: f64,
    },
    /// A value is none of its enumeration.
    NotAnItem {
        /// Name of the variable.
        variable: &'static str,
        /// Its value.
        value: i32,
        /// Name of the enumeration.
        enumeration: &'static str,
    },
    /// The text for a String is not UTF-8.
    NotUtf8,
    /// The variable has no derivative of that order to set or get.
    NoDerivative {
        /// Name of the variable.
        variable: &'static str,
        /// Order asked for.
        order: i32,
    },
    /// A directional derivative is that of a Real output by Real inputs; this is neither.
    NotDifferentiable {
        /// Name of the variable.
        variable: &'static str,
    },
    /// The stop time does not lie after the start time.
    Experiment {
        /// Start time [s].
        start: f64,
        /// Stop time [s].
        stop: f64,
    },
    /// A step does not start where the last one ended.
    StepTime {
        /// Communication point of the call [s].
        time: f64,
        /// Time the model stands at [s].
        current: f64,
    },
    /// A step size is not finite, not positive, or too small to advance time.
    StepSize {
        /// Communication step size [s].
        step: f64,
        /// Communication point [s].
        time: f64,
    },
    /// A step would end after the stop time.
    PastStop {
        /// End of the step [s].
        end: f64,
        /// Stop time [s].
        stop: f64,
    },
    /// The model could not initialise or step.
    Model(Failure),
    /// Bytes are not a serialised state of this FMU.
    Serialised(&'static str),
    /// A pointer is null or misaligned.
    Pointer(&'static str),
    /// A call is to set or get more variables than there are.
    Count(usize),
    /// There is less room for the bytes of a state than it needs.
    Size {
        /// Bytes there is room for.
        size: usize,
        /// Bytes of the state.
        needed: usize,
    },
    /// An FMU state was freed, is in use, is not of this FMU, or there is no room for another one.
    State,
    /// A call has not as many values as variables.
    Lengths {
        /// How many variables.
        variables: usize,
        /// How many values, orders or directions.
        values: usize,
    },
    /// The same variable twice in one call.
    Duplicate {
        /// Its name.
        variable: &'static str,
    },
    /// A log category is none of the model description's.
    UnknownCategory,
    /// `fmi2Instantiate` was given something it cannot accept.
    Instantiate(&'static str),
    /// The GUID is that of another model description.
    Guid,
    /// The FMU declares that it lacks this capability.
    NotSupported(&'static str),
    /// Nothing is known under this status kind.
    NoStatus(i32),
}

impl Error {
    /// The status an importer gets: `Discard` for values and steps it may correct, else `Error`.
    #[must_use]
    pub const fn status(&self) -> Status {
        match self {
            Self::NotFinite { .. }
            | Self::BelowMin { .. }
            | Self::AboveMax { .. }
            | Self::NotAnItem { .. }
            | Self::NotUtf8
            | Self::Model(Failure::StepTooLong { .. })
            | Self::NoStatus(_) => Status::Discard,
            _ => Status::Error,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::IllegalCall { call, state } => illegal(f, call, state),
            Self::UnknownReference { reference, kind } => {
                write!(
                    f,
                    "value reference {reference} is no {kind} variable of this model"
                )
            }
            Self::NotSettable {
                variable,
                state,
                remedy,
            } => {
                write!(f, "{variable} may not be set in state {state}: {remedy}")
            }
            Self::NotFinite { variable, value } => write!(f, "{variable} = {value} is not finite"),
            Self::BelowMin {
                variable,
                value,
                min,
            } => {
                write!(f, "{variable} = {} is below {}", Number(value), Number(min))
            }
            Self::AboveMax {
                variable,
                value,
                max,
            } => {
                write!(f, "{variable} = {} is above {}", Number(value), Number(max))
            }
            Self::NotAnItem {
                variable,
                value,
                enumeration,
            } => {
                write!(f, "{variable} = {value} is no value of {enumeration}")
            }
            Self::NotUtf8 => f.write_str("argument value holds a text that is not UTF-8"),
            Self::NoDerivative { variable, order } => {
                write!(f, "{variable} offers no derivative of order {order}")
            }
            Self::NotDifferentiable { variable } => {
                write!(
                    f,
                    "{variable} is not what a directional derivative takes there: Real outputs by Real inputs"
                )
            }
            Self::Experiment { start, stop } => {
                let (start, stop) = (Number(start), Number(stop));
                write!(
                    f,
                    "stop time {stop} s does not lie after start time {start} s"
                )
            }
            Self::StepTime { time, current } => {
                let (time, current) = (Number(time), Number(current));
                write!(
                    f,
                    "step starts at t = {time} s, but the model stands at {current} s"
                )
            }
            Self::StepSize { step, time } => {
                let (step, time) = (Number(step), Number(time));
                write!(
                    f,
                    "step size {step} s does not advance time from t = {time} s"
                )
            }
            Self::PastStop { end, stop } => {
                let (end, stop) = (Number(end), Number(stop));
                write!(f, "step ends at t = {end} s, after stop time {stop} s")
            }
            Self::Model(ref failure) => failure.fmt(f),
            Self::Serialised(fault) => write!(f, "serialised FMU state {fault}"),
            Self::Pointer(argument) => write!(f, "argument {argument} is no valid pointer"),
            Self::Count(count) => {
                write!(f, "{count} value references are more than the model has")
            }
            Self::Size { size, needed } => {
                write!(
                    f,
                    "argument size = {size} is below the state's {needed} bytes"
                )
            }
            Self::State => f.write_str("argument FMUstate is no live state of this FMU"),
            Self::Lengths { variables, values } => {
                write!(f, "{values} values for {variables} variables")
            }
            Self::Duplicate { variable } => write!(f, "{variable} is set twice in one call"),
            Self::UnknownCategory => unknown_category(f),
            Self::Instantiate(fault) => f.write_str(fault),
            Self::Guid => f.write_str("GUID differs: library and model description do not match"),
            Self::NotSupported(what) => write!(f, "{what} are not supported by this FMU"),
            Self::NoStatus(kind) => write!(f, "nothing is known under status kind {kind}"),
        }
    }
}

fn unknown_category(f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("a log category is none of")?;
    let mut names = Category::ALL.into_iter().map(Category::name);
    names.try_for_each(|name| write!(f, " {name}"))
}

fn illegal(f: &mut fmt::Formatter<'_>, call: Call, state: State) -> fmt::Result {
    write!(f, "{call} is illegal in state {state}; legal in: ")?;
    match call.legal() {
        [] => f.write_str("no state of this FMU"),
        [first, others @ ..] => {
            write!(f, "{first}")?;
            others.iter().try_for_each(|other| write!(f, ", {other}"))
        }
    }
}

impl std::error::Error for Error {}
