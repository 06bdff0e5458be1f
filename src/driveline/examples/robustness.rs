//! The tables of PAPER.md and docs/pages/accuracy.md: what errors of sensors and parameters cost every observer method.
//!
//! `cargo run --release -p dct-driveline --example robustness` prints them as Markdown: RMSE in % of the RMS
//! torque, T_c1/T_c2/T_o, at 1 kHz unless the heading says so, friction case 1, momentum load. With
//! `-- PAPER.md docs/pages/accuracy.md` behind it, the tables of those files which have one of their headings are replaced.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    clippy::print_stdout,
    dead_code,
    reason = "a program on the bench of the tests"
)]

#[path = "../tests/drives/bench/mod.rs"]
mod bench;

use bench::sensors::{
    delayed, dropping, encoder, glitching, noisy, perfect, torque_error, torque_offset, wheel_bias,
};
use bench::{Drive, Scenario, VOUCHED, after, calibrated, faded, observe, scenarios};
use dct_driveline::Params;
use dct_driveline::observer::{Method, Sample, Selected, Settings};
use std::ops::RangeInclusive;

/// Communication step [s].
const H: f64 = 1e-3;
/// Seeds of the random drives of which the worst is told.
const RANDOM: RangeInclusive<u64> = 1..=9;

/// One error: its name, what the observer believes, what the sensors read.
struct Error {
    name: &'static str,
    believed: fn(&mut Params),
    /// Ticks per revolution that the observer knows of; 0 of speeds that it takes as they are.
    ticks: f64,
    sensors: fn() -> Box<dyn FnMut(Sample) -> Sample>,
}

const fn sensor(name: &'static str, sensors: fn() -> Box<dyn FnMut(Sample) -> Sample>) -> Error {
    let believed = |_: &mut Params| {};
    Error {
        name,
        believed,
        ticks: 0.0,
        sensors,
    }
}

/// Encoders that the observer knows of.
const fn known(ticks: f64, error: Error) -> Error {
    Error { ticks, ..error }
}

const fn parameter(name: &'static str, believed: fn(&mut Params)) -> Error {
    let sensors = || -> Box<dyn FnMut(Sample) -> Sample> { Box::new(perfect) };
    Error {
        name,
        believed,
        ticks: 0.0,
        sensors,
    }
}

/// Every error by itself.
const ERRORS: [Error; 25] = [
    sensor("no error", || Box::new(perfect)),
    sensor("noise 0.1 rad/s on speeds", || Box::new(noisy(0.1, 1))),
    sensor("encoders of 4096 ticks", || Box::new(encoder(4096.0, H))),
    known(
        4096.0,
        sensor("the same, ticks known", || Box::new(encoder(4096.0, H))),
    ),
    sensor("encoders of 1024 ticks", || Box::new(encoder(1024.0, H))),
    known(
        1024.0,
        sensor("the same, ticks known", || Box::new(encoder(1024.0, H))),
    ),
    sensor("wheel speed +0.01 rad/s", || Box::new(wheel_bias)),
    sensor("T_e +5 % +2 N·m", || Box::new(torque_error)),
    sensor("speeds one step late", || Box::new(delayed())),
    sensor("1 % of the samples dropped", || Box::new(dropping(1))),
    sensor("4 times a second a speed is 0 for a sample", || {
        Box::new(glitching(0.0, H))
    }),
    parameter("J_e +20 %", |p| p.j_e *= 1.2),
    parameter("J_e −20 %", |p| p.j_e *= 0.8),
    parameter("J_v +20 %", |p| p.j_v *= 1.2),
    parameter("J_v −20 %", |p| p.j_v *= 0.8),
    parameter("J_ct +20 %", |p| p.j_ct = p.j_ct.map(|j| 1.2 * j)),
    parameter("J_ct −20 %", |p| p.j_ct = p.j_ct.map(|j| 0.8 * j)),
    parameter("k_o +10 %", |p| p.k_o *= 1.1),
    parameter("k_o −10 %", |p| p.k_o *= 0.9),
    parameter("c_o +20 %", |p| p.c_o *= 1.2),
    parameter("c_o −20 %", |p| p.c_o *= 0.8),
    parameter("k_d +20 %", |p| p.k_d *= 1.2),
    parameter("k_d −20 %", |p| p.k_d *= 0.8),
    parameter("M_v +10 %", |p| p.road.m_v *= 1.1),
    parameter("M_v −10 %", |p| p.road.m_v *= 0.9),
];

/// RMSE of a method under an error, shape (3) [% of RMS].
fn percent(method: Method, drive: &Drive, error: &Error) -> [f64; 3] {
    let mut believed = drive.p;
    (error.believed)(&mut believed);
    let mut observer = Selected::new(method);
    let settings = Settings {
        encoder: [error.ticks; 4],
        ..Settings::CASE_1
    };
    let sensors = (error.sensors)();
    let score = observe(
        drive,
        &mut observer,
        &believed,
        &settings,
        sensors,
        |_, _| {},
    );
    score.percent()
}

/// The same as a cell of the table.
fn cell(method: Method, drive: &Drive, error: &Error) -> String {
    percent(method, drive, error).map(rounded).join("/")
}

