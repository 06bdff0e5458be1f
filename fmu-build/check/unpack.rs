//! Unpacks an FMU that nobody vouches for.

use crate::archive::{self, Untrusted, examine, member_name};
use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use zip::ZipArchive;
use zip::read::ZipFile;

/// No FMU that people exchange is larger than this when unpacked [bytes].
const LARGEST: u64 = 4 << 30;

/// An FMU unpacked into a folder of its own, which is removed on drop.
pub(crate) struct Unpacked {
    folder: PathBuf,
}

impl Unpacked {
    /// Unpacks the FMU at `path` after every member was found to stay inside the folder, and within bounds.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let mut archive = archive::open(path)?;
        examine(path, &mut archive, LARGEST)?;
        let unpacked = Self {
            folder: new_folder()?,
        };
        unpacked.fill(path, &mut archive)?;
        Ok(unpacked)
    }

    /// Where the members are.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    fn fill(&self, path: &Path, archive: &mut ZipArchive<File>) -> Result<()> {
        let mut left = LARGEST;
        for at in 0..archive.len() {
            let member = archive.by_index(at).map_err(Error::zip(path))?;
            let name = member_name(path, &member)?;
            let target = self.folder.join(&name);
            // The sizes that the archive states may be wrong: count what is written.
            left -= unpack(member, &target, left).map_err(Error::io(target))?;
            if left == 0 {
                return Err(Untrusted::TooLarge { limit: LARGEST }.of(path));
            }
        }
        Ok(())
    }
}

/// Writes one member, at most `limit` bytes of it; returns how many.
fn unpack(member: ZipFile<'_, File>, target: &Path, limit: u64) -> io::Result<u64> {
    if member.is_dir() {
        fs::create_dir_all(target)?;
        return Ok(0);
    }
    if let Some(parent) = target.parent() {
        fs::create_dir_all(parent)?;
    }
    io::copy(&mut member.take(limit), &mut File::create(target)?)
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        // Nobody waits for it: a folder that stays behind in the temporary directory does no harm.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// A new folder in the temporary directory.
pub(super) fn new_folder() -> Result<PathBuf> {
    let base = std::env::temp_dir();
    let mut number = 0_u32;
    loop {
        let folder = base.join(format!("fmu-build-{}-{number}", std::process::id()));
        match fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(source) => {
                return Err(Error::Io {
                    path: folder,
                    source,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::package;

    #[test]
    fn what_was_packed_is_unpacked_and_removed_again() {
        let folder = new_folder().unwrap();
        let path = folder.join("A.fmu");
        let members = ["modelDescription.xml", "resources/x.txt"];
        package(
            &path,
            members.map(|name| (name.into(), b"text".to_vec())).into(),
        )
        .unwrap();
        let unpacked = Unpacked::open(&path).unwrap();
        let inside = unpacked.folder().to_owned();
        let text = fs::read_to_string(inside.join("resources/x.txt")).unwrap();
        assert_eq!(text, "text");
        drop(unpacked);
        assert!(!inside.exists());
        assert_eq!(
            fs::read_dir(&folder).unwrap().count(),
            1,
            "the temporary file was renamed"
        );
        fs::remove_dir_all(&folder).unwrap();
    }
}
