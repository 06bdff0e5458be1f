//! FMU files: ZIP archives whose bytes depend on their contents only.

mod untrusted;

pub use untrusted::Untrusted;
pub(crate) use untrusted::{examine, member_name};

use crate::{Error, Result};
use std::fs::{self, File};
use std::io::{Cursor, Read as _, Write as _};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// Writes `members` (name in the archive, contents) to `path`, replacing it in one step.
///
/// Entries are sorted by name, deflated, and dated 1980-01-01, the earliest date ZIP knows: the same
/// members give the same bytes. Whoever reads `path` meanwhile sees the old file or the new one.
///
/// # Errors
/// When the file cannot be written.
pub fn package(path: &Path, members: Vec<(String, Vec<u8>)>) -> Result<()> {
    let bytes = zipped(members).map_err(Error::zip(path))?;
    write_whole(path, &bytes)
}

fn zipped(mut members: Vec<(String, Vec<u8>)>) -> zip::result::ZipResult<Vec<u8>> {
    members.sort();
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(9))
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, contents) in &members {
        writer.start_file(name.as_str(), options)?;
        writer.write_all(contents)?;
    }
    Ok(writer.finish()?.into_inner())
}

/// The member that makes an archive an FMU.
pub(crate) const DESCRIPTION: &str = "modelDescription.xml";

/// Largest FMU that is read into memory, unpacked [bytes].
const LARGEST: u64 = 1 << 30;

/// Opens an FMU of any origin.
///
/// # Errors
/// When the file cannot be read or is no ZIP archive.
pub(crate) fn open(path: &Path) -> Result<ZipArchive<File>> {
    ZipArchive::new(file(path)?).map_err(Error::zip(path))
}

/// Opens the file of an FMU.
///
/// # Errors
/// When it cannot be read; of a folder the error tells what to do.
pub(crate) fn file(path: &Path) -> Result<File> {
    if path.is_dir() {
        return Err(Error::Folder {
            path: path.into(),
            remedy: remedy(path),
        });
    }
    File::open(path).map_err(Error::io(path))
}

/// What to do where `folder` was given for an FMU.
fn remedy(folder: &Path) -> String {
    if folder.join(DESCRIPTION).is_file() {
        let name = folder.file_name().unwrap_or("packed".as_ref()).display();
        let folder = folder.display();
        return format!(
            "what is in it is one unpacked; pack it with `(cd {folder} && zip -r ../{name}.fmu .)`"
        );
    }
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let is_fmu = |path: &PathBuf| path.extension().is_some_and(|end| end == "fmu");
    match paths.filter(is_fmu).min() {
        Some(fmu) => format!("name the file in it, {}", fmu.display()),
        None => format!("an FMU is a file NAME.fmu, a ZIP archive with {DESCRIPTION} at its top"),
    }
}

/// Reads all files of an archive.
///
/// # Errors
/// When the file cannot be read, is no ZIP archive, unpacks to more than 1 GiB, or has a member that nobody should unpack.
pub(crate) fn members(path: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let mut archive = open(path)?;
    examine(path, &mut archive, LARGEST)?;
    let (mut members, mut room) = (Vec::new(), LARGEST);
    for index in 0..archive.len() {
        let member = archive.by_index(index).map_err(Error::zip(path))?;
        if member.is_dir() {
            continue;
        }
        let name = member_name(path, &member)?;
        let mut bytes = Vec::new();
        let read = member.take(room + 1).read_to_end(&mut bytes);
        read.map_err(Error::io(path))?;
        let size = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
        let rest = room.checked_sub(size);
        room = rest.ok_or_else(|| Untrusted::TooLarge { limit: LARGEST }.of(path))?;
        members.push((name, bytes));
    }
    Ok(members)
}

/// Writes a file completely or not at all: to a temporary file beside it, which is then renamed.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |source| Error::Io {
        path: path.into(),
        source,
    };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    written
        .inspect_err(|_| drop(fs::remove_file(&temporary)))
        .map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn members(names: &[&str]) -> Vec<(String, Vec<u8>)> {
        names
            .iter()
            .map(|name| ((*name).to_owned(), name.repeat(100).into_bytes()))
            .collect()
    }

    #[test]
    fn the_order_of_members_does_not_change_the_bytes() {
        let forward = zipped(members(&["a", "b/c", "d"])).unwrap();
        assert_eq!(forward, zipped(members(&["d", "b/c", "a"])).unwrap());
    }

    #[test]
    fn entries_are_sorted_deflated_and_dated_1980() {
        let bytes = zipped(members(&["b", "a"])).unwrap();
        let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
        let first = archive.by_index(0).unwrap();
        assert_eq!(first.name().unwrap(), "a");
        assert_eq!(first.compression(), CompressionMethod::Deflated);
        assert_eq!(first.last_modified().unwrap().year(), 1980);
    }

    #[test]
    fn of_a_folder_the_error_tells_what_to_do() {
        let folder = std::env::temp_dir().join(format!("archive-{}-folder", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let said = || crate::check(&folder).err().unwrap().to_string();
        let shown = folder.display();
        assert!(said().contains(&format!(
            "{shown} is a folder, not an FMU: an FMU is a file"
        )));
        for name in ["b.fmu", "a.fmu", "0.txt"] {
            fs::write(folder.join(name), "").unwrap();
        }
        assert!(said().ends_with(&format!("name the file in it, {shown}/a.fmu")));
        fs::write(folder.join(DESCRIPTION), "").unwrap();
        let name = folder.file_name().unwrap().display();
        assert!(said().contains(&format!("`(cd {shown} && zip -r ../{name}.fmu .)`")));
        fs::remove_dir_all(&folder).unwrap();
    }
}
