//! The types a variable can have at the interface, and when a value is legal.

use crate::row::{Row, row};
use crate::{Access, Call, Causality, Error, Model, State, Variability};

/// A type whose values the getters and setters of FMI move: `f64` (Real), `i32` (Integer, Enumeration) or `bool`.
///
/// No other type can be one: the C boundary has no function for it. `String`, whose length is not fixed, has its own
/// getter and setter; [`Typed`](crate::Typed) has it, too.
///
/// ```compile_fail,E0277
/// struct Price(f64);
/// impl fmi2_cosim::Value for Price {}
/// ```
pub trait Value: Sealed {}

impl Value for f64 {}
impl Value for i32 {}
impl Value for bool {}

/// What the shell knows of a [`Value`]. Nobody else can name it.
pub trait Sealed: Copy + 'static {
    /// FMI's name of the type.
    const KIND: &'static str;
    /// Its getter.
    const GET: Call;
    /// Its setter.
    const SET: Call;

    /// The field behind a row, if it has this type.
    fn field<M>(access: &Access<M>) -> Option<fn(&mut M) -> &mut Self>;

    /// Whether a row may have this value.
    ///
    /// # Errors
    /// When it is not finite, outside the limits of the row, or none of its enumeration.
    fn check<M>(self, row: &Row<M>) -> Result<(), Error>;

    /// Whether an importer may be handed this value of a variable.
    ///
    /// # Errors
    /// When it is not finite.
    fn number(self, _variable: &'static str) -> Result<(), Error> {
        Ok(())
    }
}

impl Sealed for f64 {
    const KIND: &'static str = "Real";
    const GET: Call = Call::GetReal;
    const SET: Call = Call::SetReal;

    fn field<M>(access: &Access<M>) -> Option<fn(&mut M) -> &mut Self> {
        match access {
            Access::Real(field) => Some(*field),
            _ => None,
        }
    }

    #[inline]
    fn check<M>(self, row: &Row<M>) -> Result<(), Error> {
        finite(row.name, self)?;
        within(row, self)
    }

    fn number(self, variable: &'static str) -> Result<(), Error> {
        finite(variable, self)
    }
}

impl Sealed for i32 {
    const KIND: &'static str = "Integer";
    const GET: Call = Call::GetInteger;
    const SET: Call = Call::SetInteger;

    fn field<M>(access: &Access<M>) -> Option<fn(&mut M) -> &mut Self> {
        match access {
            Access::Integer(field) | Access::Enumeration(field, _) => Some(*field),
            _ => None,
        }
    }

    fn check<M>(self, row: &Row<M>) -> Result<(), Error> {
        let (variable, value) = (row.name, self);
        match row.access {
            Access::Enumeration(_, kind) if kind.items.iter().all(|item| item.value != value) => {
                Err(Error::NotAnItem {
                    variable,
                    value,
                    enumeration: kind.name,
                })
            }
            _ => within(row, f64::from(value)),
        }
    }
}

impl Sealed for bool {
    const KIND: &'static str = "Boolean";
    const GET: Call = Call::GetBoolean;
    const SET: Call = Call::SetBoolean;

    fn field<M>(access: &Access<M>) -> Option<fn(&mut M) -> &mut Self> {
        match access {
            Access::Boolean(field) => Some(*field),
            _ => None,
        }
    }

    fn check<M>(self, _: &Row<M>) -> Result<(), Error> {
        Ok(())
    }
}

/// Where a row's value lives.
pub(crate) type Field<M, T> = fn(&mut M) -> &mut T;

/// The row of a value reference, with its field of type `T`.
#[inline]
pub(crate) fn find<M: Model, T: Value>(
    reference: u32,
) -> Result<(&'static Row<M>, Field<M, T>), Error> {
    match row::<M>(reference).and_then(|row| Some((row, T::field(&row.access)?))) {
        Some(found) => Ok(found),
        None => Err(unknown::<T>(reference)),
    }
}

#[cold]
fn unknown<T: Value>(reference: u32) -> Error {
    let kind = T::KIND;
    Error::UnknownReference { reference, kind }
}

/// Whether the row may be set in this state (notes 1, 3 and 6 of the table in FMI 2.0.4, 4.2.4).
///
/// Note 1 leaves out inputs in `instantiated`, but importers set them there.
#[inline]
pub(crate) fn settable<M>(row: &Row<M>, state: State) -> Result<(), Error> {
    let legal = match row.causality {
        Causality::Input => true,
        Causality::Parameter => {
            state != State::StepComplete || row.variability == Variability::Tunable
        }
        Causality::Output | Causality::Local => false,
    };
    if legal {
        Ok(())
    } else {
        Err(not_settable(row, state))
    }
}

#[cold]
fn not_settable<M>(row: &Row<M>, state: State) -> Error {
    Error::NotSettable {
        variable: row.name,
        state,
        remedy: match row.causality {
            Causality::Parameter => {
                "it is a fixed parameter; set it before initialisation ends, or after fmi2Reset"
            }
            _ if row.computed => "the model computes it; set what it depends on",
            _ => "it is a constant",
        },
    }
}

/// Refuses a call that has not as many values as variables.
pub(crate) fn as_many(variables: usize, values: usize) -> Result<(), Error> {
    if variables == values {
        Ok(())
    } else {
        Err(Error::Lengths { variables, values })
    }
}

/// Refuses NaN and infinities.
pub(crate) fn finite(variable: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(Error::NotFinite { variable, value })
    }
}

fn within<M>(row: &Row<M>, value: f64) -> Result<(), Error> {
    let Row { name, min, max, .. } = *row;
    if value < min {
        Err(Error::BelowMin {
            variable: name,
            value,
            min,
        })
    } else if value > max {
        Err(Error::AboveMax {
            variable: name,
            value,
            max,
        })
    } else {
        Ok(())
    }
}
