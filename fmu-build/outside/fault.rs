//! Why there is no FMU of a package.

use std::fmt;
use std::path::PathBuf;

/// Why a package cannot be made an FMU.
#[derive(Debug)]
pub enum Fault {
    /// No package of a workspace makes an FMU.
    NoPackage {
        /// Folder of the workspace.
        folder: PathBuf,
    },
    /// A package does not depend on `fmi2-cosim`.
    NoShell {
        /// The package.
        package: String,
    },
    /// A library is not of both types that are needed.
    CrateType {
        /// The package.
        package: String,
        /// The types it is of.
        found: Vec<String>,
    },
    /// There is no `fmu-build` beside the `fmi2-cosim` of a package.
    NoPacker {
        /// Folder of that `fmi2-cosim`.
        folder: PathBuf,
    },
    /// A model cannot be given the files it reads.
    Resources {
        /// Their folder.
        folder: PathBuf,
        /// Why not.
        said: String,
    },
    /// The program that describes the model was not built.
    Describer {
        /// The package.
        package: String,
    },
    /// That program told what is wrong.
    Told {
        /// The package.
        package: String,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPackage { folder } => write!(
                f,
                "no package of the workspace {} depends on fmi2-cosim and has a library of type cdylib",
                folder.display()
            ),
            Self::NoShell { package } => write!(
                f,
                "{package} does not depend on fmi2-cosim; `cargo add fmi2-cosim --path ...` adds it"
            ),
            Self::CrateType { package, found } => write!(
                f,
                "the library of {package} is of type {found:?}; write crate-type = [\"cdylib\", \"lib\"] under [lib] of \
                 its Cargo.toml: cdylib goes into the FMU, lib is what it is described from"
            ),
            Self::NoPacker { folder } => write!(
                f,
                "there is no folder fmu-build above {}; take fmi2-cosim from a copy of its whole repository",
                folder.display()
            ),
            Self::Resources { folder, said } => write!(
                f,
                "{}: the model reads files of its FMU, but {said}",
                folder.display()
            ),
            Self::Describer { package } => write!(
                f,
                "{package} could not be described; cargo told why. Where it misses FmuModel, write \
                 fmi2_cosim::export!(...) into lib.rs itself, and make the model pub"
            ),
            Self::Told { package } => write!(f, "no FMU was made of {package}"),
        }
    }
}
