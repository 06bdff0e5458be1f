//! What each phase of a drive shows of each parameter: the deviation that `calibrating` leaves of the one before.
//!
//! The covariance of the filter is the inverse of its observability Gramian, forgetting what walks away: a
//! factor of 1 says that the phase shows nothing, 0.1 that it shows a hundred times what was known.

use crate::bench::scenarios;
use dct_driveline::observer::calibrating::Gains;
use dct_driveline::observer::{Calibrating, Observer, Settings};

const H: f64 = 1e-3;
const NAMES: [&str; 7] = ["β", "δ", "w", "κ", "γ", "λ", "ν"];
/// Index of β among the states; the others follow.
const BETA: usize = 7;
/// A phase tells a parameter where less than this is left of its deviation, and nothing where more than that.
const TELLS: f64 = 0.75;
const NOTHING: f64 = 0.9;

/// Pages with the table in them: the method's own, and the one for who uses it.
const PAGES: [&str; 2] = [
    include_str!("../../observer/calibrating.rs"),
    include_str!("../../../../PAPER.md"),
];
/// Half a unit of the last digit printed, and a little for the rounding of another machine.
const PRINTED: f64 = 0.006;

/// Name, start and end [s] of phases of the paper's scenario.
const PHASES: [(&str, f64, f64); 6] = [
    ("clutches open, idle", 0.01, 0.95),
    ("clutch 1 slips: launch", 1.0, 2.45),
    ("clutch 1 engages, the shaft swings", 2.5, 3.3),
    ("clutch 1 engaged: steady drive", 5.0, 8.0),
    ("handover", 8.6, 9.6),
    ("clutch 1 engaged: tip-in", 24.2, 25.0),
];

/// Deviations of all seven parameters at a time: with nothing learnt before `from`, as in the first phase.
fn left(from: f64, to: f64) -> [f64; 7] {
    let drive = scenarios::paper().drive(H);
    let mut observer = Calibrating::default();
    let settings = Settings {
        calibrating: Gains {
            walk: [0.0; 7],
            ..Gains::DEFAULT
        },
        ..Settings::CASE_1
    };
    let deviations = |observer: &Calibrating| {
        let p = &observer.tracker.belief.p;
        [0, 1, 2, 3, 4, 5, 6].map(|k| p[(BETA + k, BETA + k)].sqrt())
    };
    observer.start(&drive.p, &settings, &drive.start);
    let start = deviations(&observer);
    let whole = observer.tracker.belief.p;
    let mut before = None;
    for moment in drive.moments.iter().take_while(|m| m.time <= to) {
        if before.is_none() && moment.time >= from {
            forget(&mut observer, &whole);
            before = Some(start);
        }
        observer.step(&drive.p, &settings, &moment.sample, drive.h);
    }
    let (before, after) = (before.unwrap(), deviations(&observer));
    [0, 1, 2, 3, 4, 5, 6].map(|k| after[k] / before[k])
}

/// As uncertain of the parameters as at the start; speeds and torques are known.
fn forget(observer: &mut Calibrating, start: &nalgebra::SMatrix<f64, 15, 15>) {
    let p = &mut observer.tracker.belief.p;
    for j in (0..NAMES.len()).map(|k| BETA + k) {
        for k in 0..p.ncols() {
            p[(j, k)] = start[(j, k)];
            p[(k, j)] = start[(k, j)];
        }
    }
}

/// The seven numbers in a page's row of a phase.
fn printed(page: &str, phase: &str) -> Option<[f64; 7]> {
    let mut rows = page
        .lines()
        .map(|line| line.trim_start_matches(['/', '!', '|', ' ']));
    rows.find_map(|row| {
        let numbers = row.strip_prefix(phase)?.split([' ', '|']);
        let numbers: Vec<f64> = numbers.filter_map(|word| word.parse().ok()).collect();
        numbers.last_chunk().copied()
    })
}

#[test]
fn pages_print_what_each_phase_tells() {
    for (name, from, to) in PHASES {
        let computed = left(from, to);
        for page in PAGES {
            let printed = printed(page, name).unwrap();
            let apart = |k: usize| (printed[k] - computed[k]).abs();
            assert!((0..7).all(|k| apart(k) < PRINTED), "{name}: {computed:.2?}");
        }
    }
}

#[test]
fn each_phase_tells_what_the_method_says_it_tells() {
    println!("| phase | {} |", NAMES.join(" | "));
    let left = PHASES.map(|(name, from, to)| {
        let left = left(from, to);
        println!(
            "| {name} | {} |",
            left.map(|x| format!("{x:.2}")).join(" | ")
        );
        left
    });
    let tells = |phase: usize, named: &str| {
        for (k, name) in NAMES.iter().enumerate() {
            let (x, phase) = (left[phase][k], PHASES[phase].0);
            if named.contains(name) {
                assert!(x < TELLS, "{phase}: {name} {x:.2}");
            }
        }
    };
    let hides = |phase: usize, named: &str| {
        for (k, name) in NAMES.iter().enumerate() {
            let (x, phase) = (left[phase][k], PHASES[phase].0);
            if named.contains(name) {
                assert!(x > NOTHING, "{phase}: {name} {x:.2}");
            }
        }
    };
    tells(0, "βw");
    hides(0, "κγλν");
    tells(1, "δκν");
    tells(2, "βδκγλν");
    tells(3, "w");
    hides(3, "βκγ");
    tells(4, "βδν");
    tells(5, "δκγν");
}
