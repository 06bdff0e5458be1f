//! Describes, builds and checks FMI 2.0 co-simulation FMUs.
//!
//! ```text
//! Model::VARIABLES ──describe──> modelDescription.xml ─┐
//! cdylib of the model ──cargo build──> .so, .dll ──────┴─package──> .fmu ──check──> findings
//! ```
//!
//! Everything written is a function of the models alone: no date, no random GUID, no path of the
//! machine. Two builds give the same bytes.

#![deny(unsafe_code)]

pub mod about;
mod archive;
pub mod binary;
mod check;
mod closed_loop;
mod compiler;
mod content;
mod description;
mod drive;
mod entry;
mod error;
mod figures;
pub mod icon;
pub mod library;
mod merge;
pub mod models;
mod page;
pub mod parameters;
pub mod port;
mod smoke;
pub mod ssp;
mod suggest;
mod table;
mod variables_md;
mod xml;

pub use archive::package;
pub use check::{Finding, Options, Replay, Report, Severity, check, check_with, probe, replay};
pub use description::describe;
pub use entry::{Entry, Smoke};
pub use error::{Error, Result};
pub use merge::merge;

use library::Target;
use models::MODELS;
use std::fs;
use std::path::{Path, PathBuf};

/// The models whose descriptions the harness holds a supplier's plant to.
const CONTRACT: [&str; 2] = ["DctPlant", "DctObserver"];

/// Every file of `modelDescription/` with its text, the harness's copies of the contract, and the
/// parameter files of the presets.
///
/// # Errors
/// When a model cannot be described.
pub fn descriptions() -> Result<Vec<(PathBuf, String)>> {
    let folder = library::workspace().join("modelDescription");
    let contract = library::workspace().join("tests/harness/dct_harness/contract");
    let mut files = Vec::new();
    for entry in MODELS {
        let (name, text) = (format!("{}.xml", entry.name), (entry.describe)()?);
        if CONTRACT.contains(&entry.name) {
            files.push((contract.join(&name), text.clone()));
        }
        files.push((folder.join(name), text));
    }
    files.push((folder.join("VARIABLES.md"), variables_md::text(MODELS)?));
    files.extend(parameters::files()?);
    Ok(files)
}

/// Writes `modelDescription/` and the parameter files; returns the files.
///
/// # Errors
/// When a model cannot be described or a file not be written.
pub fn refresh() -> Result<Vec<PathBuf>> {
    let files = descriptions()?;
    for (path, text) in &files {
        archive::write_whole(path, text.as_bytes())?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// Compares `modelDescription/` and the parameter files with what the models say.
///
/// # Errors
/// [`Error::Stale`] with the files that differ and the command that refreshes them.
pub fn compare() -> Result<()> {
    let differs = |(path, text): &(PathBuf, String)| {
        fs::read_to_string(path).map_or(true, |found| found != *text)
    };
    let stale = descriptions()?
        .into_iter()
        .filter(differs)
        .map(|(path, _)| path);
    let files: Vec<_> = stale.collect();
    if files.is_empty() {
        Ok(())
    } else {
        Err(Error::Stale { files })
    }
}

/// Builds the FMU of a model for this machine into folder `out`; returns its path.
///
/// # Errors
/// When the library cannot be built or the file not be written.
pub fn build(entry: &Entry, out: &Path) -> Result<PathBuf> {
    build_for(entry, &[Target::host()?], out)
}

/// Builds the FMU of a model for these targets into folder `out`; returns its path.
///
/// # Errors
/// When a library cannot be built or the file not be written.
pub fn build_for(entry: &Entry, targets: &[Target], out: &Path) -> Result<PathBuf> {
    let mut members = content::members(entry)?;
    for target in targets {
        members.push((target.member(entry.name), entry.library(target)?));
    }
    let path = out.join(format!("{}.fmu", entry.name));
    package(&path, content::with_dependencies(members))?;
    Ok(path)
}
