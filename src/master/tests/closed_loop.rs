//! System files run here and by fmpy (`dct-harness`) must agree to the last bit.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod both;

use both::{Loop, Table, column, root, shipped};
use cosim_master::{Job, Libraries, Outcome, System, Watch, run_all};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use tempfile::TempDir;

/// Clutch 1 carries torque forward, the vehicle moves forward and the engine keeps turning.
fn is_a_launch(table: &Table) {
    let last = |name| *column(table, name).last().unwrap();
    assert!(last("plant.vehicle.speed") > 0.1);
    assert!(last("plant.clutch1.torque") > 5.0);
    assert_eq!(last("plant.clutch2.torque"), 0.0);
    let engine = column(table, "plant.engine.speed");
    let turns = engine.iter().all(|omega| (30.0..600.0).contains(omega));
    assert!(turns, "engine.speed");
}

#[test]
fn the_shipped_systems_agree_with_fmpy() {
    for (system, words) in [
        ("paper_case1.toml", &[][..]),
        (
            "paper_case2.toml",
            &["--set", "observer.observer.method=kalman"],
        ),
        ("torque_tracking_case1.toml", &["--step", "0.0007"]),
        ("friction_fade_case2.toml", &["--step", "0.01"]),
        ("paper_case1.toml", &["--step", "0.01", "--interpolate"]),
        ("launch_wet6.toml", &[]),
    ] {
        let system = shipped(system);
        let table = Loop { system, words }.agreed();
        assert!(column(&table, "plant.vehicle.speed").last().unwrap() > &0.1);
    }
}

#[test]
fn the_launch_is_one() {
    let words = &["--set", "plant.transmission.rigid=true"];
    let system = shipped("paper_case1.toml");
    is_a_launch(&Loop { system, words }.agreed());
}

/// A loop of its own: Jacobi, parts of a step, a connection with a factor, a last shorter step.
#[test]
fn every_way_of_coupling_agrees_with_fmpy() {
    let [held, along] = [false, true].map(coupled);
    assert!(held != along, "slopes have no effect");
}

fn coupled(interpolate: bool) -> Table {
    let folder = TempDir::new().unwrap();
    let system = folder.path().join("own.toml");
    let scenario = shipped("scenarios/torque_tracking.csv");
    let text = format!(
        r#"
        [system]
        name = "own"
        step = 0.013
        stop = 1.0
        scenario = {scenario:?}
        coupling = "jacobi"
        interpolate = {interpolate}
        [components.control]
        fmu = "DctClutchControl.fmu"
        parameters = {{ "feedback.enabled" = true }}
        [components.plant]
        fmu = "DctPlant.fmu"
        substeps = 3
        parameters = [{{ "engine.speed_start" = 10.0 }}, {{ "engine.speed_start" = 90 }}]
        [components.observer]
        fmu = "DctObserver.fmu"
        [[connections]]
        from = "plant.wheel.speed"
        to = "observer.wheel.speed"
        factor = 1.01
        "#
    );
    std::fs::write(&system, text).unwrap();
    let table = Loop { system, words: &[] }.agreed();
    assert!(
        column(&table, "observer.driveShaft.torque")
            .iter()
            .any(|t| *t != 0.0)
    );
    table
}

#[test]
fn recorded_signals_are_those_of_a_run_that_keeps_all() {
    let names = [
        "observer.driveShaft.torque",
        "scenario.engine.torque",
        "plant.engine.speed",
    ];
    let system = shipped("torque_tracking_case1.toml");
    let out = TempDir::new().unwrap();
    let all = Loop {
        system: system.clone(),
        words: &[],
    }
    .by_master(out.path());
    let words: Vec<&str> = names.iter().flat_map(|name| ["--record", name]).collect();
    let some = Loop {
        system,
        words: &words,
    }
    .by_master(out.path());
    assert_eq!(some.0, ["time", names[0], names[1], names[2]]);
    for name in names {
        assert_eq!(column(&some, name), column(&all, name), "{name}");
        assert!(
            column(&some, name).iter().any(|value| *value != 0.0),
            "{name}"
        );
    }
}

