//! Unpacks of an FMU file what a run needs: description, resources, the library of this platform.
//!
//! `fmi::import::from_path` writes every member. Making the forty files of documentation and
//! references costs far more than a run of a second.

use crate::error::Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::traits::FmiImport;
use std::fs::File;
use std::io::{Read, copy};
use std::path::Path;
use zip::ZipArchive;

/// Its description, and where everything else is.
const DESCRIPTION: &str = "modelDescription.xml";
const RESOURCES: &str = "resources/";
const BINARIES: &str = "binaries/";

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
    Ok((import, xml))
}

fn archive(path: &Path) -> Result<ZipArchive<File>, fmi::Error> {
    Ok(ZipArchive::new(File::open(path)?)?)
}

fn description(archive: &mut ZipArchive<File>) -> Result<String, fmi::Error> {
    let mut xml = String::new();
    archive.by_name(DESCRIPTION)?.read_to_string(&mut xml)?;
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
    for index in 0..archive.len() {
        let mut member = archive.by_index(index)?;
        if member.is_dir() || !needed(member.name()) {
            continue;
        }
        let name = member.enclosed_name();
        let leaves = || fmi::Error::ArchiveStructure(format!("'{}' leaves it", member.name()));
        let target = folder.join(name.ok_or_else(leaves)?);
        target.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        copy(&mut member, &mut File::create_new(target)?)?;
    }
    Ok(())
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
