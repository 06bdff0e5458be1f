//! An .ssp file, unpacked into a folder that goes with it; nobody vouches for what is in it.

use crate::error::Error;
use crate::package;
use std::path::{Component, Path, PathBuf};
use tempfile::TempDir;

/// The file inside that tells the system.
pub const STRUCTURE: &str = "SystemStructure.ssd";

/// No text inside is larger [bytes].
const LARGEST_TEXT: u64 = 16 << 20;

/// The files of an .ssp.
pub struct Package {
    path: PathBuf,
    folder: TempDir,
}

impl Package {
    /// Unpacks a file below a folder.
    pub fn open(path: &Path, below: &Path) -> Result<Self, Error> {
        let (path, folder) = (path.to_owned(), package::unpacked(path, below));
        match folder {
            Ok(folder) => Ok(Self { path, folder }),
            Err(fmi::Error::Io(error)) => Err(Error::File { path, error }),
            Err(error) => Err(Error::Load {
                path,
                error: Box::new(error),
            }),
        }
    }

    /// The file itself.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What errors call a file inside.
    pub fn named(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Where a file inside lies; none where there is no such file.
    pub fn file(&self, name: &str) -> Option<PathBuf> {
        let mut parts = Path::new(name).components();
        let stays = parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        let file = self.folder.path().join(name);
        (stays && file.is_file()).then_some(file)
    }

    /// The text of a file inside.
    pub fn text(&self, name: &str) -> Result<String, Error> {
        let wrong = |what: String| Error::Content {
            path: self.path.clone(),
            line: 0,
            what,
        };
        let file = self.file(name);
        let file = file.ok_or_else(|| wrong(format!("has no '{name}'")))?;
        let size = file.metadata().map_or(u64::MAX, |known| known.len());
        if size > LARGEST_TEXT {
            return Err(wrong(format!(
                "'{name}' has {size} bytes, more than {LARGEST_TEXT}"
            )));
        }
        let text = std::fs::read_to_string(file);
        text.map_err(|error| wrong(format!("'{name}': {error}")))
    }
}
