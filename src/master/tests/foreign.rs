//! An FMU of others that refuses a value says why, if `cosim run --fmu-log` asks it to; a discrete input is held.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod c_fmu;

use std::fs;
use std::process::Command;
use tempfile::TempDir;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/refuses.c");
const XML: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Refuses" guid="g">
    <CoSimulation modelIdentifier="Refuses"/><ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" VARIABILITY><Real start="0"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
    </ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
    </fmiModelDescription>"#;
const SYSTEM: &str = "[system]\nname = 's'\nstep = 0.1\nstop = 1.0\nscenario = 's.csv'\n\
                      [components.part]\nfmu = 'Refuses.fmu'\n";
/// Above 1 from 0.6 s on.
const SCENARIO: &str = "time,u\n0,0\n0.5,1\n1,2\n";

/// Runs the FMU with an input of this variability; its exit code, what it tells, and how many rows it keeps.
fn run(variability: &str, words: &[&str]) -> (Option<i32>, String, usize) {
    let xml = XML.replace("VARIABILITY", &format!("variability=\"{variability}\""));
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name);
    c_fmu::write(&file("Refuses.fmu"), SOURCE, &[], "Refuses", &xml);
    fs::write(file("s.toml"), SYSTEM).unwrap();
    fs::write(file("s.csv"), SCENARIO).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(file("s.toml")).args(words);
    command.arg("--fmu-dir").arg(folder.path());
    let done = command.arg("--out").arg(file("out.csv")).output().unwrap();
    let told = String::from_utf8_lossy(&done.stderr).into_owned();
    let table = fs::read_to_string(file("out.csv")).unwrap();
    (done.status.code(), told, table.lines().count() - 1)
}

/// The run ends with code 4 and this after its sentence; the rows before the refusal are there.
#[track_caller]
fn check(words: &[&str], said: &str) {
    let sentence = "cosim: part: fmi2SetReal at t = 0.6 s returned fmi2Error";
    let expected = (Some(4), format!("{sentence}{said}\n"), 7);
    assert_eq!(run("continuous", words), expected);
}

#[test]
fn it_says_why_when_it_is_asked_to() {
    check(&["--fmu-log"], "\n  logStatusError: u = 1.2 is above 1");
}

#[test]
fn else_the_option_that_asks_it_is_told() {
    check(&[], "; its log is off: --fmu-log lets it say why");
}

#[test]
fn a_discrete_real_input_is_held_until_the_next_row() {
    // It is 1 from 0.5 s on, and 2 at the last communication point, from which no step begins.
    let (code, told, rows) = run("discrete", &[]);
    assert_eq!((code, rows), (Some(0), 11), "{told}");
}
