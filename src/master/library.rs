//! FMU files that are unpacked and described, each once.

use crate::description::Description;
use crate::error::Error;
use crate::package;
use fmi::fmi2::import::Fmi2Import;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An unpacked FMU; any number of instances may be made of it, also by several threads.
pub struct Library {
    pub(crate) import: Fmi2Import,
    description: Description,
    pub(crate) path: PathBuf,
}

impl Library {
    /// Unpacks and reads an FMU file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let (import, xml) = package::open(path)?;
        let description = Description::parse(&xml).map_err(|what| Error::Content {
            path: path.to_owned(),
            line: 0,
            what: format!("modelDescription.xml: {what}"),
        })?;
        Ok(Self {
            import,
            description,
            path: path.to_owned(),
        })
    }

    /// What it says of its variables.
    pub fn description(&self) -> &Description {
        &self.description
    }
}

/// FMU files that are open, each once however many components and runs use it.
#[derive(Default, Clone)]
pub struct Libraries(HashMap<PathBuf, Arc<Library>>);

impl Libraries {
    /// The library of a file, opened when it is not yet.
    pub fn open(&mut self, path: &Path) -> Result<Arc<Library>, Error> {
        if let Some(known) = self.0.get(path) {
            return Ok(known.clone());
        }
        let library = Arc::new(Library::open(path)?);
        self.0.insert(path.to_owned(), library.clone());
        Ok(library)
    }
}
