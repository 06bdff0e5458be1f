//! The crates that can be published are packed and built from their packages, without a warning.

use crate::plan::{Failure, Step, line};
use crate::setup::Project;
use std::fs;
use std::path::{Path, PathBuf};

/// The crates that a model of one's own needs, and the models of this workspace.
const PUBLISHABLE: [&str; 4] = ["fmi2-cosim", "dct-driveline", "dct-models", "fmu-build"];

/// Where they are built.
const TARGET: &str = "target/publish";

/// Packs the crates, unpacks them elsewhere and builds them there.
pub fn step(project: &Project) -> Step {
    let project = project.clone();
    Step::new("packages of the crates that can be published", move |_| {
        pack(&project)
    })
}

/// cargo has no switch that turns its warnings into errors, so they are looked for.
fn pack(project: &Project) -> Result<(), Failure> {
    forget_earlier_packages()?;
    let mut command = project.cargo(&["package", "--allow-dirty", "--offline"]);
    command.args(["--target-dir", TARGET]);
    command.args(PUBLISHABLE.iter().flat_map(|name| ["--package", name]));
    let what = match command.output() {
        Err(error) => format!("cargo could not be started ({error})"),
        Ok(done) => match complaint(
            done.status.success(),
            &String::from_utf8_lossy(&done.stderr),
        ) {
            None => return Ok(()),
            Some(what) => what,
        },
    };
    Err(Failure::Command {
        line: line(&command),
        what,
    })
}

/// Removes what an earlier run packed, unpacked and built: cargo takes a package of one name and
/// version for unchangeable, and would build the sources of then.
fn forget_earlier_packages() -> Result<(), Failure> {
    remove(Path::new(TARGET))?;
    let sources = cargo_home().map(|home| home.join("registry/src"));
    let registries = sources.and_then(|path| fs::read_dir(path).ok());
    for registry in registries.into_iter().flatten().flatten() {
        if registry.file_name().to_string_lossy().starts_with('-') {
            for name in PUBLISHABLE {
                let folder = format!("{name}-{}", env!("CARGO_PKG_VERSION"));
                remove(&registry.path().join(folder))?;
            }
        }
    }
    Ok(())
}

/// Where cargo keeps sources; those of registries without a host, like the one that packages are
/// verified from, in folders whose names begin with a dash.
fn cargo_home() -> Option<PathBuf> {
    let set = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    set.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")))
}

fn remove(folder: &Path) -> Result<(), Failure> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(Failure::File {
            path: folder.to_path_buf(),
            error,
        }),
        _ => Ok(()),
    }
}

/// All that cargo said when it failed, else its first warning.
fn complaint(success: bool, said: &str) -> Option<String> {
    let warning = said.lines().find(|line| line.starts_with("warning"));
    if success {
        warning.map(str::to_owned)
    } else {
        Some(format!("{said}\ncargo package failed"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_a_complaint_and_progress_is_none() {
        let said = "   Packaging a v0.1.0\nwarning: manifest has no description\n";
        let warning = complaint(true, said).unwrap();
        assert_eq!(warning, "warning: manifest has no description");
        assert_eq!(complaint(true, "   Packaging a v0.1.0\n"), None);
        assert!(
            complaint(false, "error: no\n")
                .unwrap()
                .contains("error: no")
        );
    }
}
