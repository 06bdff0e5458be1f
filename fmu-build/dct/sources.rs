//! What the FMUs of `target/fmu` were built from, in a file beside them. The harness warns when the sources have
//! changed since: it would give the figures of before, and nobody would see it.
//!
//! It does not stand in the FMUs: a comment that changes shall change none of their bytes.

use crate::{Error, Result, archive, library};
use flate2::Crc;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What FMUs of this workspace are made of, relative to it.
const SOURCES: [&str; 7] = [
    "Cargo.lock",
    "Cargo.toml",
    "fmu-build",
    "src/driveline",
    "src/fmi2",
    "src/fmus",
    "src/models",
];

/// Folders in there of which nothing comes into an FMU.
const APART: [&str; 3] = ["examples", "target", "tests"];

/// The file, in the folder of the FMUs.
const RECORD: &str = "sources.json";

/// What the file says: the harness need not know what sources are.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Record {
    sources: Vec<String>,
    apart: Vec<String>,
    fmus: BTreeMap<String, Built>,
}

/// Checksums (CRC-32) of an FMU and of the sources that it was built from.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Built {
    fmu: u32,
    sources: u32,
}

/// CRC-32 of the sources of this workspace: of the name and the content of each file, by name.
///
/// # Errors
/// When a source cannot be read.
pub fn checksum() -> Result<u32> {
    checksum_of(library::workspace(), &SOURCES)
}

/// Writes beside an FMU of this workspace that it was built from sources of this checksum.
///
/// # Errors
/// When the FMU cannot be read or the file not be written.
pub fn record(fmu: &Path, sources: u32) -> Result<()> {
    let path = fmu.with_file_name(RECORD);
    let mut record = Record {
        sources: SOURCES.map(String::from).into(),
        apart: APART.map(String::from).into(),
        ..known(&path)
    };
    let built = Built {
        fmu: checksum_of_file(fmu)?,
        sources,
    };
    record.fmus.insert(name(fmu), built);
    let text = serde_json::to_string_pretty(&record).map_err(|error| Error::Io {
        path: path.clone(),
        source: error.into(),
    })?;
    archive::write_whole(&path, (text + "\n").as_bytes())
}

/// The checksum of the sources of an FMU, where it is recorded beside it.
#[must_use]
pub fn recorded(fmu: &Path) -> Option<u32> {
    let built = known(&fmu.with_file_name(RECORD)).fmus.remove(&name(fmu))?;
    (checksum_of_file(fmu).ok()? == built.fmu).then_some(built.sources)
}

fn known(record: &Path) -> Record {
    let text = fs::read(record).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

fn name(fmu: &Path) -> String {
    fmu.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn checksum_of_file(path: &Path) -> Result<u32> {
    let mut crc = Crc::new();
    crc.update(&fs::read(path).map_err(failed(path))?);
    Ok(crc.sum())
}

fn checksum_of(root: &Path, sources: &[&str]) -> Result<u32> {
    let mut files = BTreeMap::new();
    for source in sources {
        collect(&root.join(source), (*source).to_owned(), &mut files)?;
    }
    let mut crc = Crc::new();
    for (name, path) in files {
        crc.update(name.as_bytes());
        crc.update(&[0]);
        crc.update(&fs::read(&path).map_err(failed(&path))?);
    }
    Ok(crc.sum())
}

/// Adds a file, or those of a folder, by their names from the root on, with `/`.
fn collect(path: &Path, name: String, files: &mut BTreeMap<String, PathBuf>) -> Result<()> {
    if !path.is_dir() {
        files.insert(name, path.to_owned());
        return Ok(());
    }
    for entry in fs::read_dir(path).map_err(failed(path))? {
        let path = entry.map_err(failed(path))?.path();
        let last = path.file_name().unwrap_or_default().to_string_lossy();
        let apart = path.is_dir() && APART.contains(&last.as_ref());
        if !apart && !last.starts_with('.') {
            collect(&path, format!("{name}/{last}"), files)?;
        }
    }
    Ok(())
}

fn failed(path: &Path) -> impl Fn(std::io::Error) -> Error {
    |source| Error::Io {
        path: path.into(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(folder: &Path, name: &str, text: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn the_checksum_changes_with_what_an_fmu_is_made_of_and_with_nothing_else() {
        let root = std::env::temp_dir().join(format!("fmu-build-sources-{}", std::process::id()));
        let sum = || checksum_of(&root, &["src", "Cargo.lock"]).unwrap();
        written(&root, "Cargo.lock", "");
        written(&root, "src/a.rs", "fn a() {}");
        let first = sum();
        written(&root, "src/tests/a.rs", "");
        written(&root, "src/.a.rs.swp", "");
        written(&root, "README.md", "");
        assert_eq!(sum(), first);
        written(&root, "src/b/c.rs", "");
        let second = sum();
        assert_ne!(second, first);
        written(&root, "src/a.rs", "fn b() {}");
        assert!(![first, second].contains(&sum()));
        fs::remove_dir_all(&root).unwrap();
    }

    #[test]
    fn the_record_keeps_what_it_says_of_other_fmus() {
        let root = std::env::temp_dir().join(format!("fmu-build-record-{}", std::process::id()));
        for (name, sources) in [("A.fmu", 1), ("B.fmu", 2), ("A.fmu", 3)] {
            written(&root, name, "123456789");
            record(&root.join(name), sources).unwrap();
            assert_eq!(recorded(&root.join(name)), Some(sources));
        }
        let found = known(&root.join(RECORD)).fmus;
        let fmu = 0xcbf4_3926; // the check value of CRC-32
        let built = |sources| Built { fmu, sources };
        assert_eq!(
            found,
            BTreeMap::from([("A.fmu".into(), built(3)), ("B.fmu".into(), built(2))])
        );
        written(&root, "A.fmu", "1234567890");
        assert_eq!(recorded(&root.join("A.fmu")), None);
        fs::remove_dir_all(&root).unwrap();
    }
}
