//! What can go wrong, one variant per cause; each text says what to do where something can be done.

use crate::archive::Untrusted;
use crate::suggest::did_you_mean;
use fmi2_cosim::Seconds;
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// Result of everything in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Names of `fmi2Status`, in its order.
const STATUS: [&str; 6] = [
    "fmi2OK",
    "fmi2Warning",
    "fmi2Discard",
    "fmi2Error",
    "fmi2Fatal",
    "fmi2Pending",
];

/// Why a description, a package or a check could not be made.
#[derive(Debug)]
pub enum Error {
    /// A number of the table or a start value is NaN or infinite.
    NotFinite {
        /// Name of the variable.
        variable: String,
        /// Which of its numbers, e.g. `start`.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A row names a dependency that is not a row.
    UnknownDependency {
        /// Name of the variable.
        variable: String,
        /// The name it depends on.
        dependency: String,
    },
    /// A unit or an enumeration has the name of another one before it: `unit` or `enumeration`, name, variable.
    TwoMeanings([&'static str; 3]),
    /// No model of this name is known.
    UnknownModel {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<&'static str>,
    },
    /// Committed descriptions differ from what the models say.
    Stale {
        /// Files that differ or are missing.
        files: Vec<PathBuf>,
    },
    /// A model refused a call, or failed.
    Model(fmi2_cosim::Error),
    /// A parameter set does not fit its model.
    ParameterSet {
        /// What does not fit.
        fault: String,
    },
    /// A file could not be read or written.
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A folder stands where an FMU is expected.
    Folder {
        /// The folder.
        path: PathBuf,
        /// What to do instead.
        remedy: String,
    },
    /// A system is to be made of an FMU that was not built.
    NotBuilt {
        /// The FMU.
        path: PathBuf,
    },
    /// A file is not a readable ZIP archive, or could not be written as one.
    Zip {
        /// The file.
        path: PathBuf,
        /// What the archive library said.
        source: zip::result::ZipError,
    },
    /// An archive that nobody should unpack, or a file that cannot be packed.
    Untrusted {
        /// The file.
        path: PathBuf,
        /// Why.
        fault: Untrusted,
    },
    /// A model description could not be written.
    Write(quick_xml::SeError),
    /// A model description could not be read.
    Parse(quick_xml::DeError),
    /// A modelIdentifier that is a path: as the name of a library it leads out of the FMU.
    Identifier(String),
    /// `cargo build` of an FMU library failed; its output tells why.
    Cargo {
        /// The package.
        package: String,
    },
    /// No compiler has the sources of its standard library.
    NoSources,
    /// `cargo build` succeeded without making a dynamic library.
    NoLibrary {
        /// The package.
        package: String,
    },
    /// An input of a system has two sources.
    TwoSources {
        /// The input, as `<component>.<variable>`.
        variable: String,
        /// The components with an output of its name.
        components: [&'static str; 2],
    },
    /// Two FMUs are not of one model, or differ in what they should share.
    Unlike {
        /// The member that differs.
        member: String,
        /// The FMUs.
        fmus: [PathBuf; 2],
    },
    /// A component failed in a run.
    Run {
        /// Its name.
        component: String,
        /// The variable and its value with `: `, where one was to be set.
        setting: String,
        /// Time of the communication point [s].
        time: f64,
        /// What it failed with.
        source: Box<Error>,
    },
    /// An FMU refused a call.
    Refused {
        /// The function.
        function: &'static str,
        /// The `fmi2Status` it returned.
        status: i32,
        /// What it logged.
        messages: String,
    },
    /// A table of inputs cannot be used.
    Stimuli {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// A communication step that does not advance, or more of them than anybody waits for.
    Step {
        /// The step [s].
        step: f64,
        /// First and last time of the run [s].
        times: (f64, f64),
    },
    /// A table gives an Integer a value that is none.
    NotWhole {
        /// Name of the variable.
        variable: String,
        /// The value.
        value: f64,
        /// Time of the communication point [s].
        time: f64,
    },
    /// `cargo metadata` failed or said what is not understood.
    Metadata {
        /// What it said.
        said: String,
    },
    /// `SOURCE_DATE_EPOCH` is no number of seconds.
    Epoch {
        /// Its value.
        value: String,
    },
    /// This machine has no platform name in FMI 2.0.
    UnknownPlatform {
        /// Operating system and architecture.
        platform: String,
    },
    /// There is no probe of this name.
    UnknownProbe {
        /// The name.
        name: String,
    },
    /// A package cannot be made an FMU.
    Outside(crate::outside::Fault),
    /// A library could not be loaded or lacks what a check needs.
    Load {
        /// The library.
        path: PathBuf,
        /// What the loader said.
        source: libloading::Error,
    },
}

impl Error {
    /// What the system said of a file or a program.
    pub(crate) fn io(path: impl AsRef<Path>) -> impl FnOnce(io::Error) -> Self {
        let path = path.as_ref().to_owned();
        |source| Self::Io { path, source }
    }

    /// What the archive library said of a file.
    pub(crate) fn zip(path: impl AsRef<Path>) -> impl FnOnce(zip::result::ZipError) -> Self {
        let path = path.as_ref().to_owned();
        |source| Self::Zip { path, source }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite {
                variable,
                what,
                value,
            } => {
                write!(f, "{variable}: {what} = {value} is not finite")
            }
            Self::UnknownDependency {
                variable,
                dependency,
            } => {
                write!(
                    f,
                    "{variable} depends on {dependency}, which is not a variable of the model"
                )
            }
            Self::TwoMeanings([what, name, variable]) => write!(
                f,
                "{what} {name} of {variable} is not the {name} of a variable before it: rename it"
            ),
            Self::UnknownModel { name, known } => write!(
                f,
                "there is no model {name}; the models are {}{}",
                known.join(", "),
                did_you_mean(name, known.iter().copied())
            ),
            Self::Stale { files } => {
                writeln!(f, "out of date:")?;
                files
                    .iter()
                    .try_for_each(|file| writeln!(f, "  {}", file.display()))?;
                write!(f, "run `cargo fmu describe` and commit the result")
            }
            Self::Model(error) => write!(f, "{error}"),
            Self::ParameterSet { fault } => write!(f, "parameter set: {fault}"),
            Self::Io { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Folder { path, remedy } => {
                write!(f, "{} is a folder, not an FMU: {remedy}", path.display())
            }
            Self::NotBuilt { path } => {
                let folder = path.parent().unwrap_or(path).display();
                write!(
                    f,
                    "there is no {}; `cargo fmu build --out {folder}` makes it",
                    path.display()
                )
            }
            Self::Zip { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Untrusted { path, fault } => write!(f, "{}: {fault}", path.display()),
            Self::Write(source) => write!(f, "modelDescription.xml cannot be written: {source}"),
            Self::Parse(source) => write!(f, "modelDescription.xml cannot be read: {source}"),
            Self::Identifier(name) => write!(f, "modelIdentifier {name:?} is a path"),
            Self::Cargo { package } => write!(f, "`cargo build --package {package}` failed"),
            Self::NoSources => write!(
                f,
                "a small library needs the sources of the standard library, which neither rustc nor /usr/bin/rustc has; \
                 `rustup component add rust-src` brings them, on Debian `apt-get install cargo-web rust-web-src`"
            ),
            Self::NoLibrary { package } => {
                write!(
                    f,
                    "{package} has no dynamic library; its crate-type must be cdylib"
                )
            }
            Self::TwoSources {
                variable,
                components: [one, other],
            } => write!(
                f,
                "{variable}: both {one} and {other} have an output of this name"
            ),
            Self::Unlike {
                member,
                fmus: [one, other],
            } => write!(
                f,
                "{} and {} differ in {member}: only FMUs of one build of one model can be merged",
                one.display(),
                other.display()
            ),
            Self::Run {
                component,
                setting,
                time,
                source,
            } => write!(
                f,
                "{component} at t = {} s: {setting}{source}",
                Seconds(*time)
            ),
            Self::Refused {
                function,
                status,
                messages,
            } => {
                let status = usize::try_from(*status).ok();
                let name = status.and_then(|status| STATUS.get(status));
                write!(
                    f,
                    "{function} returned {}",
                    name.unwrap_or(&"no fmi2Status")
                )?;
                match messages.as_str() {
                    "" => f.write_str(" and logged nothing"),
                    said => write!(f, ": {said}"),
                }
            }
            Self::Stimuli { path, line, what } => {
                write!(f, "{}, line {line}: {what}", path.display())
            }
            Self::Step {
                step,
                times: (start, stop),
            } => write!(
                f,
                "steps of {step} s do not lead from {start} s to {stop} s; choose a longer step, above 0"
            ),
            Self::NotWhole {
                variable,
                value,
                time,
            } => write!(
                f,
                "{variable} = {value} at t = {} s: it is an Integer, so give it a whole number of 32 bits",
                Seconds(*time)
            ),
            Self::Metadata { said } => write!(f, "`cargo metadata` failed: {}", said.trim_end()),
            Self::Epoch { value } => write!(
                f,
                "SOURCE_DATE_EPOCH = {value} is no number of seconds since 1970"
            ),
            Self::UnknownPlatform { platform } => {
                write!(f, "FMI 2.0 has no name for the platform {platform}")
            }
            Self::UnknownProbe { name } => write!(f, "there is no probe {name}"),
            Self::Outside(fault) => write!(f, "{fault}"),
            Self::Load { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

/// Without a source: the text tells the cause, and what prints a chain would say it twice.
impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::Error;

    #[test]
    fn a_cause_is_told_once() {
        let missing = std::fs::read("no/such/file").unwrap_err();
        let (cause, error) = (missing.to_string(), Error::io("no/such/file")(missing));
        let chain: Vec<_> =
            std::iter::successors(Some(&error as &dyn std::error::Error), |error| {
                error.source()
            })
            .map(ToString::to_string)
            .collect();
        assert_eq!(chain, [format!("no/such/file: {cause}")]);
    }
}
