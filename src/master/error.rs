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
    /// A file does not say what it should.
    Content {
        /// The file.
        path: PathBuf,
        /// Line, starting with 1; 0 for the file as a whole.
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
    /// An FMU has no library for this platform.
    Platform {
        /// The file.
        path: PathBuf,
        /// The library that would be needed.
        library: String,
        /// Platforms that it has libraries for.
        there: Vec<String>,
    },
    /// A variable that does not exist, or has another type, causality or source than needed.
    Variable {
        /// `component.variable`.
        name: String,
        /// What is wrong with it.
        what: String,
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
    /// A signal left the finite numbers, or has no row in a table.
    Value {
        /// `component.variable`.
        name: String,
        /// Its value.
        value: f64,
        /// Communication point [s].
        time: f64,
        /// What is wrong with it.
        what: &'static str,
    },
}

impl Error {
    /// Whether the FMUs ran and one of them failed, rather than the question being wrong.
    pub fn is_at_run_time(&self) -> bool {
        matches!(self, Self::Call { .. } | Self::Value { .. })
    }

    /// Whether a file is no usable FMU.
    pub fn is_of_an_fmu(&self) -> bool {
        matches!(self, Self::Load { .. } | Self::Platform { .. })
    }

    pub(crate) fn variable(name: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Variable {
            name: name.into(),
            what: what.into(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(what) => write!(f, "{what}"),
            Self::File { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Content {
                path,
                line: 0,
                what,
            } => write!(f, "{}: {what}", path.display()),
            Self::Content { path, line, what } => write!(f, "{}:{line}: {what}", path.display()),
            Self::Load { path, error } => write!(f, "{}: {error}", path.display()),
            Self::Platform {
                path,
                library,
                there,
            } => write!(
                f,
                "{}: has no {library}; it has libraries for: {}",
                path.display(),
                there.join(", ")
            ),
            Self::Variable { name, what } => write!(f, "'{name}' {what}"),
            Self::Call {
                component,
                function,
                time,
                status,
            } => write!(
                f,
                "{component}: {function} at t = {time} s returned {status}; \
                 `dct-harness run` tells what the FMU says of it"
            ),
            Self::Value {
                name,
                value,
                time,
                what,
            } => write!(f, "{name} is {value} at t = {time} s: {what}"),
        }
    }
}

impl std::error::Error for Error {}
