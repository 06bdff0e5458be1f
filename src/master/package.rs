//! Unpacks of an FMU file what a run needs: description, resources, the library of this platform.
//!
//! `fmi::import::from_path` writes every member. Making the forty files of documentation and
//! references costs far more than a run of a second. Nobody vouches for the file: what it unpacks stays
//! within its folder and within bounds.

use crate::error::Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::traits::FmiImport;
use std::fs::File;
use std::io::{Read, copy};
use std::path::Path;
use tempfile::TempDir;
use zip::ZipArchive;

/// Its description, and where everything else is.
const DESCRIPTION: &str = "modelDescription.xml";
const RESOURCES: &str = "resources/";
const BINARIES: &str = "binaries/";
/// No description, and no FMU, that people exchange is larger [bytes].
const LARGEST_TEXT: u64 = 256 << 20;
const LARGEST: u64 = 2 << 30;
/// No archive has more members.
const MOST_MEMBERS: usize = 20_000;
/// Members up to this size may be packed as small as they like [bytes].
const SMALL: u64 = 16 << 20;
/// How many times smaller others may be packed: libraries are about 3 times, zeros 1000 times.
const RATIO: u64 = 200;

/// Unpacks an FMU file below a folder and reads it; returns it with the text of its description.
pub fn open(path: &Path, below: &Path) -> Result<(Fmi2Import, String), Error> {
    let load = |error| Error::Load {
        path: path.to_owned(),
        error: Box::new(error),
    };
    let mut archive = archive(path).map_err(load)?;
    let xml = description(&mut archive).map_err(load)?;
    let folder = tempfile::Builder::new().prefix("cosim-").tempdir_in(below);
    let folder = folder.map_err(|error| load(error.into()))?;
    let import = Fmi2Import::new(folder, &xml).map_err(load)?;
    let identifier = &import.model_description().co_simulation;
    let identifier = identifier.as_ref().map(|known| &known.model_identifier);
    let identifier = identifier.ok_or_else(|| load(fmi::Error::UnsupportedFmuType("CS".into())))?;
    if identifier.contains(['/', '\\', ':']) {
        return Err(load(broken(format!(
            "modelIdentifier '{identifier}' is a path"
        ))));
    }
    let library = import.shared_lib_path(identifier).map_err(load)?;
    let library = library.to_string_lossy().replace('\\', "/");
    let needed = |name: &str| name.starts_with(RESOURCES) || same_folder(name, &library);
    unpack(&mut archive, import.archive_path(), needed).map_err(load)?;
    if !import.archive_path().join(&library).is_file() {
        return Err(Error::Platform {
            path: path.to_owned(),
            library,
            there: platforms(&archive),
        });
    }
    complete(&import.archive_path().join(&library)).map_err(load)?;
    Ok((import, xml))
}

/// Unpacks all of an archive into a new folder below another one.
pub fn unpacked(path: &Path, below: &Path) -> Result<TempDir, fmi::Error> {
    let mut archive = archive(path)?;
    let folder = tempfile::Builder::new()
        .prefix("cosim-")
        .tempdir_in(below)?;
    unpack(&mut archive, folder.path(), |_| true)?;
    Ok(folder)
}

fn broken(what: String) -> fmi::Error {
    fmi::Error::ArchiveStructure(what)
}

fn archive(path: &Path) -> Result<ZipArchive<File>, fmi::Error> {
    let archive = ZipArchive::new(File::open(path)?)?;
    let count = archive.len();
    if count > MOST_MEMBERS {
        return Err(broken(format!(
            "it has {count} members, more than {MOST_MEMBERS}"
        )));
    }
    Ok(archive)
}

fn description(archive: &mut ZipArchive<File>) -> Result<String, fmi::Error> {
    let mut xml = String::new();
    let member = archive.by_name(DESCRIPTION)?;
    let read = member.take(LARGEST_TEXT).read_to_string(&mut xml)?;
    if read as u64 == LARGEST_TEXT {
        let what = format!("{DESCRIPTION} has {LARGEST_TEXT} bytes or more");
        return Err(broken(what));
    }
    Ok(xml)
}

/// Beside the library there may be others that it loads.
fn same_folder(name: &str, library: &str) -> bool {
    let folder = library.rfind('/').map_or("", |end| &library[..=end]);
    name.starts_with(folder)
}

fn unpack(
    archive: &mut ZipArchive<File>,
    folder: &Path,
    needed: impl Fn(&str) -> bool,
) -> Result<(), fmi::Error> {
    let mut left = LARGEST;
    for index in 0..archive.len() {
        let member = archive.by_index(index)?;
        if member.is_dir() || !needed(member.name()) {
            continue;
        }
        if member.size() > SMALL && member.size() / RATIO > member.compressed_size() {
            let what = format!(
                "'{}' is packed more than {RATIO} times smaller: a bomb",
                member.name()
            );
            return Err(broken(what));
        }
        let name = member.enclosed_name().filter(|_| !member.is_symlink());
        let leaves = || broken(format!("'{}' leaves it", member.name()));
        let target = folder.join(name.ok_or_else(leaves)?);
        target.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        // Sizes that the archive states may be wrong: count what is written.
        left -= copy(&mut member.take(left), &mut File::create_new(target)?)?;
        if left == 0 {
            return Err(broken(format!("it unpacks to {LARGEST} bytes or more")));
        }
    }
    Ok(())
}

/// Refuses an ELF library of 64 bits that lacks bytes at its end: the loader maps what is not there without a
/// word, and the first look at it ends the process.
fn complete(library: &Path) -> Result<(), fmi::Error> {
    let bytes = std::fs::read(library)?;
    if bytes.get(..ELF_64.len()) == Some(ELF_64) && needed_bytes(&bytes) > bytes.len() as u64 {
        return Err(broken("the library is cut short".into()));
    }
    Ok(())
}

const ELF_64: &[u8] = b"\x7fELF\x02\x01";

/// Where the last segment of an ELF file ends, or the list of them; without bound where even that is unknown.
fn needed_bytes(bytes: &[u8]) -> u64 {
    let (Some(start), Some(size), Some(count)) = (
        number(bytes, 32, 8),
        number(bytes, 54, 2),
        number(bytes, 56, 2),
    ) else {
        return u64::MAX;
    };
    let heads = (0..count).map(|index| start.saturating_add(index * size));
    let ends = heads.map(|head| {
        let [offset, length] = [8, 32].map(|at| number(bytes, head.saturating_add(at), 8));
        offset
            .zip(length)
            .map_or(u64::MAX, |(offset, length)| offset.saturating_add(length))
    });
    ends.max().unwrap_or(0)
}

/// A number of so many bytes, the lowest first.
fn number(bytes: &[u8], at: u64, length: usize) -> Option<u64> {
    let at = usize::try_from(at).ok()?;
    let part = bytes.get(at..at.checked_add(length)?)?;
    Some(
        part.iter()
            .rev()
            .fold(0, |sum, byte| sum << 8 | u64::from(*byte)),
    )
}

/// Platforms that the FMU has libraries for.
fn platforms(archive: &ZipArchive<File>) -> Vec<String> {
    let names = archive.file_names();
    let mut found: Vec<String> = names
        .filter_map(|name| name.strip_prefix(BINARIES)?.split_once('/'))
        .map(|(platform, _)| platform.to_owned())
        .collect();
    found.sort();
    found.dedup();
    found
}
