//! The models this workspace makes FMUs of: the one list that `describe` and `build` go through.

use crate::{Error, Result, describe, library, page, variables_md};
use dct_models::{ClutchControl, Observer, Plant};
use fmi2_cosim::Model;
use std::path::Path;

/// A model and the package of its FMU library.
pub struct Entry {
    /// `modelIdentifier`, and the name of the FMU and of its description.
    pub name: &'static str,
    /// Cargo package whose dynamic library implements it.
    pub package: &'static str,
    /// Folder of that package or of its workspace; `None`: this workspace.
    folder: Option<&'static str>,
    /// Writes the text of its `modelDescription.xml`.
    pub describe: fn() -> Result<String>,
    /// Writes its section of `VARIABLES.md`.
    pub table: fn() -> Result<String>,
    /// Writes the documentation page inside its FMU.
    pub page: fn() -> Result<String>,
}

impl Entry {
    /// The entry of model `M`, whose library is made by the cargo package `package`.
    #[must_use]
    pub const fn of<M: Model>(package: &'static str) -> Self {
        Self {
            name: M::NAME,
            package,
            folder: None,
            describe: describe::<M>,
            table: variables_md::section::<M>,
            page: page::page::<M>,
        }
    }

    /// Says where cargo finds the package: `env!("CARGO_MANIFEST_DIR")` of a package outside this
    /// workspace.
    #[must_use]
    pub const fn at(mut self, folder: &'static str) -> Self {
        self.folder = Some(folder);
        self
    }

    /// Builds the library of this platform and returns its bytes.
    ///
    /// # Errors
    /// When cargo fails or the package makes no dynamic library.
    pub fn library(&self) -> Result<Vec<u8>> {
        library::build(self.package, self.folder())
    }

    /// Folder in which cargo finds the package.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.map_or(library::workspace(), Path::new)
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
