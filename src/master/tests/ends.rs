//! `cosim run` with an FMU that asks to end the simulation at 0.25 s (fmi2Terminated): rows until then are written.
//!
//! Needs `.venv` with `cosim_native`, as `cargo xtask test` makes it.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod c_fmu;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/ends.c");
const XML: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Ends" guid="g">
    <CoSimulation modelIdentifier="Ends"/><ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="output"><Real/></ScalarVariable>
    </ModelVariables><ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
    </fmiModelDescription>"#;
const SYSTEM: &str = "[system]\nname = 's'\nstep = 0.125\nstop = 1.0\nscenario = 's.csv'\n\
                      [components.part]\nfmu = 'Ends.fmu'\n";
const SAID: &str = "part asked to end the simulation at 0.25 s (fmi2Terminated)";

/// Writes the FMU and a system file of it into a folder.
fn write(folder: &Path, compiler: &[&str]) -> PathBuf {
    c_fmu::write(&folder.join("Ends.fmu"), SOURCE, compiler, "Ends", XML);
    fs::write(folder.join("s.csv"), "time,u\n0,0\n1,0\n").unwrap();
    let system = folder.join("s.toml");
    fs::write(&system, SYSTEM).unwrap();
    system
}

/// Runs the FMU; its exit code, what it tells, and the rows it keeps.
fn tabled(compiler: &[&str], words: &[&str]) -> (Option<i32>, String, String) {
    let folder = TempDir::new().unwrap();
    let system = write(folder.path(), compiler);
    let out = folder.path().join("out.csv");
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(system).args(words);
    command.arg("--fmu-dir").arg(folder.path());
    let done = command.arg("--out").arg(&out).output().unwrap();
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    (done.status.code(), told, fs::read_to_string(out).unwrap())
}

/// Runs the FMU; its exit code, what it tells, and the last row it keeps.
fn run(compiler: &[&str], words: &[&str]) -> (Option<i32>, String, String) {
    let (code, told, table) = tabled(compiler, words);
    (
        code,
        told,
        table.lines().last().unwrap_or_default().to_owned(),
    )
}

/// What `dct-harness run` keeps of the same FMU.
fn by_harness(engine: &str, words: &[&str]) -> (Option<i32>, String) {
    let folder = TempDir::new().unwrap();
    let system = write(folder.path(), &[]);
    let python = concat!(env!("CARGO_MANIFEST_DIR"), "/../../.venv/bin/python");
    let mut command = Command::new(python);
    command.args(["-m", "dct_harness.cli", "run", "--engine", engine]);
    command.arg(system).arg("--fmu-dir").arg(folder.path());
    command.args(words).arg("--out").arg(folder.path());
    let done = command.output().unwrap();
    let table = fs::read_to_string(folder.path().join("results.csv"));
    let told = String::from_utf8_lossy(&done.stderr);
    let table = table.unwrap_or_else(|error| panic!("results.csv: {error}\n{told}"));
    (done.status.code(), table)
}

#[test]
fn all_masters_keep_the_same_rows() {
    for words in [&[][..], &["--step", "0.1"], &["--stop", "0.25"]] {
        let (code, told, table) = tabled(&[], words);
        for engine in ["fmpy", "native"] {
            let theirs = by_harness(engine, words);
            assert_eq!((code, table.clone()), theirs, "{engine}, {words:?}: {told}");
        }
    }
}

#[test]
fn an_end_at_a_communication_point_keeps_its_row() {
    let (code, told, last) = run(&[], &[]);
    assert_eq!((code, last.as_str()), (Some(4), "0.25,0.25"), "{told}");
    assert!(
        told.ends_with(&format!("cosim: {SAID}, before the run's stop\n")),
        "{told}"
    );
}

#[test]
fn an_end_within_a_step_keeps_the_rows_before_it() {
    let (code, told, last) = run(&[], &["--step", "0.1"]);
    assert_eq!((code, last.as_str()), (Some(4), "0.2,0.2"), "{told}");
    assert!(told.contains(SAID), "{told}");
}

#[test]
fn an_end_at_the_stop_is_a_whole_run() {
    let (code, told, last) = run(&[], &["--stop", "0.25", "--verbose"]);
    assert_eq!((code, last.as_str()), (Some(0), "0.25,0.25"), "{told}");
    let noted = SAID.trim_start_matches("part ");
    assert!(
        told.contains(&format!("s part [harness] {noted}\n")),
        "{told}"
    );
}

#[test]
fn an_fmu_without_the_function_is_not_asked() {
    let (code, told, last) = run(&["-DMISSING"], &[]);
    assert_eq!((code, last.as_str()), (Some(4), "0.125,0.125"), "{told}");
    assert!(
        told.contains("it cannot take this step and takes no other one"),
        "{told}"
    );
}
