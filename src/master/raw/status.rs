//! The status of a call that was not carried out.

use fmi::fmi2::binding::{self, fmi2Status};
use std::fmt;

/// Why a call was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// fmi2Discard: with another step, or another value, it might be.
    Discard,
    /// fmi2Error.
    Error,
    /// fmi2Fatal: all instances of the FMU are lost.
    Fatal,
    /// fmi2Pending: the FMU goes on by itself, for which nobody waits here.
    Pending,
    /// A number that is no fmi2Status.
    Unknown(fmi2Status),
    /// The FMU's library has no such function.
    Missing,
}

impl Status {
    /// OK and Warning are well.
    #[inline]
    pub(crate) fn check(status: fmi2Status) -> Result<(), Self> {
        match status {
            binding::fmi2Status_fmi2OK | binding::fmi2Status_fmi2Warning => Ok(()),
            other => Err(Self::of(other)),
        }
    }

    #[cold]
    fn of(status: fmi2Status) -> Self {
        match status {
            binding::fmi2Status_fmi2Discard => Self::Discard,
            binding::fmi2Status_fmi2Error => Self::Error,
            binding::fmi2Status_fmi2Fatal => Self::Fatal,
            binding::fmi2Status_fmi2Pending => Self::Pending,
            other => Self::Unknown(other),
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(number) => write!(f, "{number}"),
            Self::Missing => write!(f, "nothing: the FMU has no such function"),
            known => write!(f, "fmi2{known:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_a_status_and_none_a_panic() {
        let told = |number| Status::check(number).map_err(|status| status.to_string());
        assert_eq!((told(0), told(1)), (Ok(()), Ok(())));
        for (number, name) in [
            (2, "fmi2Discard"),
            (3, "fmi2Error"),
            (4, "fmi2Fatal"),
            (5, "fmi2Pending"),
            (77, "77"),
        ] {
            assert_eq!(told(number), Err(name.to_owned()));
        }
    }
}
