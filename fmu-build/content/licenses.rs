//! `documentation/licenses`: the licence of every package in the library, with its text.

use super::Members;
use super::packages::{Linked, Package};
use crate::{Error, Result};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const FOLDER: &str = "documentation/licenses";
/// Licence under which the Rust standard library is used.
const STANDARD_LIBRARY: &str = include_str!("../LICENSE-APACHE");
/// How the files begin that hold the text of a licence.
const NAMES: [&str; 6] = [
    "license",
    "licence",
    "copying",
    "copyright",
    "notice",
    "unlicense",
];

/// `license.txt`, where FMI 2.0.4 begins to read, and the texts in one folder per package.
pub(crate) fn members(model: &str, linked: &Linked) -> Result<Members> {
    let mut index = format!(
        "{model} {}: {}\n\nIts library holds the packages below; their licences are in the folders \
         named.\n\n",
        linked.root.version,
        stated(&linked.root)
    );
    let mut members = Members::new();
    for package in std::iter::once(&linked.root).chain(&linked.others) {
        let folder = format!("{}-{}", package.name, package.version);
        let _ = writeln!(index, "{folder}: {}", stated(package));
        for file in files(package, &linked.workspace) {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let text = fs::read(&file).map_err(Error::io(&file))?;
            members.push((format!("{FOLDER}/{folder}/{name}"), text));
        }
    }
    index.push_str(
        "rust-std: Apache-2.0, chosen of MIT OR Apache-2.0 (the Rust standard library)\n",
    );
    members.push((
        format!("{FOLDER}/rust-std/LICENSE-APACHE"),
        STANDARD_LIBRARY.into(),
    ));
    members.push((format!("{FOLDER}/license.txt"), index.into_bytes()));
    Ok(members)
}

fn stated(package: &Package) -> &str {
    package.license.as_deref().unwrap_or("no licence stated")
}

/// The licence files of a package: beside its manifest, else at the root of the workspace.
fn files(package: &Package, workspace: &Path) -> Vec<PathBuf> {
    let own = texts(&package.folder);
    if own.is_empty() && package.folder.starts_with(workspace) {
        texts(workspace)
    } else {
        own
    }
}

fn texts(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<_> = entries
        .map(|entry| entry.path())
        .filter(|path| is_text(path))
        .collect();
    found.sort();
    found
}

fn is_text(path: &Path) -> bool {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    path.is_file() && NAMES.iter().any(|begin| name.starts_with(begin))
}
