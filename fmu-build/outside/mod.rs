//! FMUs of packages outside this workspace, which need no more than `fmi2_cosim::export!`.
//!
//! ```text
//! package ──cargo metadata──> its library, its fmi2-cosim ──> a program that links both: describer
//! describer ──cargo run──> pack::<FmuModel>() ──> PACKAGE's .fmu
//! ```
//!
//! What an FMU says of its model comes from the model's table, which only a program that links the model can read.
//! That program is written into the target folder of the package, and built of the `fmu-build` that lies beside the
//! `fmi2-cosim` of the package: both then speak of the same trait `Model`.

mod describer;
mod fault;
mod found;

pub use fault::Fault;

use crate::library::Target;
use crate::{Entry, Error, Result};
use describer::Describer;
use fmi2_cosim::Model;
use found::Found;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What is to be built.
#[derive(Debug, Clone, Default)]
pub struct Order<'a> {
    /// `Cargo.toml` of a package or workspace, or its folder; `None`: where cargo finds one from here.
    pub manifest: Option<&'a Path>,
    /// Folder for the FMUs; `None`: `fmu` in the target folder of the package.
    pub out: Option<&'a Path>,
    /// Targets, as [`Target::parse`] reads them; none: this machine.
    pub targets: &'a [String],
    /// Whether the libraries are to be small.
    pub small: bool,
}

/// Builds the FMUs of a package, or of all packages of a workspace that make one, and prints their paths.
///
/// # Errors
/// When there is no such package, or it cannot be built.
pub fn build(order: &Order<'_>) -> Result<()> {
    for target in order.targets {
        Target::parse(target)?;
    }
    let found = Found::by(order.manifest)?;
    let out = order
        .out
        .map_or_else(|| found.target.join("fmu"), Path::to_owned);
    let out = std::path::absolute(&out).map_err(Error::io(&out))?;
    for package in &found.packages {
        let describer = Describer::written(package, &found)?;
        describer.run(&out, order)?;
    }
    Ok(())
}

/// Whether the present folder belongs to another workspace than that of this program.
#[must_use]
pub fn is_here() -> bool {
    found::root().is_some_and(|root| !root.starts_with(crate::library::workspace()))
}

/// What the program does that links a model: packs its FMU, as the arguments tell, and prints its path.
///
/// # Errors
/// None: what goes wrong is printed.
#[must_use]
pub fn pack<M: Model>(package: &'static str, folder: &'static str) -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match packed::<M>(package, folder, &words) {
        Ok(path) => {
            let _ = writeln!(io::stdout(), "{}", path.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::from(describer::TOLD)
        }
    }
}

/// `words`: the folder for the FMU, `small` or `full`, and targets.
fn packed<M: Model>(
    package: &'static str,
    folder: &'static str,
    words: &[String],
) -> Result<PathBuf> {
    let (out, small, targets) = match words {
        [out, size, targets @ ..] => (Path::new(out), size == describer::SMALL, targets),
        _ => (Path::new("."), false, words),
    };
    let mut targets = match targets {
        [] => vec![Target::host()?],
        some => some
            .iter()
            .map(|text| Target::parse(text))
            .collect::<Result<_>>()?,
    };
    if small {
        targets = targets.into_iter().map(Target::small).collect();
    }
    crate::build_for(&Entry::of::<M>(package).at(folder), &targets, out)
}