/// The largest of each torque over drives and errors, as a cell.
fn worst(method: Method, drives: &[Drive], errors: &[Error]) -> String {
    let all = drives
        .iter()
        .flat_map(|drive| errors.iter().map(move |error| (drive, error)));
    let largest = all.fold([0.0; 3], |most: [f64; 3], (drive, error)| {
        let found = percent(method, drive, error);
        [0, 1, 2].map(|k| most[k].max(found[k]))
    });
    largest.map(rounded).join("/")
}

/// Two significant figures; a whole number from 10 on.
fn rounded(percent: f64) -> String {
    let digits = usize::from(percent < 9.95);
    format!("{percent:.digits$}")
}

/// A table in Markdown, its heading first.
type Table = Vec<String>;

fn table(corner: &str, columns: &[String]) -> Table {
    let rule = "| --- ".repeat(columns.len() + 1);
    vec![
        format!("| {corner} | {} |", columns.join(" | ")),
        format!("{rule}|"),
    ]
}

fn methods(corner: &str) -> Table {
    table(
        corner,
        &Method::ALL.map(|method| format!("{method:?}").to_lowercase()),
    )
}

/// Every error of one drive.
fn errors(corner: &str, drive: &Drive) -> Table {
    let mut table = methods(corner);
    for error in &ERRORS {
        let cells = Method::ALL.map(|method| cell(method, drive, error));
        table.push(format!("| {} | {} |", error.name, cells.join(" | ")));
    }
    table
}

/// Drives of the second table and of those like it.
fn scenarios_told() -> impl Iterator<Item = Scenario> {
    let more = [faded::fading(), faded::losing()];
    more.into_iter().chain(scenarios::unseen())
}

/// Every drive at steps of `h` [s] with the first of `errors`; of random drives the most that any of them costs.
fn drives(corner: &str, h: f64, errors: &[Error]) -> Table {
    let mut table = methods(corner);
    for scenario in scenarios_told() {
        let drive = scenario.drive(h);
        let cells = Method::ALL.map(|method| cell(method, &drive, &errors[0]));
        table.push(format!("| {} | {} |", drive.name, cells.join(" | ")));
    }
    let random: Vec<Drive> = RANDOM
        .map(|seed| scenarios::random(seed).drive(h))
        .collect();
    let cells = Method::ALL.map(|method| worst(method, &random, errors));
    table.push(format!("| random 1-9, at worst | {} |", cells.join(" | ")));
    table
}

/// The paper's scenario at 100 Hz, then every other drive.
fn slow() -> Table {
    let mut table = drives("no error, 100 Hz", 1e-2, &ERRORS[..1]);
    let drive = scenarios::paper().drive(1e-2);
    let cells = Method::ALL.map(|method| cell(method, &drive, &ERRORS[0]));
    table.insert(2, format!("| paper's scenario | {} |", cells.join(" | ")));
    table
}

/// Every drive with noise; random drives with three seeds of it.
fn noise() -> Table {
    let seeds = [
        sensor("", || Box::new(noisy(0.1, 1))),
        sensor("", || Box::new(noisy(0.1, 2))),
        sensor("", || Box::new(noisy(0.1, 3))),
    ];
    drives("noise 0.1 rad/s", H, &seeds)
}

/// An error of T_e where nothing shows its offset, after a drive that did, and where the road does.
fn carried() -> Table {
    let (_, learnt) = calibrated(
        &scenarios::paper().drive(H),
        &Settings::CASE_1,
        torque_error,
    );
    let columns = [
        "T_e +5 % +2 N·m",
        "T_e +2 N·m alone",
        "+5 % +2 N·m, calibrated before",
        "+5 % +2 N·m, road told",
    ];
    let mut table = table("calibrating", &columns.map(str::to_owned));
    for scenario in [scenarios::tip_in_tip_out(), scenarios::kick_down()] {
        let drive = scenario.drive(H);
        let cell = |settings: &Settings, sensors: fn(Sample) -> Sample| {
            let (percent, _) = calibrated(&drive, settings, sensors);
            percent.map(rounded).join("/")
        };
        let cells = [
            cell(&Settings::CASE_1, torque_error),
            cell(&Settings::CASE_1, torque_offset),
            cell(&after(&learnt), torque_error),
            cell(&VOUCHED, torque_error),
        ];
        table.push(format!("| {} | {} |", drive.name, cells.join(" | ")));
    }
    table
}

/// The text with the tables that have one of the headings replaced.
fn renewed(text: &str, tables: &[Table]) -> String {
    let mut lines = text.lines().peekable();
    let mut out = Vec::new();
    while let Some(line) = lines.next() {
        match tables.iter().find(|table| table[0] == line) {
            None => out.push(line),
            Some(table) => {
                out.extend(table.iter().map(String::as_str));
                while lines.next_if(|line| line.starts_with('|')).is_some() {}
            }
        }
    }
    out.join("\n") + "\n"
}

fn main() -> std::io::Result<()> {
    let tables = [
        errors("paper's scenario", &scenarios::paper().drive(H)),
        errors("creep", &scenarios::creep().drive(H)),
        errors("random 2", &scenarios::random(2).drive(H)),
        drives(ERRORS[0].name, H, &ERRORS[..1]),
        slow(),
        noise(),
        carried(),
    ];
    let pages: Vec<_> = std::env::args_os().skip(1).collect();
    if pages.is_empty() {
        for table in &tables {
            println!("\n{}", table.join("\n"));
        }
    }
    for page in pages {
        let text = std::fs::read_to_string(&page)?;
        std::fs::write(page, renewed(&text, &tables))?;
    }
    Ok(())
}
