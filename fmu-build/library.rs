//! The dynamic library of an FMU: built by cargo, found through cargo's own messages.

use crate::compiler::{Compiler, build_small_std};
use crate::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::{env, fs};

/// Folder of the workspace.
#[must_use]
pub fn workspace() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package)
}

/// FMI 2.0's name of the platform this program runs on, e.g. `linux64`, and its library extension.
///
/// # Errors
/// On platforms that FMI 2.0 does not name.
pub fn platform() -> Result<(&'static str, &'static str)> {
    named(env::consts::ARCH, env::consts::OS)
}

/// The folder of `binaries/` and the library extension of a machine.
///
/// FMI 2.0 names no ARM machines; `aarch64-linux` is FMI 3.0's name, which importers have taken over.
fn named(architecture: &str, system: &str) -> Result<(&'static str, &'static str)> {
    match (architecture, system) {
        ("x86_64", "linux") => Ok(("linux64", "so")),
        ("aarch64", "linux") => Ok(("aarch64-linux", "so")),
        ("x86_64", "windows") => Ok(("win64", "dll")),
        ("x86_64", "macos" | "darwin") => Ok(("darwin64", "dylib")),
        ("aarch64", "macos" | "darwin") => Ok(("aarch64-darwin", "dylib")),
        (architecture, system) => Err(Error::UnknownPlatform {
            platform: format!("{architecture} {system}"),
        }),
    }
}

/// What a library is built for: this machine, or a target of rustc.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// Rust's name, e.g. `x86_64-pc-windows-gnullvm`; `None`: this machine.
    triple: Option<String>,
    /// Oldest glibc to run with, e.g. `2.17`: zig links against its symbols.
    glibc: Option<String>,
    /// Folder of `binaries/`.
    pub platform: &'static str,
    extension: &'static str,
    /// With a standard library of its own.
    small: bool,
}

impl Target {
    /// This machine, linked as its compiler does.
    ///
    /// # Errors
    /// On platforms that FMI 2.0 does not name.
    pub fn host() -> Result<Self> {
        let (platform, extension) = platform()?;
        Ok(Self {
            triple: None,
            glibc: None,
            platform,
            extension,
            small: false,
        })
    }

    /// A target of rustc; `.2.17` behind one for Linux asks for that glibc.
    ///
    /// # Errors
    /// When FMI has no name for it.
    pub fn parse(text: &str) -> Result<Self> {
        let (triple, glibc) = match text.split_once('.') {
            Some((triple, version)) => (triple, Some(version.to_owned())),
            None => (text, None),
        };
        let mut words = triple.split('-');
        let (architecture, system) = (words.next().unwrap_or_default(), words.nth(1));
        let (platform, extension) = named(architecture, system.unwrap_or_default())?;
        Ok(Self {
            triple: Some(triple.into()),
            glibc,
            platform,
            extension,
            small: false,
        })
    }

    /// The same with a library of some two thirds the size: its standard library is built along, without what
    /// prints where a panic came from. The compiler needs the sources of the standard library for that.
    #[must_use]
    pub fn small(mut self) -> Self {
        self.small = true;
        self
    }

    /// Name of a library in the FMU.
    pub(crate) fn member(&self, model: &str) -> String {
        format!("binaries/{}/{model}.{}", self.platform, self.extension)
    }

    /// `build`, or `zigbuild` of cargo-zigbuild, with the target. A standard library is built for a named one only.
    fn words(&self, compiler: &Compiler) -> Vec<String> {
        let here = || compiler.host().filter(|_| self.small);
        let Some(triple) = self.triple.clone().or_else(here) else {
            return vec!["build".into()];
        };
        let (verb, target) = match &self.glibc {
            Some(version) => ("zigbuild", format!("{triple}.{version}")),
            None => ("build", triple),
        };
        vec![verb.into(), "--target".into(), target]
    }

    fn compiler(&self) -> Result<Compiler> {
        if self.small {
            Compiler::with_sources()
        } else {
            Ok(Compiler::present())
        }
    }
}

/// Builds the library of `package`, which cargo finds in `folder`, in release mode; returns its bytes.
///
/// The release profile strips symbols; paths of this machine are taken out, so that two checkouts
/// give the same bytes.
///
/// # Errors
/// When cargo fails or the package makes no dynamic library.
pub(crate) fn build(package: &str, folder: &Path, target: &Target) -> Result<Vec<u8>> {
    let compiler = target.compiler()?;
    let flags = flags(folder, target, &compiler).join("\u{1f}");
    let mut command = compiler.command();
    if target.small {
        build_small_std(&mut command);
    }
    let output = command
        .args(target.words(&compiler))
        .args(["--release", "--locked", "--package", package])
        .arg("--message-format=json-render-diagnostics")
        .env("CARGO_ENCODED_RUSTFLAGS", flags)
        .current_dir(folder)
        .stderr(Stdio::inherit())
        .output()
        .map_err(Error::io("cargo"))?;
    if !output.status.success() {
        return Err(Error::Cargo {
            package: package.into(),
        });
    }
    let messages = String::from_utf8_lossy(&output.stdout);
    let path = cdylib(&messages, target.extension).ok_or_else(|| Error::NoLibrary {
        package: package.into(),
    })?;
    fs::read(&path).map_err(Error::io(&path))
}

