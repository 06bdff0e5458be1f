//! Everything that can go wrong, as sentences that name the component, file or variable.

use std::fmt;
use std::io::ErrorKind;
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
        /// What it returned, and the last messages of the FMU.
        what: String,
    },
    /// An FMU does not return from a call.
    Stuck {
        /// Component name.
        component: String,
        /// C name of the function.
        function: &'static str,
        /// Communication point [s].
        time: f64,
        /// Why it is not waited for, and the last messages of the FMU.
        what: String,
    },
    /// An FMU asked to end the simulation (fmi2Terminated) before the run's stop.
    Over {
        /// Component name.
        component: String,
        /// Where it wants it to end [s].
        time: f64,
    },
    /// A run was ended from outside.
    Ended {
        /// Communication point [s].
        time: f64,
    },
    /// A value has no code in a mapping.
    Coding(String),
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
    /// Whether the FMUs ran and one of them failed or ended the run, rather than the question being wrong.
    pub fn is_at_run_time(&self) -> bool {
        matches!(
            self,
            Self::Call { .. } | Self::Over { .. } | Self::Coding(_) | Self::Value { .. }
        )
    }

    /// Whether a file is no usable FMU.
    pub fn is_of_an_fmu(&self) -> bool {
        matches!(self, Self::Load { .. } | Self::Platform { .. })
    }

    /// `name` is `value` at `time` [s].
    pub(crate) fn no_number(name: &str, value: f64, time: f64) -> Self {
        Self::Value {
            name: name.to_owned(),
            value,
            time,
            what: "no finite number",
        }
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
            Self::Usage(what) | Self::Coding(what) => write!(f, "{what}"),
            Self::File { path, error } => write!(f, "{}: {}", path.display(), words(error)),
            Self::Content {
                path,
                line: 0,
                what,
            } => write!(f, "{}: {what}", path.display()),
            Self::Content { path, line, what } => write!(f, "{}:{line}: {what}", path.display()),
            Self::Load { path, error } => match error.as_ref() {
                fmi::Error::Io(error) if error.kind() == ErrorKind::NotFound => {
                    let (path, words) = (path.display(), words(error));
                    write!(f, "{path}: {words} (--fmu-dir says where FMUs are)")
                }
                error => write!(f, "{}: {error}", path.display()),
            },
            Self::Platform {
                path,
                library,
                there,
            } => write!(
                f,
                "{}: has no {library}; it has libraries for: {}",
                path.display(),
                match there.as_slice() {
                    [] => "none".into(),
                    some => some.join(", "),
                }
            ),
            Self::Variable { name, what } => write!(f, "'{name}' {what}"),
            Self::Call {
                component,
                function,
                time,
                what,
            } => {
                let time = Seconds(*time);
                write!(f, "{component}: {function} at t = {time} s {what}")
            }
            Self::Stuck {
                component,
                function,
                time,
                what,
            } => {
                let time = Seconds(*time);
                write!(
                    f,
                    "{component}: {function} at t = {time} s does not return: {what}"
                )
            }
            Self::Over { component, time } => {
                write!(f, "{component} {}, before the run's stop", asks_end(*time))
            }
            Self::Ended { time } => write!(f, "stopped at t = {} s", Seconds(*time)),
            Self::Value {
                name,
                value,
                time,
                what,
            } => {
                let time = Seconds(*time);
                write!(f, "{name} is {value} at t = {time} s: {what}")
            }
        }
    }
}

impl std::error::Error for Error {}

/// What is told of an FMU that asked to end the simulation at a time [s].
pub fn asks_end(time: f64) -> String {
    let time = Seconds(time);
    format!("asked to end the simulation at {time} s (fmi2Terminated)")
}

/// What the operating system said, without its number.
fn words(error: &std::io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error")
        .next()
        .unwrap_or_default()
        .to_owned()
}

/// A time [s] as `dct-harness` writes it, so that both tell of a failure in the same words: shortest
/// form, rounded to 1 ns.
#[derive(Debug, Clone, Copy)]
pub struct Seconds(pub f64);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded: f64 = format!("{:.9}", self.0).parse().unwrap_or(self.0);
        (rounded + 0.0).fmt(f) // no -0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_written_as_python_does() {
        // The cases of tests/test_harness_loop.py.
        for (time, text) in [
            (0.0, "0"),
            (-1e-12, "0"),
            (0.491, "0.491"),
            (9.411_999_999_999_999, "9.412"),
            (30.0, "30"),
            (1.5e-5, "0.000015"),
            (12_345_678.25, "12345678.25"),
            (1e16, "10000000000000000"),
        ] {
            assert_eq!(Seconds(time).to_string(), text);
        }
    }
}
