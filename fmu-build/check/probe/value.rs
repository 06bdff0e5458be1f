//! A value of any type, as it crosses the C interface.

use super::super::native::{Instance, Refused};
use super::super::parsed::Kind;
use crate::Result;
use std::fmt;

/// A value as read from the library.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Real(f64),
    Integer(i32),
    Boolean(bool),
    String(String),
}

impl Value {
    /// Reads a variable.
    pub(super) fn read(
        instance: &Instance<'_>,
        kind: Kind,
        reference: u32,
    ) -> Result<std::result::Result<Self, Refused>> {
        Ok(match kind {
            Kind::Real => instance.real(reference)?.map(Self::Real),
            Kind::Integer => instance.integer(reference)?.map(Self::Integer),
            Kind::Boolean => instance.boolean(reference)?.map(Self::Boolean),
            Kind::String => instance.string(reference)?.map(Self::String),
        })
    }

    /// The value that a text of a description means.
    pub(super) fn parse(kind: Kind, text: &str) -> Option<Self> {
        match kind {
            Kind::Real => text.trim().parse().ok().map(Self::Real),
            Kind::Integer => text.trim().parse().ok().map(Self::Integer),
            Kind::Boolean => Some(Self::Boolean(matches!(text.trim(), "true" | "1"))),
            Kind::String => Some(Self::String(text.into())),
        }
    }

    /// Sets a variable of its type.
    pub(super) fn set(
        &self,
        instance: &Instance<'_>,
        reference: u32,
    ) -> Result<std::result::Result<(), Refused>> {
        match self {
            Self::Real(value) => instance.set_real(reference, *value),
            Self::Integer(value) => instance.set_integer(reference, *value),
            Self::Boolean(value) => instance.set_boolean(reference, *value),
            Self::String(value) => instance.set_string(reference, value),
        }
    }

    /// A Real's value.
    pub(super) fn real(&self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(*value),
            _ => None,
        }
    }

    /// Whether both are equal to the last bit.
    pub(super) fn same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Real(one), Self::Real(other)) => one.to_bits() == other.to_bits(),
            (Self::Integer(one), Self::Integer(other)) => one == other,
            (Self::Boolean(one), Self::Boolean(other)) => one == other,
            (Self::String(one), Self::String(other)) => one == other,
            _ => false,
        }
    }

    /// Whether `text` of a description means exactly this value.
    pub(super) fn equals(&self, text: &str) -> bool {
        match self {
            Self::Real(value) => text
                .trim()
                .parse::<f64>()
                .is_ok_and(|start| start.to_bits() == value.to_bits()),
            Self::Integer(value) => text.trim().parse() == Ok(*value),
            Self::Boolean(value) => matches!(text.trim(), "true" | "1") == *value,
            Self::String(value) => text == value,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Real(value) => write!(f, "{value:?}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::String(value) => write!(f, "{value:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_compared_to_the_last_bit() {
        assert!(Value::Real(0.1 + 0.2).equals("0.30000000000000004"));
        assert!(!Value::Real(0.1 + 0.2).equals("0.3"));
        assert!(Value::Boolean(true).equals("1"));
        assert!(!Value::Integer(2).equals("3"));
    }
}
