//! Friction over the position: learnt on a clutch that is worn where it closes, and what it buys after a reload.

use crate::bench::sensors::{noisy, perfect};
use crate::bench::{Drive, observe, scenarios};
use dct_driveline::observer::calibrating::Gains;
use dct_driveline::observer::friction_map::{corrected, positions};
use dct_driveline::observer::prior::Prior;
use dct_driveline::observer::{Estimate, Method, Sample, Selected, Settings};
use dct_driveline::{ForceMap, Params};

/// What is left of the normal force at a position [1]: a third is gone where the clutch touches, nothing at 9 mm.
fn left(theta: f64) -> f64 {
    1.0 - (9e-3 - theta).max(0.0) / 21e-3
}

fn worn(map: ForceMap) -> ForceMap {
    let mut force = map.force;
    for (force, theta) in force.iter_mut().zip(map.position) {
        *force *= left(theta);
    }
    ForceMap { force, ..map }
}

/// The paper's drive with worn clutches.
fn drive() -> Drive {
    let mut scenario = scenarios::paper();
    for clutch in &mut scenario.p.clutch {
        clutch.map = worn(clutch.map);
    }
    scenario.drive(1e-3)
}

/// RMSE of T_c1 [N·m] from 1 to 2.5 s, the slip of the launch, and the last estimate.
fn launch(
    method: Method,
    drive: &Drive,
    p: &Params,
    settings: &Settings,
    sensors: impl FnMut(Sample) -> Sample,
) -> (f64, Estimate) {
    let (mut square, mut count, mut last) = (0.0, 0.0, Estimate::default());
    let mut observer = Selected::new(method);
    observe(
        drive,
        &mut observer,
        p,
        settings,
        sensors,
        |moment, said| {
            if (1.0..2.5).contains(&moment.time) {
                square += (said.t_c[0] - moment.y.t_c[0]).powi(2);
                count += 1.0;
            }
            last = *said;
        },
    );
    ((square / count).sqrt(), last)
}

/// Settings of a second drive: what was learnt, friction as one number.
fn reloaded(learnt: &Estimate) -> Settings {
    Settings {
        mu_n: learnt.friction,
        calibrating: Gains {
            prior: Prior(learnt.calibration.value),
            sigma: learnt.calibration.deviation,
            friction: learnt.calibration.friction_deviation,
            ..Gains::DEFAULT
        },
        ..Settings::CASE_1
    }
}

/// The vehicle with the force-position maps that were learnt.
fn taught(learnt: &Estimate) -> Params {
    let mut p = Params::TABLE_1;
    for (i, clutch) in p.clutch.iter_mut().enumerate() {
        clutch.map = corrected(
            &clutch.map,
            learnt.calibration.friction[i],
            learnt.friction[i],
        );
    }
    p
}

/// Believed is 0.4 and 0.1 at every position; driven were 2 to 9 mm, without and with noise.
#[test]
fn friction_over_the_position_is_learnt_where_it_was_driven() {
    const KNOWN: f64 = 0.03;
    let (drive, p) = (drive(), Params::TABLE_1);
    for sigma in [0.0, 0.1] {
        let sensors = noisy(sigma, 1);
        let (_, said) = launch(Method::Calibrating, &drive, &p, &Settings::CASE_1, sensors);
        let mut known = 0;
        for (i, clutch) in p.clutch.iter().enumerate() {
            let learnt = said.calibration.friction[i].into_iter();
            let with = learnt.zip(said.calibration.friction_deviation[i]);
            for (theta, (mu, deviation)) in positions(&clutch.map).into_iter().zip(with) {
                let truth = clutch.mu_k * left(theta);
                let place = format!("clutch {} at {:.1} mm", i + 1, 1e3 * theta);
                println!("{place}: {mu:.3} ± {deviation:.3} of {truth:.3}");
                if deviation < KNOWN {
                    assert!((mu / truth - 1.0).abs() < 0.1, "{place}: {mu} of {truth}");
                    known += 1;
                }
            }
        }
        assert_eq!(known, 5, "noise {sigma}");
    }
}

/// The slip of the next launch. A number adds nothing to what `paper` and `lyapunov` find within their first slip, which
/// leaves them as little as it does: before μ̂ stayed in it they missed by 0.35 N·m when new.
#[test]
fn a_map_that_was_learnt_is_worth_more_than_a_number() {
    const FOUND: f64 = 0.12; // N·m
    let (drive, p) = (drive(), Params::TABLE_1);
    let (_, learnt) = launch(Method::Calibrating, &drive, &p, &Settings::CASE_1, perfect);
    let settings = reloaded(&learnt);
    for method in [Method::Paper, Method::Lyapunov, Method::Energy] {
        let (new, _) = launch(method, &drive, &p, &Settings::CASE_1, perfect);
        let (number, _) = launch(method, &drive, &p, &settings, perfect);
        let (map, _) = launch(method, &drive, &taught(&learnt), &settings, perfect);
        println!("{method:?}: new {new:.3}, number {number:.3}, map {map:.3} N·m");
        assert!(map < 0.75 * number && map < 0.6 * new, "{method:?}");
        let found = if method == Method::Energy {
            number
        } else {
            new
        };
        assert!(number < FOUND && found < FOUND, "{method:?}");
    }
}

/// The corrected map carries what the worn one does where it was driven; one number misses it by up to a sixth.
#[test]
fn the_corrected_map_is_the_worn_one() {
    const OFF: f64 = 0.04;
    let (drive, p) = (drive(), Params::TABLE_1);
    let (_, learnt) = launch(Method::Calibrating, &drive, &p, &Settings::CASE_1, perfect);
    let taught = taught(&learnt);
    let mut number = 0.0_f64;
    for (i, clutch) in taught.clutch.iter().enumerate() {
        let force = clutch.map.force;
        assert!(force[0] == 0.0 && force.windows(2).all(|two| two[0] <= two[1]));
        let from = [0, 1][i]; // clutch 2 slips alone from 5.6 mm on: at 4 mm nothing was learnt of it
        for theta in [4e-3, 5e-3, 6e-3, 7e-3, 8e-3].into_iter().skip(from) {
            let truth = drive.p.clutch[i].mu_k * drive.p.clutch[i].map.force(theta);
            let off = |map: &ForceMap| learnt.friction[i] * map.force(theta) / truth - 1.0;
            let (ours, before) = (off(&clutch.map), off(&p.clutch[i].map));
            println!(
                "clutch {} at {theta} m: {ours:.3}, number {before:.3}",
                i + 1
            );
            assert!(ours.abs() < OFF, "clutch {} at {theta} m: {ours}", i + 1);
            number = number.max(before.abs());
        }
    }
    assert!(number > 4.0 * OFF, "{number}");
}
