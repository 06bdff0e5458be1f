//! `cosim run` that a time limit or a signal ends: the rows so far are written.
//!
//! Needs `target/fmu/*.fmu`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use cosim_master::Seconds;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Steps of the plant in a communication step: with them a run takes half a minute and more.
const SUBSTEPS: &str = "\n[components.plant]\nsubsteps = 4000\n";

const SAMPLES: usize = 30_001;

/// With a process that starts, on a busy machine too.
const PATIENCE: Duration = Duration::from_secs(600);

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The shipped loop, slowed down.
fn slow(folder: &Path) -> PathBuf {
    let loops = root().join("examples/closed_loop");
    let text = std::fs::read_to_string(loops.join("paper_case1.toml")).unwrap();
    let scenarios = loops.join("scenarios").display().to_string();
    let text = text.replace("scenarios/", &format!("{scenarios}/"));
    let text = text.replace("\n[components.plant]\n", SUBSTEPS);
    assert!(text.contains(SUBSTEPS) && text.contains(&scenarios));
    let path = folder.join("slow.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn begin(folder: &Path, words: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
    command.arg("run").arg(slow(folder)).args(words);
    command.arg("--fmu-dir").arg(root().join("target/fmu"));
    command.arg("--out").arg(folder.join("out.csv"));
    std::fs::create_dir(folder.join("tmp")).unwrap();
    command.env("TMPDIR", folder.join("tmp"));
    command.stderr(Stdio::piped()).spawn().unwrap()
}

/// A run that ended early with this code; its rows are there, and what was told names the last one.
fn ended(folder: &Path, done: &Output, code: i32, why: &str) {
    let told = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(code), "{told}");
    let table = std::fs::read_to_string(folder.join("out.csv")).unwrap();
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert!((1..SAMPLES).contains(&rows.len()), "{} rows", rows.len());
    let last = rows.last().and_then(|row| row.split(',').next()).unwrap();
    let last = Seconds(last.parse().unwrap());
    assert_eq!(
        told.trim_end(),
        format!("cosim: stopped at t = {last} s: {why}")
    );
}

#[test]
fn a_time_limit_ends_a_run_with_code_5() {
    let folder = TempDir::new().unwrap();
    let run = begin(folder.path(), &["--timeout", "5"]);
    let done = run.wait_with_output().unwrap();
    ended(
        folder.path(),
        &done,
        5,
        "not finished after 5 s (--timeout)",
    );
}

/// Waits until a run has unpacked something of an FMU: it listens to signals before it does.
fn listens(folder: &Path) {
    let end = Instant::now() + PATIENCE;
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    while !entries(&folder.join("tmp")).any(|own| entries(&own.path()).next().is_some()) {
        assert!(Instant::now() < end, "it unpacks nothing");
        sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_signal_ends_a_run_with_code_130() {
    for (signal, name) in [(2, "Ctrl-C"), (15, "SIGTERM")] {
        let folder = TempDir::new().unwrap();
        let run = begin(folder.path(), &[]);
        listens(folder.path());
        let mut kill = Command::new("kill");
        kill.arg(format!("-{signal}")).arg(run.id().to_string());
        assert!(kill.status().unwrap().success());
        let done = run.wait_with_output().unwrap();
        ended(folder.path(), &done, 130, &format!("interrupted by {name}"));
    }
}
