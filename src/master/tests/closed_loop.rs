//! All three FMUs, stepped here and by fmpy (`dct-harness`), must agree to the last bit.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

type Table = (Vec<String>, Vec<Vec<f64>>);

/// Seconds of the scenarios: clutch 1 has begun to carry torque and the vehicle moves.
const STOP: &str = "3.0";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

fn fmu(file: &str) -> PathBuf {
    let path = root().join("target/fmu").join(file);
    assert!(
        path.exists(),
        "{} is missing: cargo fmu build",
        path.display()
    );
    path
}

fn read(path: &Path) -> Table {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names = lines
        .next()
        .unwrap()
        .split(',')
        .map(str::to_owned)
        .collect();
    let rows = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect());
    (names, rows.collect())
}

/// One loop: scenario, components in order, and values to set.
struct Loop {
    scenario: &'static str,
    components: &'static [(&'static str, &'static str)],
    values: &'static [(&'static str, &'static str, &'static str)],
}

const POSITIONS: Loop = Loop {
    scenario: "positions.csv",
    components: &[("plant", "DctPlant.fmu"), ("observer", "DctObserver.fmu")],
    values: &[("plant", "engine.speed_start", "90.0")],
};

const TORQUE_TRACKING: Loop = Loop {
    scenario: "torque_tracking.csv",
    components: &[
        ("plant", "DctPlant.fmu"),
        ("observer", "DctObserver.fmu"),
        ("control", "DctClutchControl.fmu"),
    ],
    values: &[
        ("plant", "engine.speed_start", "90.0"),
        ("control", "feedback.enabled", "true"),
    ],
};

impl Loop {
    fn scenario(&self) -> PathBuf {
        root()
            .join("examples/closed_loop/scenarios")
            .join(self.scenario)
    }

    fn by_master(&self, out: &Path) -> Table {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim-master"));
        command
            .arg("--scenario")
            .arg(self.scenario())
            .arg("--out")
            .arg(out.join("master.csv"));
        command.args(["--stop", STOP]);
        for (name, file) in self.components {
            command.arg(format!("{name}={}", fmu(file).display()));
        }
        for (component, variable, value) in self.values {
            command
                .arg("--set")
                .arg(format!("{component}.{variable}={value}"));
        }
        let done = command.output().unwrap();
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        read(&out.join("master.csv"))
    }

    fn by_fmpy(&self, out: &Path) -> Table {
        let mut system = format!(
            "[system]\nname = \"loop\"\nstep = 0.001\nstop = {STOP}\nscenario = {:?}\n",
            self.scenario()
        );
        for (name, file) in self.components {
            system +=
                &format!("[components.{name}]\nfmu = \"{file}\"\n[components.{name}.parameters]\n");
            for (_, variable, value) in self.values.iter().filter(|(owner, ..)| owner == name) {
                system += &format!("\"{variable}\" = {value}\n");
            }
        }
        std::fs::write(out.join("loop.toml"), system).unwrap();
        let mut command = Command::new(root().join(".venv/bin/python"));
        command
            .args(["-m", "dct_harness.cli", "run"])
            .arg(out.join("loop.toml"));
        command
            .arg("--fmu-dir")
            .arg(root().join("target/fmu"))
            .arg("--out")
            .arg(out.join("fmpy"));
        let done = command.output().unwrap();
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        read(&out.join("fmpy/results.csv"))
    }

    /// Runs both and returns the one result they agree on.
    fn agreed(&self) -> Table {
        let out = TempDir::new().unwrap();
        let (master, fmpy) = (self.by_master(out.path()), self.by_fmpy(out.path()));
        assert_eq!(master.1.len(), fmpy.1.len(), "number of rows");
        for (k, (ours, theirs)) in master.1.iter().zip(&fmpy.1).enumerate() {
            for (name, value) in master.0.iter().zip(ours) {
                let column = fmpy.0.iter().position(|other| other == name);
                let other = theirs[column.unwrap_or_else(|| panic!("fmpy has no {name}"))];
                assert_eq!(
                    value.to_bits(),
                    other.to_bits(),
                    "{name}, row {k}: {value} {other}"
                );
            }
        }
        master
    }
}

fn column(table: &Table, name: &str) -> Vec<f64> {
    let index = table.0.iter().position(|known| known == name);
    let index = index.unwrap_or_else(|| panic!("no {name} among {:?}", table.0));
    table.1.iter().map(|row| row[index]).collect()
}

/// Clutch 1 carries torque forward, the vehicle moves forward and the engine keeps turning.
fn is_a_launch(table: &Table) {
    let speed = column(table, "plant.vehicle.speed");
    let torque = column(table, "plant.clutch1.torque");
    let engine = column(table, "plant.engine.speed");
    assert_eq!(speed.len(), 3001);
    assert!(speed[3000] > 0.1, "vehicle.speed = {} m/s", speed[3000]);
    assert!(torque[3000] > 5.0, "clutch1.torque = {} N.m", torque[3000]);
    assert!(
        engine.iter().all(|omega| (30.0..600.0).contains(omega)),
        "engine.speed"
    );
    assert!(
        column(table, "plant.clutch2.torque")
            .iter()
            .all(|torque| *torque == 0.0)
    );
}

#[test]
fn positions_scenario_agrees_with_fmpy() {
    is_a_launch(&POSITIONS.agreed());
}

#[test]
fn torque_tracking_with_all_three_fmus_agrees_with_fmpy() {
    let table = TORQUE_TRACKING.agreed();
    is_a_launch(&table);
    let position = column(&table, "control.clutch1.position");
    assert!(
        position[3000] > 0.0,
        "clutch1.position = {} m",
        position[3000]
    );
}
