//! Columns `plant.…` of a scenario where no plant runs: what was measured of it, recorded as `dct-harness` does.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod both;

use both::{Loop, column, root, shipped};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const TRUTH: &str = "plant.driveShaft.torque";
const STATE: &str = "plant.clutch1.state";
const UNKNOWN: &str = "plant.driveshaft.torque";

/// An observer on a drive of two rows, with the measured torque, a state and a column that no plant shows.
fn drive(folder: &Path) -> PathBuf {
    let speeds = "engine.speed,clutch1.speed,clutch2.speed,wheel.speed";
    let csv = format!(
        "time,{STATE},engine.torque,{speeds},{TRUTH},{UNKNOWN}\n0,2,50,90,20,15,1.5,0.1,7\n1.7,3,80,120,40,30,3,300.7,8\n"
    );
    std::fs::write(folder.join("drive.csv"), csv).unwrap();
    let given =
        "\"road.grade\" = 0.0\n\"brake.torque\" = 0.0\n\"shaft1.gear\" = 1\n\"shaft2.gear\" = 2\n";
    let clutches = ["position", "pressure"].map(|what| {
        let rows = [1, 2].map(|k| format!("\"clutch{k}.{what}\" = 0.0\n"));
        rows.concat()
    });
    let text = format!(
        "[system]\nname = \"drive\"\nstep = 0.01\nstop = 1.0\nscenario = \"drive.csv\"\n\
         [components.observer]\nfmu = \"DctObserver.fmu\"\n[components.observer.parameters]\n{given}{}",
        clutches.concat()
    );
    std::fs::write(folder.join("drive.toml"), text).unwrap();
    folder.join("drive.toml")
}

#[test]
fn what_was_measured_is_recorded_as_by_the_harness() {
    let folder = TempDir::new().unwrap();
    let system = drive(folder.path());
    let words = &["--step", "0.0137"];
    let table = Loop { system, words }.agreed();
    let last = |name: &str| *column(&table, name).last().unwrap();
    assert_eq!((last(TRUTH), last(STATE), last(UNKNOWN)), (300.7, 3.0, 8.0));
    assert!(
        column(&table, STATE)
            .iter()
            .all(|state| state.fract() == 0.0)
    );
}

#[test]
fn one_of_them_is_recorded_beside_a_signal_of_the_loop() {
    let folder = TempDir::new().unwrap();
    let estimate = "observer.driveShaft.torque";
    let words = &["--record", TRUTH, "--record", estimate];
    let system = drive(folder.path());
    let table = Loop { system, words }.by_master(folder.path());
    assert_eq!(table.0, ["time", estimate, TRUTH]);
}

fn said(folder: &Path, words: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(drive(folder)).args(words);
    command.arg("--fmu-dir").arg(root().join("target/fmu"));
    let done = command
        .arg("--out")
        .arg(folder.join("out.csv"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), text)
}

#[test]
fn a_column_that_no_plant_shows_is_named() {
    let folder = TempDir::new().unwrap();
    let (code, text) = said(folder.path(), &[]);
    let hint = format!("no plant shows '{UNKNOWN}'; did you mean '{TRUTH}'?");
    assert!(code == Some(0) && text.contains(&hint), "{text}");
}

#[test]
fn a_run_that_would_record_nothing_of_the_loop_is_refused() {
    let folder = TempDir::new().unwrap();
    let (code, text) = said(folder.path(), &["--record", TRUTH]);
    assert!(
        code == Some(2) && text.contains("name one of an FMU, too"),
        "{text}"
    );
}

#[test]
fn beside_a_plant_they_are_not_read() {
    let folder = TempDir::new().unwrap();
    let (csv, path) = (
        shipped("scenarios/positions.csv"),
        folder.path().join("more.csv"),
    );
    let text = std::fs::read_to_string(csv).unwrap();
    let more = |(k, line): (usize, &str)| match k {
        0 => format!("{line},{TRUTH}\n"),
        _ => format!("{line},7\n"),
    };
    std::fs::write(
        &path,
        text.lines().enumerate().map(more).collect::<String>(),
    )
    .unwrap();
    let words = &["--step", "0.01", "--scenario", path.to_str().unwrap()];
    let system = shipped("paper_case1.toml");
    let table = Loop { system, words }.agreed();
    assert!(column(&table, TRUTH).iter().all(|torque| *torque != 7.0));
}
