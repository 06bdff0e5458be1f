//! Libraries of our FMUs stay loaded while they are open, so that the next run starts at once.
//!
//! Needs `target/fmu/*.fmu`, as `cargo xtask test` makes them. Alone in its process, whose libraries it counts.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use cosim_master::{Job, Libraries, System, Watch, run_all};
use std::num::NonZero;
use std::path::Path;
use std::sync::Mutex;

/// How often an FMU's library is in the memory of this process.
fn loaded() -> usize {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    let code = |line: &&str| line.contains(" r-xp ") && line.contains("/DctPlant.so");
    maps.lines().filter(code).count()
}

#[test]
fn a_library_is_loaded_once_for_all_runs_and_goes_with_its_file() {
    let mut libraries = Libraries::default();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join("examples/closed_loop/paper_case1.toml");
    let mut system = System::load(&file).unwrap();
    system.stop = 0.1;
    let (times, scenario) = (system.times().unwrap(), system.scenario().unwrap().0);
    let fmus = root.join("target/fmu");
    let (plan, held) = system.plan(&fmus, &scenario, &mut libraries).unwrap();
    let script = scenario.rows(&plan.script, &held, &times);
    let job = Job {
        plan,
        times: &times,
        script: &script,
    };
    assert_eq!(loaded(), 0, "opened is not loaded");
    let kept = Mutex::new(vec![]);
    for _ in 0..2 {
        let (jobs, threads) = ([job.clone(), job.clone()], NonZero::new(2).unwrap());
        run_all(
            &jobs,
            &libraries,
            threads,
            &Watch::default(),
            |_, outcome| {
                assert!(outcome.error.is_none(), "{:?}", outcome.error);
                kept.lock().unwrap().push(outcome.rows);
            },
        );
        assert_eq!(loaded(), 1, "after a run");
    }
    let kept = kept.into_inner().unwrap();
    assert!(kept.len() == 4 && kept.iter().all(|rows| *rows == kept[0]));
    drop(libraries);
    assert_eq!(loaded(), 0, "its file is gone");
}
