//! `src/master`: the compiled master, a workspace of its own because its build needs libclang.

use crate::plan::{Failure, Step, execute};
use crate::setup::Project;
use crate::words::Words;
use std::process::Command;

/// Its manifest.
pub const MASTER: &str = "src/master/Cargo.toml";

/// Where wheels are built.
const WHEELS: &str = "target/wheels";

/// Clippy and the tests, which run system files both here and by `dct-harness`, whose native engine is the [`module`].
pub fn checks(project: &Project, clippy: Command) -> Step {
    let project = project.clone();
    Step::new(
        "closed loop through the fmi crate: src/master",
        move |words| {
            let mut test = project.cargo(&["test", "--release"]);
            test.args(["--manifest-path", MASTER]);
            test.args(["-p", "cosim-master", "-p", "cosim-raw"]);
            with_bindgen(words, &project, [clippy, test])
        },
    )
}

/// Builds the Python module `cosim_native` and puts it into `.venv`.
pub fn module(project: &Project) -> Step {
    let project = project.clone();
    Step::new(
        "compiled master as a Python module into .venv",
        move |words| {
            let mut build = project.venv("maturin", &["build", "--release", "--quiet"]);
            build.args(["--manifest-path", "src/master/python/Cargo.toml"]);
            build.args(["--out", WHEELS, "--interpreter"]);
            build.arg(std::path::absolute(".venv/bin/python").unwrap_or_default());
            with_bindgen(words, &project, [build])?;
            let mut install = project.venv("python", &["-m", "pip", "install", "--quiet"]);
            install.args([
                "--no-deps",
                "--no-index",
                "--force-reinstall",
                "--find-links",
            ]);
            install.args([WHEELS, "cosim-native"]);
            execute(words, install)
        },
    )
}

/// Puts the program that the benchmarks compare the module with into `target/bench/bin`.
pub fn repeat(project: &Project) -> Step {
    let project = project.clone();
    Step::new(
        "compiled master without Python, for the benchmarks",
        move |words| {
            let mut install = project.cargo(&["install", "--quiet", "--locked", "--force"]);
            install.args(["--path", "src/master", "--example", "repeat"]);
            install.args(["--root", "target/bench", "--no-track"]);
            with_bindgen(words, &project, [install])
        },
    )
}

fn with_bindgen<const N: usize>(
    words: &Words,
    project: &Project,
    commands: [Command; N],
) -> Result<(), Failure> {
    let bindgen = project.bindgen()?;
    commands.into_iter().try_for_each(|mut command| {
        command.envs(bindgen.clone());
        execute(words, command)
    })
}