/// Rows of so many runs that differ in the vehicle's mass, made by so many threads.
fn rows(runs: usize, stop: f64, threads: usize) -> Vec<Vec<f64>> {
    let mut libraries = Libraries::default();
    let mut system = System::load(&shipped("paper_case1.toml")).unwrap();
    system.stop = stop;
    let times = system.times().unwrap();
    let scenario = system.scenario().unwrap().0;
    let fmus = root().join("target/fmu");
    let mut jobs = vec![];
    for k in 0..runs {
        let mass = 1400.0 + 100.0 * f64::from(u32::try_from(k).unwrap());
        let mass = cosim_master::plan::Value::Number(mass);
        system.set("plant", "vehicle.mass", mass).unwrap();
        jobs.push(system.plan(&fmus, &scenario, &mut libraries).unwrap());
    }
    let script = scenario.rows(&jobs[0].0.script, &jobs[0].1, &times);
    let jobs: Vec<Job<'_>> = jobs
        .into_iter()
        .map(|(plan, _)| Job {
            plan,
            times: &times,
            script: &script,
        })
        .collect();
    let found = Mutex::new(vec![vec![]; jobs.len()]);
    let keep = |number: usize, outcome: Outcome| {
        assert!(outcome.error.is_none(), "{:?}", outcome.error);
        found.lock().unwrap()[number] = outcome.rows;
    };
    let threads = NonZero::new(threads).unwrap();
    run_all(&jobs, &libraries, threads, &Watch::default(), keep);
    found.into_inner().unwrap()
}

#[test]
fn threads_change_no_bit() {
    let (one, four) = (rows(3, 2.0, 1), rows(3, 2.0, 4));
    assert!(one == four, "rows differ");
    assert!(one[0] != one[1], "the mass has no effect");
    assert!(one.iter().all(|rows| rows.len() > 2_000 * 50));
}

/// 64 threads hold 192 instances at once, of three libraries that each is loaded once.
#[test]
fn sixty_four_threads_change_no_bit() {
    let (one, many) = (rows(64, 1.0, 1), rows(64, 1.0, 64));
    assert!(one == many, "rows differ");
    assert!(
        one.windows(2).all(|pair| pair[0] != pair[1]),
        "all runs are one"
    );
}

/// A system file beside this project's scenarios, whose sensors are noisy.
fn noisy(folder: &Path, more: &str) -> PathBuf {
    let text = std::fs::read_to_string(shipped("paper_case1.toml")).unwrap();
    let scenarios = shipped("scenarios").display().to_string();
    let noise = "\n[noise]\nseed = 7\n\"plant.wheel.speed\" = 0.05\n\"plant.engine.speed\" = 0.1\n";
    let text = text.replace("scenarios/", &format!("{scenarios}/")) + noise + more;
    std::fs::write(folder.join("noisy.toml"), text).unwrap();
    folder.join("noisy.toml")
}

#[test]
fn sensors_hear_the_noise_that_the_harness_has_drawn() {
    let out = TempDir::new().unwrap();
    let system = noisy(
        out.path(),
        "\"plant.output.speed\" = 0.0\n\"plant.damper.speed\" = 0.2\n",
    );
    let told = Loop {
        system: system.clone(),
        words: &[],
    }
    .by_fmpy(out.path());
    let file = out.path().join("fmpy/results.csv").display().to_string();
    let heard = Loop {
        system,
        words: &["--noise", &file],
    }
    .by_master(out.path());
    assert_eq!(heard.0, told.0);
    assert!(heard.1 == told.1, "rows differ");
    let noise = column(&heard, "scenario.noise.plant.engine.speed");
    assert!(noise.iter().any(|value| value.abs() > 0.2));
    assert!(
        !heard
            .0
            .contains(&"scenario.noise.plant.damper.speed".to_owned()),
        "nobody reads it"
    );
}

#[test]
fn noise_that_is_not_there_is_told() {
    let out = TempDir::new().unwrap();
    let short = out.path().join("short.csv");
    std::fs::write(&short, "time,scenario.noise.plant.wheel.speed\n0,0\n1,0\n").unwrap();
    let short = short.display().to_string();
    let fmus = root().join("target/fmu").display().to_string();
    for (more, words, said) in [
        (
            "",
            vec![],
            "take it from results of `dct-harness run`: --noise results.csv",
        ),
        (
            "",
            vec!["--noise", &short],
            "short.csv: is of other communication points",
        ),
        (
            "",
            vec!["--noise", &short, "--step", "1", "--stop", "1"],
            "short.csv: has no column 'scenario.noise.plant.engine.speed'",
        ),
        (
            "\"plant.speed\" = 1\n",
            vec![],
            "'plant.speed' of [noise] is no real output",
        ),
        (
            "",
            vec!["--interpolate"],
            "white noise has no slopes; leave interpolate out",
        ),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cosim"));
        command
            .arg("run")
            .arg(noisy(out.path(), more))
            .args(["--fmu-dir", &fmus]);
        let done = command.args(words).output().unwrap();
        let told = String::from_utf8_lossy(&done.stderr);
        assert!(told.contains(said), "{told}");
        assert_eq!(done.status.code(), Some(2), "{told}");
    }
}
