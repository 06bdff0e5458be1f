//! `--parameters` and `--calibration`: the numbers of `dct-harness run`, and its words for what is wrong.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod both;

use both::{Loop, column, root, shipped};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A parameter file with values as they are written there.
fn file(folder: &Path, values: &[&str]) -> PathBuf {
    let path = folder.join("given.ssv");
    let values = values.concat();
    let head = r#"<s:ParameterSet version="1.0" name="given" xmlns:s="http://ssp-standard.org/SSP1/SystemStructureParameterValues">"#;
    let text = format!("{head}<s:Parameters>{values}</s:Parameters></s:ParameterSet>");
    std::fs::write(&path, text).unwrap();
    path
}

fn real(name: &str, value: &str) -> String {
    format!(r#"<s:Parameter name="{name}"><s:Real {value}/></s:Parameter>"#)
}

#[test]
fn parameter_files_stand_above_the_system_and_below_set() {
    let folder = TempDir::new().unwrap();
    let mass = real("vehicle.mass", r#"value="2.5" unit="t""#);
    let stiff = real("driveShaft.stiffness", r#"value="5" unit="kN.m/rad""#);
    let given = file(folder.path(), &[&mass, &stiff]).display().to_string();
    let words = [
        "--parameters",
        "plant",
        &given,
        "--parameters",
        "observer",
        &given,
    ];
    let set = [&words[..], &["--set", "plant.vehicle.mass=1500"]].concat();
    let ran = |words| {
        let system = shipped("paper_case1.toml");
        let table = Loop { system, words }.agreed();
        *column(&table, "plant.vehicle.speed").last().unwrap()
    };
    let (own, heavy, light) = (ran(&[][..]), ran(&words[..]), ran(&set));
    assert!(heavy < own, "{heavy} {own}: 2.5 t have no effect");
    assert!(light > heavy, "{light} {heavy}: --set has no effect");
}

#[test]
fn observer_and_control_start_with_what_was_learnt() {
    let folder = TempDir::new().unwrap();
    let friction = real("clutch1.nominalFriction", r#"value="0.2" unit="1""#);
    let only_observer = real("calibration.inertiaErrorStart", r#"value="-0.1" unit="1""#);
    let given = file(folder.path(), &[&friction, &only_observer]);
    let given = given.display().to_string();
    let ran = |words| {
        let system = shipped("torque_tracking_case1.toml");
        Loop { system, words }.agreed()
    };
    let (own, learnt) = (ran(&[][..]), ran(&["--calibration", &given]));
    for name in ["control.clutch1.position", "observer.clutch1.torque"] {
        assert!(
            column(&own, name) != column(&learnt, name),
            "{name} is unchanged"
        );
    }
}

/// What `cosim run` and `dct-harness run` tell of the same words, each with exit code 2.
fn refused(words: &[String]) -> [String; 2] {
    let cosim = Command::new(env!("CARGO_BIN_EXE_cosim"));
    let mut harness = Command::new(root().join(".venv/bin/python"));
    harness.args(["-m", "dct_harness.cli"]);
    [cosim, harness].map(|mut command| {
        command.arg("run").args(words);
        let done = command
            .arg("--fmu-dir")
            .arg(root().join("target/fmu"))
            .output()
            .unwrap();
        let told = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{words:?}: {told}");
        told
    })
}

#[test]
fn both_tell_the_same_of_what_cannot_be() {
    let folder = TempDir::new().unwrap();
    let bad = file(
        folder.path(),
        &[&real("vehicle.mass", r#"value="1" unit="stone""#)],
    );
    let bad = bad.display().to_string();
    let system = shipped("paper_case1.toml").display().to_string();
    let alone = folder.path().join("alone.toml");
    let text = std::fs::read_to_string(&system).unwrap();
    let text = text.replace("[components.observer]", "[components.watcher]");
    std::fs::write(&alone, text.split("[[kpis]]").next().unwrap()).unwrap();
    let alone = alone.display().to_string();
    let empty = format!("--calibration={}", folder.path().display());
    for (words, expected) in [
        (
            [&*system, "--parameters", "plnt", &bad],
            format!("--parameters: {system} has no component 'plnt'"),
        ),
        (
            [&*system, "--parameters", "plant", &bad],
            format!("{bad}: parameter 'vehicle.mass': the unit 'stone' is not known (1, -, %, s,"),
        ),
        (
            [&*system, "--parameters", "plant", "missing.ssv"],
            "missing.ssv: ".to_owned(),
        ),
        (
            [&*alone, "--stop", "1", "--calibration=x.ssv"],
            format!("--calibration: {alone} has no component 'observer'"),
        ),
        (
            [&*system, "--stop", "1", &empty],
            format!(
                "{empty}: no calibration.ssv in this folder; `dct-harness run` writes it to --out"
            )
            .replace('=', " "),
        ),
    ] {
        for told in refused(&words.map(str::to_owned)) {
            assert!(told.contains(&expected), "{words:?}: {told}");
        }
    }
}
