//! The packages an FMU can be made of, as cargo knows them.

use super::Fault;
use crate::compiler::Compiler;
use crate::metadata::{Described, Metadata};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// The crate that makes a library an FMU.
const SHELL: &str = "fmi2-cosim";

/// Packages with a library for an FMU, and their workspace.
pub(super) struct Found {
    pub(super) packages: Vec<Package>,
    /// Folder of the workspace.
    pub(super) workspace: PathBuf,
    /// Where cargo builds.
    pub(super) target: PathBuf,
}

/// A package.
pub(super) struct Package {
    pub(super) name: String,
    pub(super) folder: PathBuf,
    /// Where its `fmi2-cosim` is from, as cargo writes it; `None`: from a folder.
    pub(super) source: Option<String>,
    pub(super) version: String,
    /// Folder of that `fmi2-cosim`.
    pub(super) shell: PathBuf,
}

impl Found {
    /// The package of a manifest, or all of a workspace's that make an FMU. Writes `Cargo.lock` where there is none.
    pub(super) fn by(manifest: Option<&Path>) -> Result<Self> {
        let manifest = manifest.map(|path| {
            if path.is_dir() {
                path.join("Cargo.toml")
            } else {
                path.into()
            }
        });
        let mut words: Vec<String> = Vec::new();
        if let Some(path) = &manifest {
            words.extend(["--manifest-path".into(), path.display().to_string()]);
        }
        if let Some(host) = Compiler::present().host() {
            words.extend(["--filter-platform".into(), host]);
        }
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        Self::among(Metadata::asked(Path::new("."), &words)?)
    }

    fn among(metadata: Metadata) -> Result<Self> {
        let packages = match &metadata.resolve.root {
            Some(root) => vec![package(&metadata, root)?],
            None => {
                let all = metadata.workspace_members.iter();
                all.filter_map(|id| package(&metadata, id).ok()).collect()
            }
        };
        if packages.is_empty() {
            let folder = metadata.workspace_root;
            return Err(Error::Outside(Fault::NoPackage { folder }));
        }
        Ok(Self {
            packages,
            workspace: metadata.workspace_root,
            target: metadata.target_directory,
        })
    }
}

fn package(metadata: &Metadata, id: &str) -> Result<Package> {
    let named = |id: &str| metadata.packages.iter().find(|found| found.id == id);
    let fail = |fault| Err(Error::Outside(fault));
    let Some(found) = named(id) else {
        let folder = metadata.workspace_root.clone();
        return fail(Fault::NoPackage { folder });
    };
    let package = found.name.clone();
    let nodes = metadata.resolve.nodes.iter().find(|node| node.id == id);
    let linked = nodes.into_iter().flat_map(|node| &node.deps);
    let linked = linked.filter(|link| link.dep_kinds.iter().any(|kind| kind.kind.is_none()));
    let mut linked = linked.filter_map(|link| named(&link.pkg));
    let Some(shell) = linked.find(|found| found.name == SHELL) else {
        return fail(Fault::NoShell { package });
    };
    let found_types = types(found);
    let has = |wanted: &[&str]| {
        found_types
            .iter()
            .any(|kind| wanted.contains(&kind.as_str()))
    };
    if !has(&["cdylib"]) || !has(&["lib", "rlib"]) {
        let found = found_types;
        return fail(Fault::CrateType { package, found });
    }
    Ok(Package {
        name: package,
        folder: folder(found),
        source: shell.source.clone(),
        version: shell.version.clone(),
        shell: folder(shell),
    })
}

/// The types of a package's library.
fn types(package: &Described) -> Vec<String> {
    const LIBRARIES: [&str; 5] = ["lib", "rlib", "dylib", "cdylib", "staticlib"];
    let kinds = package.targets.iter().flat_map(|target| &target.kind);
    kinds
        .filter(|kind| LIBRARIES.contains(&kind.as_str()))
        .cloned()
        .collect()
}

fn folder(package: &Described) -> PathBuf {
    package
        .manifest_path
        .parent()
        .unwrap_or(Path::new(""))
        .into()
}

/// Folder of the workspace that the present folder is in.
pub(super) fn root() -> Option<PathBuf> {
    let mut command = Compiler::present().command();
    command.args(["locate-project", "--workspace", "--message-format=plain"]);
    let printed = command.output().ok()?;
    let manifest = String::from_utf8(printed.stdout).ok()?;
    Path::new(manifest.trim())
        .parent()
        .filter(|root| root.is_absolute())
        .map(Path::to_path_buf)
}
