//! One loop by `cosim run` and by `dct-harness run`, which must agree to the last bit.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

pub type Table = (Vec<String>, Vec<Vec<f64>>);

/// Seconds of the scenarios: clutch 1 has begun to carry torque and the vehicle moves.
pub const STOP: &str = "3";

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
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

/// A system file, and what the command line says beside it.
pub struct Loop<'a> {
    pub system: PathBuf,
    pub words: &'a [&'a str],
}

impl Loop<'_> {
    fn words(&self, verb: &str) -> Vec<String> {
        let mut words = vec![verb.to_owned(), self.system.display().to_string()];
        words.extend(["--stop", STOP, "--fmu-dir"].map(str::to_owned));
        words.push(root().join("target/fmu").display().to_string());
        words.extend(self.words.iter().map(|word| (*word).to_owned()));
        words
    }

    pub fn by_master(&self, out: &Path) -> Table {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command.args(self.words("run")).arg("--out");
        succeed(command.arg(out.join("master.csv")));
        read(&out.join("master.csv"))
    }

    pub fn by_fmpy(&self, out: &Path) -> Table {
        let mut command = Command::new(root().join(".venv/bin/python"));
        command.args(["-m", "dct_harness.cli"]);
        command.args(self.words("run")).args(["--quiet", "--out"]);
        let command = command.arg(out.join("fmpy"));
        // Exit code 1 says that a KPI misses its limit, as it may after three of thirty seconds.
        let done = command.output().unwrap();
        assert!(
            matches!(done.status.code(), Some(0 | 1)),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        read(&out.join("fmpy/results.csv"))
    }

    /// Runs both and returns the one result they agree on.
    pub fn agreed(&self) -> Table {
        let out = TempDir::new().unwrap();
        let (master, fmpy) = (self.by_master(out.path()), self.by_fmpy(out.path()));
        assert_eq!(master.0, fmpy.0, "names and their order");
        assert_eq!(master.1.len(), fmpy.1.len(), "number of rows");
        for (k, (ours, theirs)) in master.1.iter().zip(&fmpy.1).enumerate() {
            for ((name, value), other) in master.0.iter().zip(ours).zip(theirs) {
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

pub fn succeed(command: &mut Command) {
    let done = command.output().unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
}

/// A system file of the examples.
pub fn shipped(name: &str) -> PathBuf {
    root().join("examples/closed_loop").join(name)
}

pub fn column(table: &Table, name: &str) -> Vec<f64> {
    let index = table.0.iter().position(|known| known == name);
    let index = index.unwrap_or_else(|| panic!("no {name} among {:?}", table.0));
    table.1.iter().map(|row| row[index]).collect()
}
