//! `cargo xtask demo`: the paper's closed loop for both friction cases, and the report.

use crate::plan::{Failure, Step, execute};
use crate::setup::Project;
use crate::words::Words;
use std::path::Path;
use std::process::Command;

/// Result directory under `target/demo`, system file, feedback of the control.
const RUNS: [(&str, &str, Option<bool>); 13] = [
    ("methods_case1", "methods_case1", None),
    ("methods_case2", "methods_case2", None),
    ("calibration_case1", "calibration_case1", None),
    ("calibration_torque", "calibration_torque", None),
    ("calibration_worn", "calibration_worn", None),
    ("torque_tracking_case1", "torque_tracking_case1", Some(true)),
    (
        "torque_tracking_case1_no_feedback",
        "torque_tracking_case1",
        Some(false),
    ),
    ("torque_tracking_case2", "torque_tracking_case2", Some(true)),
    (
        "torque_tracking_case2_no_feedback",
        "torque_tracking_case2",
        Some(false),
    ),
    ("friction_fade_case1", "friction_fade_case1", Some(true)),
    (
        "friction_fade_case1_no_feedback",
        "friction_fade_case1",
        Some(false),
    ),
    ("friction_fade_case2", "friction_fade_case2", Some(true)),
    (
        "friction_fade_case2_no_feedback",
        "friction_fade_case2",
        Some(false),
    ),
];

const TITLE: &str = "Dual-clutch driveline: observer and closed loop";

/// The steps of `cargo xtask demo`.
pub fn steps(project: &Project, open: bool) -> Vec<Step> {
    let mut steps = vec![project.python_packages(), project.fmus()];
    steps.extend(RUNS.map(|(name, system, feedback)| {
        Step::commands(
            format!("run {name}"),
            vec![run(project, name, system, feedback)],
        )
    }));
    let project = project.clone();
    steps.push(Step::new("report", move |words| {
        report(&project, open, words)
    }));
    steps
}

fn run(project: &Project, name: &str, system: &str, feedback: Option<bool>) -> Command {
    let file = format!("examples/closed_loop/{system}.toml");
    let words = ["run", &file, "--format", "parquet", "--out"]; // of some runs 240 signals
    let mut command = project.venv("dct-harness", &words);
    command.arg(format!("target/demo/{name}"));
    if let Some(enabled) = feedback {
        command
            .arg("--set")
            .arg(format!("control.feedback.enabled={enabled}"));
    }
    command
}

fn report(project: &Project, open: bool, words: &Words) -> Result<(), Failure> {
    let verb = ["report", "--title", TITLE, "--out", "target/report"];
    let mut command = project.venv("dct-harness", &verb);
    command.args(RUNS.map(|(name, ..)| format!("target/demo/{name}")));
    execute(words, command)?;
    let page = Path::new("target/report/index.html");
    let page = page.canonicalize().map_err(|error| Failure::File {
        path: page.into(),
        error,
    })?;
    words.say(format_args!("\nopen file://{}", page.display()));
    if open {
        execute(words, opener(&page))
    } else {
        Ok(())
    }
}

fn opener(page: &Path) -> Command {
    let (program, words): (_, &[&str]) = match std::env::consts::OS {
        "macos" => ("open", &[]),
        "windows" => ("cmd", &["/c", "start", ""]),
        _ => ("xdg-open", &[]),
    };
    let mut command = Command::new(program);
    command.args(words).arg(page);
    command
}
