//! The dynamic library of an FMU: built by cargo, found through cargo's own messages.

use crate::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
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
    match (env::consts::OS, env::consts::ARCH) {
        ("linux", "x86_64") => Ok(("linux64", "so")),
        ("windows", "x86_64") => Ok(("win64", "dll")),
        ("macos", _) => Ok(("darwin64", "dylib")),
        (os, arch) => Err(Error::UnknownPlatform {
            platform: format!("{os} {arch}"),
        }),
    }
}

/// Builds the library of `package`, which cargo finds in `folder`, in release mode; returns its bytes.
///
/// The release profile strips symbols; paths of this machine are taken out, so that two checkouts
/// give the same bytes.
///
/// # Errors
/// When cargo fails or the package makes no dynamic library.
pub(crate) fn build(package: &str, folder: &Path) -> Result<Vec<u8>> {
    let output = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args([
            "build",
            "--release",
            "--locked",
            "--message-format=json-render-diagnostics",
        ])
        .args(["--package", package])
        .env("CARGO_ENCODED_RUSTFLAGS", flags(folder).join("\u{1f}"))
        .current_dir(folder)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|source| Error::Io {
            path: "cargo".into(),
            source,
        })?;
    if !output.status.success() {
        return Err(Error::Cargo {
            package: package.into(),
        });
    }
    let path =
        cdylib(&String::from_utf8_lossy(&output.stdout)).ok_or_else(|| Error::NoLibrary {
            package: package.into(),
        })?;
    fs::read(&path).map_err(|source| Error::Io { path, source })
}

/// Compiler flags of FMU libraries.
fn flags(folder: &Path) -> Vec<String> {
    let mut flags = vec![remap(folder, "model"), remap(workspace(), "dct")];
    flags.extend(cargo_home().map(|home| remap(&home, "cargo")));
    if cfg!(target_os = "linux") {
        // Name libm where it is used: importers other than Python may not have it loaded.
        flags.push("-Clink-arg=-lm".into());
    }
    flags
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
    target: Target,
    #[serde(default)]
    filenames: Vec<PathBuf>,
}

#[derive(Default, Deserialize)]
struct Target {
    #[serde(default)]
    crate_types: Vec<String>,
}

fn cdylib(messages: &str) -> Option<PathBuf> {
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
    let extension = env::consts::DLL_EXTENSION;
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
        assert_eq!(cdylib(&messages.join("\n")), Some(PathBuf::from(name)));
        assert_eq!(cdylib(&messages[0]), None);
    }
}
