//! The program that links a model and packs its FMU.

use super::found::{Found, Package};
use super::{Fault, Order};
use crate::compiler::Compiler;
use crate::{Error, Result, archive};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Exit code of the program when it has printed what is wrong.
pub(super) const TOLD: u8 = 3;
/// The word for a small library.
pub(super) const SMALL: &str = "small";

/// A written program.
pub(super) struct Describer<'a> {
    package: &'a Package,
    manifest: PathBuf,
    target: &'a Path,
}

impl<'a> Describer<'a> {
    /// Writes the program into the target folder.
    pub(super) fn written(package: &'a Package, found: &'a Found) -> Result<Self> {
        let folder = found.target.join("fmu-build").join(&package.name);
        let manifest = folder.join("Cargo.toml");
        archive::write_whole(&manifest, manifest_text(package)?.as_bytes())?;
        archive::write_whole(&folder.join("main.rs"), main_text(package).as_bytes())?;
        let own = lock(Some(&found.workspace));
        let ours = lock(repository(&package.shell).as_deref());
        let locked = merged(&own, &ours);
        archive::write_whole(&folder.join("Cargo.lock"), locked.as_bytes())?;
        Ok(Self {
            package,
            manifest,
            target: &found.target,
        })
    }

    /// Builds and runs it: it prints the path of the FMU.
    ///
    /// The library is built without symbols, as small as it gets, and so that a panic ends in the FMU: no profile of
    /// the package may change that.
    pub(super) fn run(&self, out: &Path, order: &Order<'_>) -> Result<()> {
        let mut command = Compiler::present().command();
        command
            .args(["run", "--quiet", "--manifest-path"])
            .arg(&self.manifest);
        command
            .arg("--target-dir")
            .arg(self.target)
            .arg("--")
            .arg(out);
        command
            .arg(if order.small { SMALL } else { "full" })
            .args(order.targets);
        for (setting, value) in [
            ("PANIC", "unwind"),
            ("STRIP", "symbols"),
            ("LTO", "fat"),
            ("CODEGEN_UNITS", "1"),
        ] {
            command.env(format!("CARGO_PROFILE_RELEASE_{setting}"), value);
        }
        let status = command.current_dir(&self.package.folder).status();
        let status = status.map_err(Error::io("cargo"))?;
        let package = self.package.name.clone();
        match status.code() {
            Some(0) => Ok(()),
            Some(code) if code == i32::from(TOLD) => Err(Error::Outside(Fault::Told { package })),
            _ => Err(Error::Outside(Fault::Describer { package })),
        }
    }
}

fn main_text(package: &Package) -> String {
    format!(
        "//! Written by `cargo fmu build`.\n\nfn main() -> std::process::ExitCode {{\n    \
         fmu_build::outside::pack::<model::FmuModel>({:?}, {:?})\n}}\n",
        package.name, package.folder
    )
}

fn manifest_text(package: &Package) -> Result<String> {
    let (name, folder) = (
        quoted(&package.name),
        quoted(&package.folder.display().to_string()),
    );
    let packer = packer(package)?;
    Ok(format!(
        "# Written by `cargo fmu build`.\n[package]\nname = \"fmu-of-{}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\
         publish = false\n\n[[bin]]\nname = \"fmu-of-{}\"\npath = \"main.rs\"\n\n[dependencies]\n\
         model = {{ package = {name}, path = {folder} }}\n\
         fmu-build = {{ {packer}, default-features = false }}\n\n[profile.dev]\ndebug = false\n\n[workspace]\n",
        package.name, package.name
    ))
}

/// Where the `fmu-build` is that belongs to the `fmi2-cosim` of a package.
fn packer(package: &Package) -> Result<String> {
    let Some(source) = &package.source else {
        let folder = || package.shell.clone();
        let above = repository(&package.shell);
        let above = above.ok_or_else(|| Error::Outside(Fault::NoPacker { folder: folder() }))?;
        let packer = above.join("fmu-build").display().to_string();
        return Ok(format!("path = {}", quoted(&packer)));
    };
    Ok(match source.strip_prefix("git+") {
        Some(git) => from_git(git),
        None => format!("version = {}", quoted(&format!("={}", package.version))),
    })
}

