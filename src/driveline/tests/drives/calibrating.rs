//! The method `calibrating` under errors of its own parameters and sensors, on scenarios no gain was tuned on.

use crate::bench::sensors::{noisy, perfect, torque_error, torque_offset, wheel_bias};
use crate::bench::{Drive, after, calibrated, faded, observe, scenarios, wet};
use dct_driveline::Params;
use dct_driveline::observer::{Calibration, Estimate, Method, Sample, Selected, Settings};

const H: f64 = 1e-3;
/// Largest RMSE of T_c1/T_c2/T_o under each error [% of RMS], and with speed noise.
pub const LIMITS: [f64; 3] = [4.0, 4.0, 2.0];
pub const NOISY: [f64; 3] = [5.5, 5.5, 2.5];

/// Runs along a drive with parameters that are believed to be others than the true ones.
fn run(
    method: Method,
    drive: &Drive,
    believed: fn(&mut Params),
    sensors: impl FnMut(Sample) -> Sample,
) -> ([f64; 3], Calibration) {
    run_as(&Settings::CASE_1, method, drive, believed, sensors)
}

/// The same with other settings.
fn run_as(
    settings: &Settings,
    method: Method,
    drive: &Drive,
    believed: fn(&mut Params),
    sensors: impl FnMut(Sample) -> Sample,
) -> ([f64; 3], Calibration) {
    let mut p = drive.p;
    believed(&mut p);
    let mut last = Calibration::default();
    let mut observer = Selected::new(method);
    let score = observe(
        drive,
        &mut observer,
        &p,
        settings,
        sensors,
        |_, estimate| {
            last = estimate.calibration;
        },
    );
    (score.percent(), last)
}

fn check(
    drive: &Drive,
    limits: [f64; 3],
    believed: fn(&mut Params),
    sensors: impl FnMut(Sample) -> Sample,
) {
    check_as(&Settings::CASE_1, drive, limits, believed, sensors);
}

/// The same with other settings.
pub fn check_as(
    settings: &Settings,
    drive: &Drive,
    limits: [f64; 3],
    believed: fn(&mut Params),
    sensors: impl FnMut(Sample) -> Sample,
) {
    let (errors, learnt) = run_as(settings, Method::Calibrating, drive, believed, sensors);
    let name = &drive.name;
    println!("{name}: {errors:.1?} % {learnt:.3?}");
    let within = errors
        .iter()
        .zip(limits)
        .all(|(error, limit)| *error <= limit);
    assert!(within, "{name}: {errors:.2?} > {limits:?} %, {learnt:.3?}");
}

/// Every error of a parameter that a driveline may have, by itself.
pub const PARAMETERS: [fn(&mut Params); 10] = [
    |p| p.j_e *= 1.2,
    |p| p.j_e *= 0.8,
    |p| p.j_v *= 1.2,
    |p| p.j_v *= 0.8,
    |p| p.k_o *= 1.1,
    |p| p.k_o *= 0.9,
    |p| p.c_o *= 1.2,
    |p| p.c_o *= 0.8,
    |p| p.j_ct = p.j_ct.map(|j| 1.2 * j),
    |p| p.j_ct = p.j_ct.map(|j| 0.8 * j),
];

/// Under an error of T_e in the paper's scenario.
const TORQUE: [f64; 3] = [1.1, 1.0, 0.7];
/// Under the same error on wet6: T_o 2.4 % while quiet speeds were taken for noisy ones.
const WET: [f64; 3] = [1.6, 0.8, 1.5];
/// With noise and J_e, J_v, k_o wrong by one share.
const ALIKE: [f64; 3] = [5.0, 3.0, 4.5];

#[test]
fn an_error_of_torque_costs_what_the_launch_needs_to_show_it() {
    check(&scenarios::paper().drive(H), TORQUE, |_| {}, torque_error);
    check(&wet::wet_6().drive(H), WET, |_| {}, torque_error);
}

/// What an engine torque that is 15 % too low looks like, to three of five witnesses; the deviation of α says so.
#[test]
fn three_parameters_wrong_by_one_share_do_not_pass_for_the_torque() {
    let drive = scenarios::paper().drive(H);
    let believed: fn(&mut Params) = |p| {
        p.j_e *= 1.18;
        p.j_v *= 1.18;
        p.k_o *= 1.18;
    };
    for seed in 1..=10 {
        let (errors, learnt) = run(Method::Calibrating, &drive, believed, noisy(0.04, seed));
        let (alpha, deviation) = (learnt.value[0], learnt.deviation[0]);
        println!("{seed}: {errors:.1?} %, {alpha:.3} ± {deviation:.3}");
        let within = (0..3).all(|k| errors[k] <= ALIKE[k]);
        assert!(
            within && alpha.abs() < 2.0 * deviation,
            "{seed}: {errors:.2?} %, {learnt:.3?}"
        );
    }
}

/// Every drive there is.
pub fn every_drive() -> impl Iterator<Item = Drive> {
    let all = scenarios::every().into_iter();
    all.map(|scenario| scenario.drive(H))
}

