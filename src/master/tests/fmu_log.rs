//! `cosim run --fmu-log`: an FMU of others that refuses a value says why, if it is asked to.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod c_fmu;

use std::fs;
use std::process::Command;
use tempfile::TempDir;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/refuses.c");
const XML: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Refuses" guid="g">
    <CoSimulation modelIdentifier="Refuses"/><ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
    </ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
    </fmiModelDescription>"#;
const SYSTEM: &str = "[system]\nname = 's'\nstep = 0.1\nstop = 1.0\nscenario = 's.csv'\n\
                      [components.part]\nfmu = 'Refuses.fmu'\n";
/// Above 1 from 0.6 s on.
const SCENARIO: &str = "time,u\n0,0\n0.5,1\n1,2\n";

/// The run ends with code 4 and this after its sentence; the rows before the refusal are there.
#[track_caller]
fn check(words: &[&str], said: &str) {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name);
    c_fmu::write(&file("Refuses.fmu"), SOURCE, &[], "Refuses", XML);
    fs::write(file("s.toml"), SYSTEM).unwrap();
    fs::write(file("s.csv"), SCENARIO).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(file("s.toml")).args(words);
    command.arg("--fmu-dir").arg(folder.path());
    let done = command.arg("--out").arg(file("out.csv")).output().unwrap();
    let told = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(4), "{told}");
    let sentence = "cosim: part: fmi2SetReal at t = 0.6 s returned fmi2Error";
    assert_eq!(told, format!("{sentence}{said}\n"));
    let table = fs::read_to_string(file("out.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 7, "{table}");
}

#[test]
fn it_says_why_when_it_is_asked_to() {
    check(&["--fmu-log"], "\n  logStatusError: u = 1.2 is above 1");
}

#[test]
fn else_the_option_that_asks_it_is_told() {
    check(&[], "; its log is off: --fmu-log lets it say why");
}
