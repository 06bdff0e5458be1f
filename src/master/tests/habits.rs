//! What people expect of a command line: mistakes are told with what to do, and nobody has to listen.
//!
//! Needs `target/fmu/*.fmu`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn shipped() -> PathBuf {
    root().join("examples/closed_loop/paper_case1.toml")
}

/// `cosim run` of a file with our FMUs, its results in `folder`.
fn cosim(system: &Path, folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(system);
    command.arg("--fmu-dir").arg(root().join("target/fmu"));
    command.arg("--stop").arg("0.1").args(more);
    command.current_dir(folder);
    command
}

fn told(mut command: Command) -> (Option<i32>, String) {
    let done = command.output().unwrap();
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), said)
}

#[test]
fn a_mistake_is_told_with_its_exit_code() {
    let folder = TempDir::new().unwrap();
    let system = shipped();
    for (more, code, text) in [
        (
            ["--plant", "/nowhere/DctPlant.fmu"],
            3,
            "/nowhere/DctPlant.fmu: No such file or directory (--fmu-dir says where FMUs are)",
        ),
        (
            ["--set", "plant.nothing=1"],
            2,
            "'plant.nothing' does not exist",
        ),
        (
            ["--record", "plant.vehicle.sped"],
            2,
            "'plant.vehicle.sped' of the recorded signals does not exist; did you mean 'plant.vehicle.speed'?",
        ),
        (
            ["--set", "plnt.a=1"],
            2,
            "has no component 'plnt' (plant, observer); did you mean 'plant'?",
        ),
        (
            ["--set", "observer.observer.method=kalmn"],
            2,
            "has no item 'kalmn' (paper, lyapunov, energy, kalman, calibrating); did you mean 'kalman'?",
        ),
        (
            ["--set", "plant.vehicle.mass=1500kg"],
            2,
            "'plant.vehicle.mass' is Real [kg], got '1500kg'",
        ),
        (
            ["--set", "plant.vehicle.mass=-1"],
            2,
            "'plant.vehicle.mass' = -1 is refused: fmi2SetReal returned fmi2Discard",
        ),
        (
            ["--out", "."],
            2,
            "--out .: is a folder; name a file, ./results.csv",
        ),
        (
            ["--calibration", "."],
            2,
            "--calibration .: no calibration.ssv in this folder; `dct-harness run` writes it",
        ),
    ] {
        let (status, said) = told(cosim(&system, folder.path(), &more));
        assert_eq!(status, Some(code), "{more:?}: {said}");
        assert!(said.contains(text), "{more:?}: {said}");
    }
}

#[test]
fn what_is_no_system_file_is_told_with_what_one_is() {
    let folder = TempDir::new().unwrap();
    let fmu = root().join("target/fmu/DctPlant.fmu");
    let missing = Path::new("missing.toml");
    for (system, text) in [
        (
            folder.path(),
            "is a folder: name the system file itself, a .toml or .ssp",
        ),
        (
            &fmu,
            "is no text in UTF-8: a system file is a .toml or .ssp",
        ),
        (missing, "missing.toml: No such file or directory"),
    ] {
        let (status, said) = told(cosim(system, folder.path(), &[]));
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains(text), "{said}");
    }
}

#[test]
fn the_folder_of_the_results_is_made() {
    let folder = TempDir::new().unwrap();
    let system = shipped();
    let (status, said) = told(cosim(
        &system,
        folder.path(),
        &["--out", "new/folder/results.csv"],
    ));
    assert_eq!((status, said.as_str()), (Some(0), ""));
    assert!(folder.path().join("new/folder/results.csv").is_file());
}

#[test]
fn a_run_that_leaves_its_scenario_says_so() {
    let folder = TempDir::new().unwrap();
    let rows = std::fs::read_to_string(root().join("examples/closed_loop/scenarios/positions.csv"));
    let rows = rows.unwrap();
    let mut lines = rows.lines();
    let (names, first) = (lines.next().unwrap(), lines.next().unwrap());
    let at = |time: &str| format!("{time}{}", first.strip_prefix('0').unwrap());
    let script = folder.path().join("short.csv");
    std::fs::write(&script, [names, &at("0.02"), &at("0.05")].join("\n")).unwrap();
    let script = script.display().to_string();
    let (status, said) = told(cosim(&shipped(), folder.path(), &["--scenario", &script]));
    assert_eq!(status, Some(0));
    assert_eq!(
        said,
        "scenario short.csv begins at t = 0.02 s: its first values hold until then\n\
         scenario short.csv ends at t = 0.05 s: its last values hold from then on\n"
    );
}

#[test]
fn a_reader_that_has_closed_the_pipe_is_no_panic() {
    let folder = TempDir::new().unwrap();
    let system = shipped();
    let mut command = cosim(&system, folder.path(), &["--verbose"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = command.spawn().unwrap();
    drop((running.stdout.take(), running.stderr.take()));
    assert_eq!(running.wait().unwrap().code(), Some(0));
    assert!(folder.path().join("results.csv").is_file());
}
