//! What `cosim run` says of FMUs, wiring and values that are wrong, and what it keeps.
//!
//! Needs `target/fmu/*.fmu`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

const MODELS: [&str; 3] = ["DctPlant", "DctObserver", "DctClutchControl"];
const LIBRARY: &str = "binaries/linux64/DctPlant.so";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A folder with a system file and the FMUs of the paper's loop, to be spoilt.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        for model in MODELS {
            let name = format!("{model}.fmu");
            let from = root().join("target/fmu").join(&name);
            std::fs::copy(from, folder.path().join(name)).unwrap();
        }
        let loops = root().join("examples/closed_loop");
        let text = std::fs::read_to_string(loops.join("torque_tracking_case1.toml")).unwrap();
        let text = text.replace("scenarios/torque_tracking.csv", "scenario.csv");
        std::fs::write(folder.path().join("loop.toml"), text).unwrap();
        let scenario =
            std::fs::read_to_string(loops.join("scenarios/torque_tracking.csv")).unwrap();
        let second: Vec<&str> = scenario.lines().take(102).collect();
        std::fs::write(folder.path().join("scenario.csv"), second.join("\n")).unwrap();
        Self(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn append(&self, name: &str, text: &str) {
        let whole = std::fs::read_to_string(self.file(name)).unwrap() + text;
        std::fs::write(self.file(name), whole).unwrap();
    }

    /// Gives a signal of the scenario another value, from 0.5 s on.
    fn spoil(&self, signal: &str, value: &str) {
        let text = std::fs::read_to_string(self.file("scenario.csv")).unwrap();
        let mut lines = text.lines();
        let head = lines.next().unwrap();
        let place = head.split(',').position(|name| name == signal).unwrap();
        let rows = lines.map(|line| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if cells[0].parse::<f64>().unwrap() >= 0.5 {
                cells[place] = value;
            }
            cells.join(",")
        });
        let rows: Vec<String> = std::iter::once(head.to_owned()).chain(rows).collect();
        std::fs::write(self.file("scenario.csv"), rows.join("\n")).unwrap();
    }

    /// Packs the plant anew; its library gets another name or other bytes.
    fn repack(&self, name: &str, bytes: Option<&[u8]>) {
        let mut archive = ZipArchive::new(File::open(self.file("DctPlant.fmu")).unwrap()).unwrap();
        let mut out = ZipWriter::new(File::create(self.file("new.fmu")).unwrap());
        for index in 0..archive.len() {
            let member = archive.by_index_raw(index).unwrap();
            match (member.name() == LIBRARY, bytes) {
                (true, Some(bytes)) => {
                    out.start_file(name, SimpleFileOptions::default()).unwrap();
                    out.write_all(bytes).unwrap();
                }
                (true, None) => out.raw_copy_file_rename(member, name).unwrap(),
                (false, _) => out.raw_copy_file(member).unwrap(),
            }
        }
        out.finish().unwrap();
        std::fs::rename(self.file("new.fmu"), self.file("DctPlant.fmu")).unwrap();
    }

    /// Runs the loop for 1 s; returns exit code, what is told, and the number of rows kept.
    fn run(&self) -> (Option<i32>, String, usize) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.arg("run").arg(self.file("loop.toml"));
        command
            .args(["--stop", "1", "--fmu-dir"])
            .arg(self.0.path());
        let out = self.file("results.csv");
        let done = command.arg("--out").arg(&out).output().unwrap();
        let rows = std::fs::read_to_string(out).map_or(0, |text| text.lines().count() - 1);
        let told = String::from_utf8_lossy(&done.stderr).into_owned();
        (done.status.code(), told, rows)
    }

    #[track_caller]
    fn check(&self, code: i32, said: &str, kept: usize) {
        let (found, told, rows) = self.run();
        assert!(told.contains(said), "{told}");
        assert_eq!((found, rows), (Some(code), kept), "{told}");
        let (first, messages) = told.split_once('\n').unwrap();
        assert!(first.starts_with("cosim: "), "{told}");
        assert!(
            messages.lines().all(|line| line.starts_with("  ")),
            "{told}"
        );
    }
}

#[test]
fn an_unspoilt_loop_runs() {
    let (code, told, rows) = Place::new().run();
    assert_eq!((code, rows), (Some(0), 1001), "{told}");
}

#[test]
fn a_missing_fmu_is_named() {
    let place = Place::new();
    std::fs::remove_file(place.file("DctObserver.fmu")).unwrap();
    place.check(
        3,
        "DctObserver.fmu: No such file or directory (--fmu-dir says where FMUs are)",
        0,
    );
}

#[test]
fn an_fmu_that_is_none_is_named() {
    let place = Place::new();
    std::fs::write(place.file("DctPlant.fmu"), "no archive").unwrap();
    place.check(3, "DctPlant.fmu: invalid Zip archive", 0);
}

#[test]
fn an_fmu_of_another_platform_is_told_with_the_platforms_it_has() {
    let place = Place::new();
    place.repack("binaries/win64/DctPlant.dll", None);
    place.check(
        3,
        &format!("has no {LIBRARY}; it has libraries for: win64"),
        0,
    );
}

#[test]
fn a_library_that_does_not_load_is_told_with_the_reason() {
    let place = Place::new();
    place.repack(LIBRARY, Some(b"no library"));
    place.check(3, "DctPlant.so: file too short", 0);
}

#[test]
fn a_connection_to_nothing_is_named() {
    let place = Place::new();
    let text = "[[connections]]\nfrom = \"plant.engine.speed\"\nto = \"observer.engine.sped\"\n";
    place.append("loop.toml", text);
    place.check(
        2,
        "'observer.engine.sped' of [[connections]] is no input; did you mean 'observer.engine.speed'?",
        0,
    );
}

#[test]
fn an_fmu_that_refuses_an_input_in_mid_run_is_told_with_its_time() {
    let place = Place::new();
    place.spoil("brake.torque", "-5");
    place.check(
        4,
        "plant: fmi2SetReal at t = 0.491 s returned fmi2Discard\n  logStatusDiscard: fmi2SetReal: brake.torque = ",
        492,
    );
}

#[test]
fn an_fmu_that_fails_in_mid_run_is_told_with_its_time() {
    let place = Place::new();
    place.spoil("engine.torque", "1e300");
    place.check(
        4,
        "plant: fmi2DoStep at t = 0.491 s returned fmi2Error",
        492,
    );
}

#[test]
fn a_component_that_has_no_name_or_no_steps_is_told_with_its_line() {
    for (old, new, said) in [
        (
            "[components.plant]",
            "[components.\"pl.ant\"]",
            "'pl.ant' is no name of a component",
        ),
        (
            "[components.plant]",
            "[components.plant]\nsubsteps = 0",
            "expected a nonzero u32",
        ),
        ("step = 0.001", "step = 1e-300", "step = 1e-300 s and stop"),
    ] {
        let place = Place::new();
        let text = std::fs::read_to_string(place.file("loop.toml")).unwrap();
        assert!(text.contains(old), "{old}");
        std::fs::write(place.file("loop.toml"), text.replacen(old, new, 1)).unwrap();
        place.check(2, said, 0);
    }
}
