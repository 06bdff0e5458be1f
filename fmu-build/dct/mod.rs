//! The models of this workspace: what goes into their FMUs beside what their tables tell. Without the feature
//! `dct` this crate knows none of them.

mod about;
mod closed_loop;
mod figures;
mod icons;
pub mod models;
mod presets;
mod smoke;
pub mod sources;

use crate::table::LEGEND;
use crate::{Error, Result, archive, library};
use models::MODELS;
use std::fs;
use std::path::PathBuf;

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
    files.push((folder.join("VARIABLES.md"), variables()?));
    files.extend(presets::files()?);
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

/// The text of `VARIABLES.md`: the tables of all models for people, one section each.
fn variables() -> Result<String> {
    let mut text = format!(
        "# Variables of the FMUs\n\n\
         Written by `cargo fmu describe` from the tables in `src/models`; do not edit.\n\n\
         {LEGEND}\n"
    );
    for entry in MODELS {
        text.push('\n');
        text.push_str(&(entry.table)()?);
    }
    Ok(text)
}
