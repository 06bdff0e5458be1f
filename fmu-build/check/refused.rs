//! What an FMU refused, as an error of this program, with what it logged meanwhile.

use super::native::{Refused, take_messages};
use crate::{Error, Result};

/// A function that did not return fmi2OK.
pub(super) fn refused(function: &'static str, status: i32) -> Error {
    Error::Refused {
        function,
        status,
        messages: take_messages().join("; "),
    }
}

/// A refusal as an error, with what the FMU logged.
pub(super) fn done<T>(called: std::result::Result<T, Refused>) -> Result<T> {
    called.map_err(|call| refused(call.function, call.status))
}
