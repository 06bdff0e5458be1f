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
mod compiler;
mod content;
#[cfg(feature = "dct")]
mod dct;
mod description;
mod drive;
mod entry;
mod error;
pub mod icon;
pub mod library;
mod merge;
mod metadata;
pub mod outside;
mod page;
pub mod parameters;
pub mod port;
pub mod ssp;
mod suggest;
mod table;
mod variables_md;
mod xml;

pub use archive::{Untrusted, package};
pub use check::{Finding, Options, Replay, Report, Severity, check, check_with, probe, replay};
#[cfg(feature = "dct")]
pub use dct::{compare, descriptions, models, refresh, sources};
pub use description::describe;
pub use entry::{Entry, Figures, Smoke};
pub use error::{Error, Result};
pub use merge::merge;

use library::Target;
use std::path::{Path, PathBuf};

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
