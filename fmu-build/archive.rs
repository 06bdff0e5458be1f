//! FMU files: ZIP archives whose bytes depend on their contents only.

use crate::{Error, Result};
use std::fs;
use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

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

/// Largest FMU that is read into memory, unpacked [bytes].
const LARGEST: u64 = 1 << 30;

/// Reads all files of an archive.
///
/// # Errors
/// When the file cannot be read, is no ZIP archive, or unpacks to more than 1 GiB.
pub(crate) fn members(path: &Path) -> Result<Vec<(String, Vec<u8>)>> {
    let io = |source| Error::Io {
        path: path.into(),
        source,
    };
    let zip = |source| Error::Zip {
        path: path.into(),
        source,
    };
    let file = fs::File::open(path).map_err(io)?;
    let mut archive = zip::ZipArchive::new(file).map_err(zip)?;
    let (mut members, mut room) = (Vec::new(), LARGEST);
    for index in 0..archive.len() {
        let member = archive.by_index(index).map_err(zip)?;
        if member.is_dir() {
            continue;
        }
        let (name, mut bytes) = (member.name().map_err(zip)?.into_owned(), Vec::new());
        member.take(room + 1).read_to_end(&mut bytes).map_err(io)?;
        let size = u64::try_from(bytes.len()).unwrap_or(u64::MAX);
        let rest = room.checked_sub(size);
        room = rest.ok_or(Error::TooLarge { limit: LARGEST })?;
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
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let first = archive.by_index(0).unwrap();
        assert_eq!(first.name().unwrap(), "a");
        assert_eq!(first.compression(), CompressionMethod::Deflated);
        assert_eq!(first.last_modified().unwrap().year(), 1980);
    }
}
