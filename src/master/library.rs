//! FMU files that are unpacked and described, each once.

use crate::description::Description;
use crate::error::Error;
use crate::package;
use cosim_raw::Loaded;
use fmi::fmi2::import::Fmi2Import;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// An unpacked FMU; any number of instances may be made of it, also by several threads.
pub struct Library {
    /// Dropped before `import`, which owns the files.
    loaded: OnceLock<Option<Loaded>>,
    pub(crate) import: Fmi2Import,
    description: Description,
    pub(crate) path: PathBuf,
}

impl Library {
    /// Unpacks an FMU file below a folder, and reads it.
    pub fn open(path: &Path, below: &Path) -> Result<Self, Error> {
        let (import, xml) = package::open(path, below)?;
        let description = Description::parse(&xml).map_err(|what| Error::Content {
            path: path.to_owned(),
            line: 0,
            what: format!("modelDescription.xml: {what}"),
        })?;
        Ok(Self {
            loaded: OnceLock::new(),
            import,
            description,
            path: path.to_owned(),
        })
    }

    /// Keeps it loaded between runs, where that changes nothing.
    pub(crate) fn keep_loaded(&self) {
        self.loaded.get_or_init(|| Loaded::new(&self.import));
    }

    /// What it says of its variables.
    pub fn description(&self) -> &Description {
        &self.description
    }
}

/// FMU files that are open, each once however many components and runs use it.
#[derive(Clone)]
pub struct Libraries {
    open: HashMap<PathBuf, Arc<Library>>,
    /// Where FMUs are unpacked, each in a folder of its own that goes with its library.
    folder: PathBuf,
}

impl Default for Libraries {
    fn default() -> Self {
        Self::below(std::env::temp_dir())
    }
}

impl Libraries {
    /// FMUs are unpacked below a folder.
    pub fn below(folder: PathBuf) -> Self {
        let open = HashMap::new();
        Self { open, folder }
    }

    /// Where FMUs are unpacked.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The library of a file, opened when it is not yet.
    pub fn open(&mut self, path: &Path) -> Result<Arc<Library>, Error> {
        if let Some(known) = self.open.get(path) {
            return Ok(known.clone());
        }
        let library = Arc::new(Library::open(path, &self.folder)?);
        self.open.insert(path.to_owned(), library.clone());
        Ok(library)
    }
}