/// Where an engaged clutch hides the offset of T_e for too long, whatever the method (`twins.rs`), unless the road is told
/// (`vouched.rs`).
pub const HIDDEN: [&str; 2] = ["kick-down", "tip-in, tip-out"];

#[test]
fn errors_of_torque_and_wheel_speed_cost_little_on_every_drive() {
    for drive in every_drive() {
        check(&drive, LIMITS, |_| {}, perfect);
        check(&drive, LIMITS, |_| {}, wheel_bias);
        if !HIDDEN.contains(&drive.name.as_str()) {
            check(&drive, LIMITS, |_| {}, torque_error);
        }
    }
}

/// The box of wet6 rolls with dry friction. To a wheel speed that is biased, or believed to a few 0.01 rad/s, a wheel at
/// rest already turns: the whole rolling resistance was taken for a grade of the other sign, T_o 2.4 % under an error of T_e.
#[test]
fn a_wheel_that_stands_tells_no_grade() {
    let drive = wet::wet_6().drive(H);
    check(&drive, [1.7, 1.2, 1.6], |_| {}, torque_error);
    check(&drive, [1.0, 0.9, 0.6], |_| {}, wheel_bias);
}

#[test]
fn errors_of_parameters_cost_nothing_on_every_drive() {
    for drive in every_drive() {
        for believed in PARAMETERS {
            check(&drive, LIMITS, believed, perfect);
        }
    }
}

#[test]
fn noise_costs_little() {
    for scenario in [
        scenarios::paper(),
        scenarios::random(1),
        scenarios::random(3),
    ] {
        let drive = scenario.drive(H);
        for seed in [1, 2, 3] {
            check(&drive, NOISY, |_| {}, noisy(0.1, seed));
        }
    }
}

/// Of 20 seeds each: creep and kick-down had 3.0 and 3.2 % at most, the paper's scenario 4.3, while T_v was believed to
/// walk at one pace everywhere.
#[test]
fn noise_costs_little_of_the_drive_shaft_whatever_its_seed() {
    for (scenario, middle) in [
        (scenarios::creep(), 1.5),
        (scenarios::kick_down(), 2.0),
        (scenarios::paper(), 1.4),
        (scenarios::random(4), 1.5),
    ] {
        let drive = scenario.drive(H);
        let mut t_o: Vec<f64> = (1..=20)
            .map(|seed| run(Method::Calibrating, &drive, |_| {}, noisy(0.1, seed)).0[2])
            .collect();
        t_o.sort_by(f64::total_cmp);
        println!("{}: {t_o:.2?} %", drive.name);
        assert!(
            t_o[10] < middle && t_o[19] < NOISY[2],
            "{}: {t_o:.2?} %",
            drive.name
        );
    }
}

/// Seeds of 21-400 that missed a goal while T_v walked by 50 (N·m)²/s at least: T_o by 2.93 % at most, T_c2 by 5.9.
#[test]
fn noise_that_once_missed_a_goal_does_not() {
    for (scenario, seeds) in [
        (
            scenarios::kick_down(),
            &[28, 95, 104, 111, 246, 329, 376][..],
        ),
        (scenarios::paper(), &[216]),
    ] {
        let drive = scenario.drive(H);
        for seed in seeds {
            check(&drive, NOISY, |_| {}, noisy(0.1, *seed));
        }
    }
}

/// In dry7 J_d is a quarter of J_ed. Taken for an acceleration of both, its swing behind the damper was learnt as wrong
/// inertias: T_o 0.7 %, and with noise 3.7 % at most of these seeds.
#[test]
fn a_swing_of_the_damper_is_no_error_of_an_inertia() {
    let drive = faded::dry_7().drive(H);
    check(&drive, [1.4, 2.2, 0.5], |_| {}, perfect);
    for seed in 21..=60 {
        check(&drive, [2.6, 3.2, 1.7], |_| {}, noisy(0.1, seed));
    }
}

#[test]
fn an_error_of_inertia_costs_nothing_at_100_hz() {
    let drive = scenarios::paper().drive(1e-2);
    for believed in [PARAMETERS[0], PARAMETERS[1]] {
        check(&drive, LIMITS, believed, perfect);
    }
}

/// What was injected is found, and the deviations told have shrunk.
#[test]
fn injected_errors_are_found() {
    let drive = scenarios::paper().drive(H);
    let j_ed = |p: &Params| p.j_ed();
    let believed = Params {
        j_e: 1.2 * drive.p.j_e,
        ..drive.p
    };
    let (_, inertia) = run(Method::Calibrating, &drive, PARAMETERS[0], perfect);
    let expected = j_ed(&drive.p) / j_ed(&believed) - 1.0;
    assert!((inertia.value[2] - expected).abs() < 0.01, "{inertia:?}");
    let (_, torque) = run(Method::Calibrating, &drive, |_| {}, torque_error);
    let (alpha, deviation) = (torque.value[0], torque.deviation[0]);
    let wrong = (alpha - (1.0 / 1.05 - 1.0)).abs();
    assert!(
        wrong < 0.004 && wrong < deviation && deviation < 0.01,
        "{torque:?}"
    );
    assert!((torque.value[1] + 2.0 / 1.05).abs() < 0.05, "{torque:?}");
    let (_, wheel) = run(Method::Calibrating, &drive, |_| {}, wheel_bias);
    assert!((wheel.value[3] - 0.01).abs() < 5e-4, "{wheel:?}");
    let sigma = Settings::CASE_1.calibrating.sigma;
    for (k, start) in sigma.into_iter().enumerate() {
        assert!(
            wheel.deviation[k] < 0.5 * start || start == 0.0,
            "{k} {wheel:?}"
        );
    }
}

