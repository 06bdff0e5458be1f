//! `cargo xtask bench`: performance ratios against C FMUs, by `benches/run.py`.

use crate::plan::Step;
use crate::setup::{Package, Project};

/// The steps of `cargo xtask bench`.
pub fn steps(project: &Project) -> Vec<Step> {
    let empty = project.cargo(&["build", "--quiet", "--release", "--package", "bench-empty"]);
    vec![
        project.system_packages(&[Package::Valgrind]),
        project.python_packages(),
        project.fmus(),
        Step::commands("empty FMU library in Rust", vec![empty]),
        Step::commands("measure", vec![project.venv("python", &["benches/run.py"])]),
    ]
}
