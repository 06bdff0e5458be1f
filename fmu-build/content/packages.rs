//! The cargo packages that are linked into a library, as cargo resolves them.

use crate::metadata::{Described, Metadata, Target};
use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// One package.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Package {
    pub(crate) name: String,
    pub(crate) version: String,
    /// SPDX expression.
    pub(crate) license: Option<String>,
    pub(crate) repository: Option<String>,
    pub(crate) description: Option<String>,
    /// Where its sources are on this machine; not for the FMU.
    pub(crate) folder: PathBuf,
    /// SHA-256 of the package file; `None` for those of the workspace.
    pub(crate) checksum: Option<String>,
    /// Names and versions of what it links itself.
    pub(crate) links: BTreeSet<(String, String)>,
}

/// What is linked into the library of a package, the package itself first.
pub(crate) struct Linked {
    /// Folder of the cargo workspace.
    pub(crate) workspace: PathBuf,
    pub(crate) root: Package,
    /// All others, sorted.
    pub(crate) others: Vec<Package>,
    /// Version of the Rust standard library, which is part of every library that rustc makes.
    pub(crate) standard_library: String,
}

/// Asks cargo, for the machine it runs on: packages of other systems may not be downloaded.
pub(crate) fn linked(package: &str, folder: &Path) -> Result<Linked> {
    let compiler = Compiler::used()?;
    let words = ["--locked", "--filter-platform", &compiler.host];
    let metadata = Metadata::asked(folder, &words)?;
    metadata.linked(package, compiler.release)
}

/// What `rustc -vV` says of itself.
struct Compiler {
    host: String,
    release: String,
}

impl Compiler {
    fn used() -> Result<Self> {
        let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let output = Command::new(rustc).arg("-vV").output();
        let output = output.map_err(Error::io("rustc"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let field = |name| text.lines().find_map(|line| line.strip_prefix(name));
        match (field("host: "), field("release: ")) {
            (Some(host), Some(release)) => Ok(Self {
                host: host.into(),
                release: release.into(),
            }),
            _ => Err(Error::Metadata {
                said: format!("rustc -vV printed {text:?}"),
            }),
        }
    }
}

impl Metadata {
    fn linked(&self, package: &str, standard_library: String) -> Result<Linked> {
        let unknown = || Error::NoLibrary {
            package: package.into(),
        };
        let root = self
            .packages
            .iter()
            .find(|found| found.name == package)
            .ok_or_else(unknown)?;
        let (mut seen, mut open) = (BTreeSet::new(), vec![root.id.as_str()]);
        while let Some(id) = open.pop() {
            if seen.insert(id) {
                open.extend(self.links(id).map(|found| found.id.as_str()));
            }
        }
        seen.remove(root.id.as_str());
        let sums = checksums(&self.workspace_root);
        let others = self
            .packages
            .iter()
            .filter(|found| seen.contains(found.id.as_str()));
        let mut others: Vec<_> = others.map(|found| self.package(found, &sums)).collect();
        others.sort();
        Ok(Linked {
            workspace: self.workspace_root.clone(),
            root: self.package(root, &sums),
            others,
            standard_library,
        })
    }

    /// What a package links itself; procedural macros run in the compiler and end there.
    fn links(&self, id: &str) -> impl Iterator<Item = &Described> {
        let node = self.resolve.nodes.iter().find(move |node| node.id == id);
        let linked = node.into_iter().flat_map(|node| &node.deps);
        let linked =
            linked.filter(|dependency| dependency.dep_kinds.iter().any(|k| k.kind.is_none()));
        let found = linked.filter_map(|link| self.packages.iter().find(|p| p.id == link.pkg));
        found.filter(|package| !package.targets.iter().any(Target::is_macro))
    }

    fn package(&self, found: &Described, sums: &Checksums) -> Package {
        let key = |package: &Described| (package.name.clone(), package.version.clone());
        Package {
            name: found.name.clone(),
            version: found.version.clone(),
            license: found.license.clone(),
            repository: found.repository.clone(),
            description: found.description.clone(),
            folder: found
                .manifest_path
                .parent()
                .unwrap_or(Path::new(""))
                .to_path_buf(),
            checksum: sums.get(&key(found)).cloned(),
            links: self.links(&found.id).map(key).collect(),
        }
    }
}

type Checksums = BTreeMap<(String, String), String>;

/// The checksums that `Cargo.lock` states; none when there is no such file.
fn checksums(workspace: &Path) -> Checksums {
    let text = fs::read_to_string(workspace.join("Cargo.lock")).unwrap_or_default();
    let sums = text.split("[[package]]").filter_map(|package| {
        let field = |name: &str| {
            let mut lines = package.lines();
            let value = lines.find_map(|line| line.strip_prefix(name)?.strip_prefix(" = \""))?;
            value.strip_suffix('"').map(str::to_owned)
        };
        Some(((field("name")?, field("version")?), field("checksum")?))
    });
    sums.collect()
}