/// The reason for this method: what the same error costs a filter that does not learn.
#[test]
fn a_filter_that_does_not_learn_pays_five_times_as_much() {
    let drive = scenarios::paper().drive(H);
    let (plain, _) = run(Method::Kalman, &drive, PARAMETERS[0], perfect);
    let (learning, _) = run(Method::Calibrating, &drive, PARAMETERS[0], perfect);
    println!("kalman {plain:.1?} %, calibrating {learning:.1?} %");
    assert!(
        (0..3).all(|i| learning[i] < 0.2 * plain[i]),
        "{plain:?} {learning:?}"
    );
}

/// RMSE of T_o [N·m] over the first launch, and what was learnt at the end.
fn launch(drive: &Drive, settings: &Settings) -> (f64, Estimate) {
    const LAUNCH: f64 = 4.0;
    let p = Params {
        j_e: 1.2 * drive.p.j_e,
        k_o: 0.9 * drive.p.k_o,
        ..drive.p
    };
    let (mut square, mut last) = (0.0, Estimate::default());
    let mut observer = Selected::new(Method::Calibrating);
    observe(
        drive,
        &mut observer,
        &p,
        settings,
        torque_error,
        |moment, estimate| {
            if moment.time < LAUNCH {
                square += (estimate.t_o - moment.y.t_o).powi(2) * drive.h / LAUNCH;
            }
            last = *estimate;
        },
    );
    (square.sqrt(), last)
}

/// Errors of T_e, J_e and k_o at once; the second drive starts where the first one ended.
#[test]
fn a_second_drive_starts_with_what_the_first_has_learnt() {
    let drive = scenarios::paper().drive(H);
    let (first, learnt) = launch(&drive, &Settings::CASE_1);
    let (second, _) = launch(&drive, &after(&learnt));
    println!("first launch {first:.1} N·m, second drive {second:.1} N·m");
    assert!(second < 0.3 * first, "{first:.1} {second:.1} N·m");
}

/// Drives that begin with a clutch engaged show nothing of β (`observer/calibrating_model.rs`), so an error of T_e costs what
/// its offset does alone, 4 % of T_c2 in tip-in; a calibration from a drive with an idle phase has it.
#[test]
fn what_an_engaged_clutch_hides_is_known_from_a_drive_before() {
    let fresh = Settings::CASE_1;
    let (_, learnt) = calibrated(&scenarios::paper().drive(H), &fresh, torque_error);
    for scenario in [scenarios::tip_in_tip_out(), scenarios::kick_down()] {
        let drive = scenario.drive(H);
        let [(alone, _), (offset, _), (carried, _)] = [
            calibrated(&drive, &fresh, torque_error),
            calibrated(&drive, &fresh, torque_offset),
            calibrated(&drive, &after(&learnt), torque_error),
        ];
        println!("{}: {alone:.1?}, {offset:.1?}, {carried:.1?} %", drive.name);
        let within = (0..3).all(|k| carried[k] <= LIMITS[k]);
        assert!(within, "{}: {carried:.2?} %", drive.name);
        assert!(offset[1] > 0.6 * alone[1], "{offset:.2?} {alone:.2?} %");
    }
}

/// A vehicle that is 20 % heavier or lighter than believed, on roads whose grade is not told.
#[test]
fn the_mass_of_the_vehicle_is_found_while_driving() {
    const WITHIN: f64 = 0.02;
    for scenario in [
        scenarios::paper(),
        scenarios::aborted_launch(),
        scenarios::random(4),
        scenarios::random(8),
    ] {
        let drive = scenario.drive(H);
        for heavier in [0.8, 1.0, 1.2] {
            let mut p = drive.p;
            let wheel = p.road.r_w * p.road.r_w;
            let wrong = p.road.m_v * (1.0 / heavier - 1.0);
            p.road.m_v += wrong;
            p.j_v += wrong * wheel;
            let mut last = Calibration::default();
            let mut observer = Selected::new(Method::Calibrating);
            observe(
                &drive,
                &mut observer,
                &p,
                &Settings::CASE_1,
                noisy(0.1, 1),
                |_, estimate| last = estimate.calibration,
            );
            let [mass, deviation] = last.mass;
            let (truth, name) = (drive.p.road.m_v, &drive.name);
            println!("{name} x {heavier}: {mass:.0} ± {deviation:.0} of {truth:.0} kg");
            assert!(
                (mass / truth - 1.0).abs() < WITHIN,
                "{name} x {heavier}: {mass:.0} kg"
            );
        }
    }
}