/// `URL?branch=NAME#COMMIT` as the same source in a manifest; the lock file holds the commit.
fn from_git(source: &str) -> String {
    let (source, _commit) = source.split_once('#').unwrap_or((source, ""));
    let (url, query) = source.split_once('?').unwrap_or((source, ""));
    let mut text = format!("git = {}", quoted(url));
    if let Some((kind @ ("branch" | "tag" | "rev"), name)) = query.split_once('=') {
        let name = name.replace("%2F", "/");
        text.push_str(&format!(", {kind} = {}", quoted(&name)));
    }
    text
}

/// The folder above that of `fmi2-cosim` that holds `fmu-build`, too.
fn repository(shell: &Path) -> Option<PathBuf> {
    let mut above = shell.ancestors();
    let found = above.find(|folder| folder.join("fmu-build/Cargo.toml").is_file());
    found.map(Path::to_path_buf)
}

/// A string of TOML: its escapes are those of JSON.
fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

fn lock(folder: Option<&Path>) -> String {
    let read = folder.map(|folder| fs::read_to_string(folder.join("Cargo.lock")));
    read.and_then(std::result::Result::ok).unwrap_or_default()
}

/// The packages of two lock files: what the package is built with is what it is described with, and nothing has to be
/// looked up that either knows.
fn merged(own: &str, ours: &str) -> String {
    const PACKAGE: &str = "[[package]]";
    let mut text = String::from("version = 4\n");
    let mut known = BTreeSet::new();
    for file in [own, ours] {
        for package in file.split(PACKAGE).skip(1) {
            let stated = |line: &&str| !line.is_empty() && !line.starts_with("dependencies");
            let lines = package.lines().skip(1).take_while(stated);
            let identity = lines.filter(|line| !line.starts_with("checksum"));
            if known.insert(identity.collect::<Vec<_>>()) {
                text.push_str(&format!("\n{PACKAGE}\n{}\n", package.trim()));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_packer_is_taken_from_where_the_shell_is_from() {
        for (source, expected) in [
            ("https://x.org/dct#12ab", "git = \"https://x.org/dct\""),
            (
                "file:///dct?rev=12ab#12ab",
                "git = \"file:///dct\", rev = \"12ab\"",
            ),
            (
                "ssh://g@x/d.git?branch=a%2Fb#1",
                "git = \"ssh://g@x/d.git\", branch = \"a/b\"",
            ),
        ] {
            assert_eq!(from_git(source), expected);
        }
        let shell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../src/fmi2");
        let mut package = Package {
            name: "tank".into(),
            folder: "/tank".into(),
            source: None,
            version: "1.2.3".into(),
            shell,
        };
        assert!(
            manifest_text(&package)
                .unwrap()
                .contains("fmu-build\", default-features = false")
        );
        package.source = Some("registry+https://github.com/rust-lang/crates.io-index".into());
        assert_eq!(packer(&package).unwrap(), "version = \"=1.2.3\"");
        (package.source, package.shell) = (None, "/nowhere/fmi2".into());
        let told = manifest_text(&package).unwrap_err().to_string();
        assert!(
            told.starts_with("there is no folder fmu-build above /nowhere/fmi2"),
            "{told}"
        );
    }

    #[test]
    fn paths_are_quoted_for_both_files() {
        assert_eq!(quoted("C:\\a \"b\""), "\"C:\\\\a \\\"b\\\"\"");
    }

    #[test]
    fn a_package_that_two_lock_files_know_is_there_once() {
        let own = "version = 4\n\n[[package]]\nname = \"a\"\nversion = \"1.0.0\"\ndependencies = [\n \"b\",\n]\n";
        let ours = "version = 4\n\n[[package]]\nname = \"a\"\nversion = \"1.0.0\"\n\n[[package]]\nname = \"b\"\nversion = \"2.0.0\"\n";
        let both = merged(own, ours);
        assert_eq!(both.matches("name = \"a\"").count(), 1);
        assert!(both.contains("\"b\",") && both.contains("2.0.0"), "{both}");
    }
}