/// Compiler flags of FMU libraries.
fn flags(folder: &Path, target: &Target, compiler: &Compiler) -> Vec<String> {
    let mut flags = vec![remap(folder, "model"), remap(workspace(), "dct")];
    flags.extend(root(folder, compiler).map(|root| remap(&root, "dct")));
    flags.extend(cargo_home().map(|home| remap(&home, "cargo")));
    // A standard library that is built here names its sources, too; others say /rustc already.
    let sources = compiler.sources();
    flags.extend(sources.map(|sources| remap(&sources, "/rustc")));
    if target.small {
        // LLVM writes out loops to 300 instructions each: 28 KiB of a plant, which save 4 % of a step.
        flags.push("-Cllvm-args=-unroll-threshold=80".into());
        // Nor does `fmi2-cosim` read many Reals by a function of their own.
        flags.push("--cfg=fmi2_small".into());
    }
    if target.extension == "so" {
        // Name libm where it is used: importers other than Python may not have it loaded.
        flags.push("-Clink-arg=-lm".into());
        if target.small && target.glibc.is_none() {
            // Segments close together in the file and not on pages of their own; zig's linker has no such word.
            flags.push("-Clink-arg=-Wl,-z,noseparate-code".into());
        }
    }
    flags
}

/// Folder of the workspace that `folder` is in: another than ours for a package of one's own.
fn root(folder: &Path, compiler: &Compiler) -> Option<PathBuf> {
    let printed = compiler
        .command()
        .args(["locate-project", "--workspace", "--message-format=plain"])
        .current_dir(folder)
        .output()
        .ok()?;
    let manifest = String::from_utf8(printed.stdout).ok()?;
    Path::new(manifest.trim()).parent().map(Path::to_path_buf)
}

fn remap(from: &Path, to: &str) -> String {
    format!("--remap-path-prefix={}={to}", from.display())
}

fn cargo_home() -> Option<PathBuf> {
    let given = env::var_os("CARGO_HOME").map(PathBuf::from);
    given.or_else(|| env::home_dir().map(|home| home.join(".cargo")))
}

/// One of cargo's messages; only those about artifacts have these fields.
#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    target: Made,
    #[serde(default)]
    filenames: Vec<PathBuf>,
}

#[derive(Default, Deserialize)]
struct Made {
    #[serde(default)]
    crate_types: Vec<String>,
}

fn cdylib(messages: &str, extension: &str) -> Option<PathBuf> {
    let messages = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok());
    let files = messages
        .filter(|message| {
            message
                .target
                .crate_types
                .iter()
                .any(|kind| kind == "cdylib")
        })
        .flat_map(|message| message.filenames);
    files
        .into_iter()
        .find(|file| file.extension().is_some_and(|found| found == extension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_found_among_cargos_messages() {
        let name = format!("/t/libDctPlant.{}", env::consts::DLL_EXTENSION);
        let messages = [
            r#"{"reason":"compiler-artifact","target":{"crate_types":["lib"]},"filenames":["/t/a.rlib"]}"#
                .to_owned(),
            format!(
                r#"{{"reason":"compiler-artifact","target":{{"crate_types":["cdylib"]}},"filenames":["/t/x.d","{name}"]}}"#
            ),
            r#"{"reason":"build-finished","success":true}"#.to_owned(),
        ];
        assert_eq!(
            cdylib(&messages.join("\n"), env::consts::DLL_EXTENSION),
            Some(PathBuf::from(name))
        );
        assert_eq!(cdylib(&messages[0], env::consts::DLL_EXTENSION), None);
    }

    #[test]
    fn targets_have_the_folder_that_fmi_names() {
        for (text, folder, verb) in [
            ("x86_64-unknown-linux-gnu.2.17", "linux64", "zigbuild"),
            (
                "aarch64-unknown-linux-gnu.2.17",
                "aarch64-linux",
                "zigbuild",
            ),
            ("x86_64-pc-windows-gnullvm", "win64", "build"),
            ("aarch64-apple-darwin", "aarch64-darwin", "build"),
        ] {
            let target = Target::parse(text).unwrap();
            assert_eq!(target.platform, folder);
            assert_eq!(target.words(&Compiler::present()), [verb, "--target", text]);
        }
        let error = Target::parse("riscv64gc-unknown-linux-gnu").unwrap_err();
        assert!(error.to_string().contains("riscv64gc linux"), "{error}");
    }
}
