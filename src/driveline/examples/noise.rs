//! What noise costs the method `calibrating`, seed by seed: how many runs miss a goal, on which drive, by how much.
//!
//! `cargo run --release -p dct-driveline --example noise` drives all scenarios with white noise of 0.1 rad/s on every speed,
//! once for each of seeds 201 to 260, and prints a row of Markdown for each scenario as soon as it is done: the median over
//! the seeds and the most of each torque, in % of its RMS over the drive, and the seeds that miss a goal. Other seeds stand
//! behind it, as in `-- 21-120`, and behind them names of scenarios, which leave the others out.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    clippy::print_stdout,
    clippy::print_stderr,
    dead_code,
    reason = "a program on the bench of the tests"
)]

#[path = "../tests/drives/bench/mod.rs"]
mod bench;

use bench::sensors::noisy;
use bench::{Drive, Scenario, observe, scenarios};
use dct_driveline::observer::{Method, Selected, Settings};
use std::ops::RangeInclusive;
use std::process::ExitCode;
use std::thread;

/// Communication step [s].
const H: f64 = 1e-3;
/// Deviation of the noise [rad/s].
const SIGMA: f64 = 0.1;
/// Goals: RMSE of T_c1/T_c2/T_o [% of RMS].
const GOALS: [f64; 3] = [5.5, 5.5, 2.5];
/// Seeds that chose nothing.
const SEEDS: &str = "201-260";
const USAGE: &str = "noise FIRST-LAST [DRIVE ...], as in: noise 201-260 creep kick-down";

/// RMSE of each torque, shape (3) [% of RMS].
type Percent = [f64; 3];

/// A drive with the noise of a seed.
fn run(drive: &Drive, seed: u64) -> Percent {
    let mut observer = Selected::new(Method::Calibrating);
    let (settings, sensors) = (Settings::CASE_1, noisy(SIGMA, seed));
    observe(
        drive,
        &mut observer,
        &drive.p,
        &settings,
        sensors,
        |_, _| {},
    )
    .percent()
}

/// Every seed, on all processors.
fn runs(drive: &Drive, seeds: &[u64]) -> Vec<Percent> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let share = seeds.len().div_ceil(threads);
    thread::scope(|scope| {
        let some = |part| scope.spawn(move || Vec::from_iter(part_of(drive, part)));
        let started: Vec<_> = seeds.chunks(share).map(some).collect();
        let done = started.into_iter().map(|thread| thread.join());
        done.flat_map(|part| part.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

fn part_of(drive: &Drive, seeds: &[u64]) -> impl Iterator<Item = Percent> {
    seeds.iter().map(|seed| run(drive, *seed))
}

/// One of each torque, as in the other tables.
fn cell(percent: Percent) -> String {
    percent.map(|each| format!("{each:.2}")).join("/")
}

/// Each torque by itself, from the least to the most.
fn sorted(all: &[Percent]) -> [Vec<f64>; 3] {
    [0, 1, 2].map(|k| {
        let mut one: Vec<f64> = all.iter().map(|percent| percent[k]).collect();
        one.sort_by(f64::total_cmp);
        one
    })
}

/// Seeds that miss a goal.
fn missed(seeds: &[u64], all: &[Percent]) -> Vec<u64> {
    let misses = |percent: &Percent| (0..3).any(|k| percent[k] > GOALS[k]);
    let both = seeds.iter().zip(all);
    both.filter(|(_, percent)| misses(percent))
        .map(|(seed, _)| *seed)
        .collect()
}

/// Runs a scenario and prints its row; how many runs missed.
fn row(scenario: &Scenario, seeds: &[u64]) -> usize {
    let all = runs(&scenario.drive(H), seeds);
    let (sorted, missed) = (sorted(&all), missed(seeds, &all));
    let of = |rank: usize| cell([0, 1, 2].map(|k| sorted[k][rank]));
    let (middle, most) = (of(seeds.len() / 2), of(seeds.len() - 1));
    let told = missed.iter().map(|seed| {
        let percent = all[(seed - seeds[0]) as usize];
        format!("{seed}: {}", cell(percent))
    });
    let told = Vec::from_iter(told).join(", ");
    let (name, runs, count) = (&scenario.name, seeds.len(), missed.len());
    println!("| {name} | {runs} | {count} | {middle} | {most} | {told} |");
    count
}

/// `201-260`.
fn range(word: &str) -> Option<RangeInclusive<u64>> {
    let (first, last) = word.split_once('-')?;
    let range = first.parse().ok()?..=last.parse().ok()?;
    (!range.is_empty()).then_some(range)
}

/// The scenarios of these names, or all.
fn named(names: &[String]) -> Result<Vec<Scenario>, String> {
    let all = scenarios::every();
    let known = |name: &String| all.iter().any(|scenario| scenario.name == *name);
    if let Some(name) = names.iter().find(|name| !known(name)) {
        let all: Vec<_> = all.iter().map(|scenario| scenario.name.as_str()).collect();
        return Err(format!("no drive \"{name}\": {}", all.join(" | ")));
    }
    let asked = |scenario: &Scenario| names.is_empty() || names.contains(&scenario.name);
    Ok(all.into_iter().filter(asked).collect())
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let seeds = range(words.first().map_or(SEEDS, String::as_str));
    let Some(seeds) = seeds.map(Vec::from_iter) else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    let drives = match named(words.get(1..).unwrap_or_default()) {
        Ok(drives) => drives,
        Err(fault) => {
            eprintln!("{fault}");
            return ExitCode::from(2);
        }
    };
    println!("| noise 0.1 rad/s | runs | missed | median | most | seeds that miss |");
    println!("| --- | --- | --- | --- | --- | --- |");
    let missed: usize = drives.iter().map(|drive| row(drive, &seeds)).sum();
    println!(
        "\n{missed} of {} runs miss {}",
        drives.len() * seeds.len(),
        cell(GOALS)
    );
    ExitCode::SUCCESS
}
