//! The models this workspace makes FMUs of: the one list that `describe` and `build` go through.

use crate::{Error, Result, describe, page, variables_md};
use dct_models::{ClutchControl, Observer, Plant};
use fmi2_cosim::Model;

/// A model and the package of its FMU library.
pub struct Entry {
    /// `modelIdentifier`, and the name of the FMU and of its description.
    pub name: &'static str,
    /// Cargo package whose dynamic library implements it.
    pub package: &'static str,
    /// Writes the text of its `modelDescription.xml`.
    pub describe: fn() -> Result<String>,
    /// Writes its section of `VARIABLES.md`.
    pub table: fn() -> Result<String>,
    /// Writes the documentation page inside its FMU.
    pub page: fn() -> Result<String>,
}

impl Entry {
    const fn of<M: Model>(package: &'static str) -> Self {
        Self {
            name: M::NAME,
            package,
            describe: describe::<M>,
            table: variables_md::section::<M>,
            page: page::page::<M>,
        }
    }
}

/// All models, in the order in which a signal passes through them.
pub const MODELS: &[Entry] = &[
    Entry::of::<Plant>("dct-plant"),
    Entry::of::<Observer>("dct-observer"),
    Entry::of::<ClutchControl>("dct-clutch-control"),
];

/// Names of all models.
#[must_use]
pub fn names() -> Vec<&'static str> {
    MODELS.iter().map(|entry| entry.name).collect()
}

/// The models of these names; all when none is named.
///
/// # Errors
/// When there is no model of a name.
pub fn select(names: &[String]) -> Result<Vec<&'static Entry>> {
    if names.is_empty() {
        return Ok(MODELS.iter().collect());
    }
    let find = |name: &String| {
        let entry = MODELS.iter().find(|entry| entry.name == name);
        entry.ok_or_else(|| Error::UnknownModel { name: name.clone() })
    };
    names.iter().map(find).collect()
}
