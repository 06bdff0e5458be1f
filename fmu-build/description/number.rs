//! Numbers as text that reads back as the same bits.

use crate::{Error, Result};

/// The shortest text that parses to exactly `value`; NaN and infinities have no place in a file.
pub(crate) fn finite(variable: &str, what: &'static str, value: f64) -> Result<String> {
    if value.is_finite() {
        Ok(format!("{value:?}"))
    } else {
        Err(Error::NotFinite {
            variable: variable.to_owned(),
            what,
            value,
        })
    }
}

/// [`finite`] of a number that may be absent.
pub(super) fn optional(
    variable: &str,
    what: &'static str,
    value: Option<f64>,
) -> Result<Option<String>> {
    value.map(|value| finite(variable, what, value)).transpose()
}

/// A limit of an Integer or Enumeration: no fraction, no exponent.
pub(super) fn integer(
    variable: &str,
    what: &'static str,
    value: Option<f64>,
) -> Result<Option<String>> {
    let Some(value) = value else { return Ok(None) };
    finite(variable, what, value)?;
    Ok(Some(format!("{value:.0}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_as_the_same_bits() {
        for value in [
            0.1,
            -0.0,
            1e-300,
            5e-324,
            f64::MAX,
            30.0 / std::f64::consts::PI,
            1e16,
        ] {
            let text = finite("x", "start", value).unwrap();
            assert_eq!(
                text.parse::<f64>().unwrap().to_bits(),
                value.to_bits(),
                "{text}"
            );
        }
    }

    #[test]
    fn a_number_that_is_not_finite_is_refused_by_name() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = finite("wheel.radius", "start", value).unwrap_err();
            assert!(
                error.to_string().starts_with("wheel.radius: start = "),
                "{error}"
            );
        }
    }
}
