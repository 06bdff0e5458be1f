//! `cargo xtask bench`: performance gates against C FMUs, by `benches/run.py`.

use crate::native;
use crate::plan::Step;
use crate::setup::{Package, Project};

/// The steps of `cargo xtask bench growth`: cost of the compiled master as the work grows.
pub fn growth(project: &Project) -> Vec<Step> {
    let measure = project.venv("python", &["benches/growth.py"]);
    vec![
        project.python_packages(),
        project.fmus(),
        native::module(project),
        Step::commands("measure", vec![measure]),
    ]
}

/// The steps of `cargo xtask bench`; `flags` go to `benches/run.py`.
pub fn steps(project: &Project, flags: &[&str]) -> Vec<Step> {
    let mut measure = project.venv("python", &["benches/run.py"]);
    measure.args(flags);
    vec![
        project.system_packages(&[Package::Tbb, Package::Valgrind, Package::AnyRustSource]),
        project.python_packages(),
        project.fmus(),
        project.small_fmu(),
        native::module(project),
        native::repeat(project),
        Step::commands("measure", vec![measure]),
    ]
}
