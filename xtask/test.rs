//! `cargo xtask test`: every check, the quick ones first, pytest and its summary last.

use crate::beside::beside;
use crate::dependencies;
use crate::fuzz;
use crate::native::{self, MASTER};
use crate::packages;
use crate::plan::Step;
use crate::platforms::{self, Compiler};
use crate::setup::{Package, Project};
use std::process::Command;

/// The library for control units is one too: without std it needs panic = "abort".
const ECU: &str = "examples/ecu_observer/Cargo.toml";

/// The fuzz targets are another: they are built with counters.
const FUZZ: &str = "tests/fuzz/Cargo.toml";

/// How long each fuzz target runs, in each of two ways [s].
const FUZZ_SECONDS: u32 = 60;

/// Where the words of what is built beside the Rust tests are until they are shown.
const BESIDE: &str = "target/beside.log";

/// The steps of `cargo xtask test`.
pub fn steps(project: &Project) -> Vec<Step> {
    let compiler = Compiler::choose(false);
    let mut steps = quick(project);
    steps.extend(platforms::tools(project, compiler));
    let mut compiled = vec![fuzz::build(project)];
    compiled.extend(platforms::checks(project, compiler));
    steps.extend(beside(
        "fuzz targets and platforms",
        BESIDE.into(),
        compiled,
        of_this_machine(project),
    ));
    steps.push(fuzz::campaign(FUZZ_SECONDS));
    steps.push(Step::commands("Python tests", vec![pytest(project)]));
    steps
}

/// What needs no FMU.
fn quick(project: &Project) -> Vec<Step> {
    vec![
        project.system_packages(&[
            Package::Chromium,
            Package::Tbb,
            Package::Valgrind,
            Package::AnyRustSource,
        ]),
        project.python_packages(),
        Step::commands("formatters: rustfmt, ruff", formatters(project)),
        Step::commands("linter: ruff", vec![project.venv("ruff", &["check"])]),
        Step::commands(
            "linter: clippy",
            vec![clippy(project, &["--workspace"]), ecu_clippy(project)],
        ),
        dependencies::step(project),
    ]
}

/// Tests in Rust, and what they and those in Python need.
fn of_this_machine(project: &Project) -> Vec<Step> {
    vec![
        Step::commands("Rust tests", vec![project.cargo(&["test", "--workspace"])]),
        Step::commands("Rust docs without warnings", vec![docs(project)]),
        packages::step(project),
        project.fmus(),
        project.small_fmu(),
        native::module(project),
        native::checks(
            project,
            clippy(project, &["--manifest-path", MASTER, "--workspace"]),
        ),
        native::repeat(project),
    ]
}

fn formatters(project: &Project) -> Vec<Command> {
    vec![
        project.cargo(&["fmt", "--all", "--check"]),
        project.cargo(&["fmt", "--check", "--manifest-path", MASTER]),
        project.cargo(&["fmt", "--check", "--manifest-path", ECU]),
        project.cargo(&["fmt", "--check", "--manifest-path", FUZZ]),
        project.venv("ruff", &["format", "--check", "--quiet"]),
    ]
}

fn clippy(project: &Project, scope: &[&str]) -> Command {
    let mut command = project.cargo(&["clippy", "--quiet", "--all-targets"]);
    command.args(scope).args(["--", "-D", "warnings"]);
    command
}

/// Of the library alone: without std it can have no tests in Rust.
fn ecu_clippy(project: &Project) -> Command {
    let mut command = project.cargo(&["clippy", "--quiet", "--manifest-path", ECU]);
    command.args(["--target-dir", "target/ecu_observer"]);
    command.args(["--", "-D", "warnings"]);
    command
}

fn docs(project: &Project) -> Command {
    let mut command = project.cargo(&["doc", "--quiet", "--workspace", "--no-deps"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    command
}

fn pytest(project: &Project) -> Command {
    let words = ["-m", "pytest", "tests", "-ra", "-p", "pytest_no_skips"];
    let mut command = project.venv("python", &words);
    command.env("PYTHONPATH", "tests"); // where the plugin is
    command
}
