//! Libraries for macOS: linked and audited, never run, for there is no such machine here.

use super::compiler::{APPLE, Compiler};
use super::{GLIBC, MODELS, OUT, PACKAGER};
use crate::plan::{Failure, Step, execute};
use crate::setup::{Project, printed};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Apart from the FMUs that were run.
const FOLDER: &str = "darwin";

/// Builds FMUs with libraries for both kinds of Mac and reads what came out.
pub fn step(project: &Project, compiler: Compiler) -> Step {
    let title = "darwin64, aarch64-darwin: linked and audited, not run on a Mac";
    let (zig, check) = (zig(project), audit(project));
    Step::new(title, move |words| {
        let kit = kit(zig)?;
        execute(words, fmus(compiler, &kit)?)?;
        execute(words, check)
    })
}

/// Where the package `ziglang` is, which holds a list of what Apple's libSystem exports.
fn zig(project: &Project) -> Command {
    const WHERE: &str = "import os, ziglang; print(os.path.dirname(ziglang.__file__))";
    project.venv("python", &["-c", WHERE])
}

/// As much of Apple's SDK as a library without frameworks needs: the names in libSystem.
fn kit(zig: Command) -> Result<PathBuf, Failure> {
    let package = printed(zig).ok_or_else(|| Failure::Missing {
        what: "the Python package ziglang in .venv".into(),
        remedy: ".venv/bin/python -m pip install ziglang".into(),
    })?;
    let list = Path::new(&package).join("lib/libc/darwin/libSystem.tbd");
    let names = with_file(&list, fs::read_to_string(&list))?;
    let kit = std::path::absolute(OUT).unwrap_or_default().join("sdk");
    let libraries = kit.join("usr/lib");
    with_file(&libraries, fs::create_dir_all(&libraries))?;
    for library in ["libSystem", "libc", "libm"] {
        let file = libraries.join(library).with_extension("tbd");
        with_file(&file, fs::write(&file, known(&names)))?;
    }
    Ok(kit)
}

/// The list with kinds of processors that LLVM's linker knows: what is there for the newer
/// `arm64e` is there for `arm64`.
fn known(names: &str) -> String {
    let names = names.replace("arm64e-", "arm64-");
    names.replace("arm64e.x1-", "arm64e-")
}

fn with_file<T>(path: &Path, done: std::io::Result<T>) -> Result<T, Failure> {
    done.map_err(|error| Failure::File {
        path: path.into(),
        error,
    })
}

/// With a library for this machine beside them, or `check` would refuse the FMU.
fn fmus(compiler: Compiler, kit: &Path) -> Result<Command, Failure> {
    let tools = tools()?;
    let mut command = Command::new(PACKAGER);
    command.args(["build", "--out"]).arg(out());
    let here = format!("x86_64-unknown-linux-gnu.{GLIBC}");
    for target in [here.as_str()].into_iter().chain(APPLE) {
        command.args(["--target", target]);
    }
    compiler.equip(&mut command, &[&tools]);
    for target in APPLE {
        let name = target.to_uppercase().replace('-', "_");
        let linker = format!("CARGO_TARGET_{name}_LINKER");
        command.env(linker, tools.join("rust-lld"));
    }
    command.env("SDKROOT", kit);
    Ok(command)
}

fn out() -> PathBuf {
    Path::new(OUT).join(FOLDER)
}

/// LLVM's linker and what strips symbols: rustup's compiler brings both.
fn tools() -> Result<PathBuf, Failure> {
    let mut command = Command::new("rustc");
    command.args(["--print", "target-libdir"]);
    let library = printed(command).map(PathBuf::from);
    let tools = library.and_then(|folder| Some(folder.parent()?.join("bin")));
    let found = tools.filter(|folder| folder.join("rust-lld").exists());
    found.ok_or_else(|| Failure::Missing {
        what: "rust-lld, the linker that comes with Rust".into(),
        remedy: "install Rust from https://rustup.rs".into(),
    })
}

fn audit(project: &Project) -> Command {
    let mut command = project.cargo(&["fmu", "check"]);
    command.args(MODELS.map(|model| out().join(model).with_extension("fmu")));
    command
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_mac_is_of_a_kind_that_the_linker_knows() {
        let names = "targets: [ x86_64-macos, arm64e-macos, arm64e.x1-macos ]";
        let known = "targets: [ x86_64-macos, arm64-macos, arm64e-macos ]";
        assert_eq!(super::known(names), known);
    }
}
