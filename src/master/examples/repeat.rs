//! Runs one plan many times and keeps nothing: for `benches/loops.py`, beside the Python module.
//!
//! `repeat PLAN TIMES SCRIPT RUNS THREADS`: PLAN is JSON; TIMES and SCRIPT hold f64, row by row.

#![allow(clippy::print_stderr)] // whoever measures reads it

use cosim_master::{Job, Libraries, Plan, Watch, run_all};
use std::env::args;
use std::error::Error;
use std::fs::read;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = args().skip(1).collect();
    let [plan, times, script, runs, threads] = words.as_slice() else {
        return Err("repeat PLAN TIMES SCRIPT RUNS THREADS".into());
    };
    let plan: Plan = serde_json::from_slice(&read(plan)?)?;
    let (times, script) = (numbers(&read(times)?), numbers(&read(script)?));
    let job = Job {
        plan,
        times: &times,
        script: &script,
    };
    let jobs = vec![job; runs.parse()?];
    run_all(
        &jobs,
        &Libraries::default(),
        threads.parse()?,
        &Watch::default(),
        |k, outcome| {
            if let Some(error) = outcome.error {
                eprintln!("run {k}: {error}");
            }
        },
    );
    Ok(())
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (whole, _) = bytes.as_chunks();
    whole
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect()
}
