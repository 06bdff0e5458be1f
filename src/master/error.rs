//! Everything that can go wrong, as sentences that name the component, file or variable.

use fmi::fmi2::Fmi2Error;
use std::fmt;
use std::path::PathBuf;

/// Why a run could not start or go on.
#[derive(Debug)]
pub enum Error {
    /// The command line or the call makes no sense.
    Usage(String),
    /// A file could not be read or written.
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system said.
        error: std::io::Error,
    },
    /// A scenario is not a table of numbers over increasing time.
    Scenario {
        /// The file.
        path: PathBuf,
        /// Line, starting with 1.
        line: usize,
        /// What is wrong there.
        what: String,
    },
    /// An FMU does not load.
    Load {
        /// The file.
        path: PathBuf,
        /// What the `fmi` crate said.
        error: Box<fmi::Error>,
    },
    /// A variable that does not exist, or has another type or causality than needed.
    Variable {
        /// `component.variable`.
        name: String,
        /// What is wrong with it.
        what: &'static str,
    },
    /// An FMU function failed.
    Call {
        /// Component name.
        component: String,
        /// C name of the function.
        function: &'static str,
        /// Communication point [s].
        time: f64,
        /// The status it returned.
        status: Fmi2Error,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => write!(f, "{what}"),
            Self::File { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Scenario { path, line, what } => write!(f, "{}:{line}: {what}", path.display()),
            Self::Load { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Variable { name, what } => write!(f, "'{name}' {what}"),
            Self::Call {
                component,
                function,
                time,
                status,
            } => {
                write!(
                    f,
                    "{component}: {function} at t = {time} s returned {status}"
                )
            }
        }
    }
}

impl std::error::Error for Error {}
