//! `cosim run` with an FMU that never returns from a call: told, and the rows before it are written.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod c_fmu;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/stuck.c");
const XML: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Stuck" guid="g">
    <CoSimulation modelIdentifier="Stuck"/><ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="output"><Real/></ScalarVariable>
    </ModelVariables><ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
    </fmiModelDescription>"#;
const SYSTEM: &str = "[system]\nname = 's'\nstep = 0.1\nstop = 1.0\nscenario = 's.csv'\n\
                      [components.other]\nfmu = 'Other.fmu'\n[components.late]\nfmu = 'Late.fmu'\n";
const REMEDY: &str = "another --step may get past this time, else who made the FMU must mend it";
const SAID: &str = "logStatusWarning: looks for a root";

/// A folder with a system of two FMUs, of which one hangs in a function.
struct Place(TempDir);

impl Place {
    fn new(function: &str) -> Self {
        let place = Self(TempDir::new().unwrap());
        place.fmu("Other", "nowhere");
        place.fmu("Late", function);
        fs::write(place.file("s.toml"), SYSTEM).unwrap();
        fs::write(place.file("s.csv"), "time,u\n0,0\n1,0\n").unwrap();
        fs::create_dir(place.file("tmp")).unwrap();
        place
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn fmu(&self, name: &str, function: &str) {
        let path = self.file(&format!("{name}.fmu"));
        let hang = format!("-DHANG=\"{function}\"");
        c_fmu::write(&path, SOURCE, &[&hang], "Stuck", XML);
    }

    fn begin(&self, words: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.arg("run").arg(self.file("s.toml")).args(words);
        command.arg("--fmu-dir").arg(self.0.path());
        command.arg("--out").arg(self.file("out.csv"));
        command.env("TMPDIR", self.file("tmp"));
        command.env("HUNG", self.file("hung"));
        command.stderr(Stdio::piped()).spawn().unwrap()
    }

    /// The run ends with this code and sentence, with so many rows; the time is that of the last one.
    #[track_caller]
    fn check(&self, run: Child, code: i32, said: &str, kept: usize) {
        let done = run.wait_with_output().unwrap();
        let told = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(code), "{told}");
        assert!(self.file("hung").exists(), "{told}");
        assert_eq!(told, format!("cosim: late: {said}; {REMEDY}\n  {SAID}\n"));
        let table = fs::read_to_string(self.file("out.csv")).unwrap_or_default();
        let rows: Vec<&str> = table.lines().skip(1).collect();
        assert_eq!(rows.len(), kept, "{table}");
        for (k, row) in rows.iter().enumerate() {
            let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            assert_eq!(cells.len(), 3);
            let time = 0.1 * f64::from(u32::try_from(k).unwrap());
            assert!(
                cells.iter().all(|cell| (cell - time).abs() < 1e-12),
                "{row}"
            );
        }
        assert_eq!(fs::read_dir(self.file("tmp")).unwrap().count(), 0);
    }
}

fn waited(file: &Path) {
    let end = Instant::now() + Duration::from_secs(600); // on a busy machine too
    while !file.exists() {
        assert!(Instant::now() < end, "it does not hang");
        sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_step_that_never_ends_is_told_at_the_time_limit() {
    let place = Place::new("fmi2DoStep");
    let said = "fmi2DoStep at t = 0.4 s does not return: not finished after 5 s (--timeout)";
    place.check(place.begin(&["--timeout", "5"]), 5, said, 5);
}

#[test]
fn a_step_that_never_ends_is_told_at_a_signal() {
    for (signal, name) in [("-INT", "Ctrl-C"), ("-TERM", "SIGTERM")] {
        let place = Place::new("fmi2DoStep");
        let run = place.begin(&[]);
        waited(&place.file("hung"));
        let mut kill = Command::new("kill");
        assert!(
            kill.args([signal, &run.id().to_string()])
                .status()
                .unwrap()
                .success()
        );
        let said = format!("fmi2DoStep at t = 0.4 s does not return: interrupted by {name}");
        place.check(run, 130, &said, 5);
    }
}

#[test]
fn other_calls_that_never_end_are_told_too() {
    for (function, time, rows) in [("fmi2Instantiate", "0", 0), ("fmi2Terminate", "1", 11)] {
        let place = Place::new(function);
        let why = "not finished after 5 s (--timeout)";
        let said = format!("{function} at t = {time} s does not return: {why}");
        place.check(place.begin(&["--timeout", "5"]), 5, &said, rows);
    }
}
