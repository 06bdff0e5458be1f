//! The method `calibrating` under errors of its own parameters and sensors, on scenarios no gain was tuned on.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    dead_code,
    reason = "helpers of tests"
)]

mod bench;

use bench::sensors::{noisy, perfect, torque_error, wheel_bias};
use bench::{Drive, observe, scenarios};
use dct_driveline::Params;
use dct_driveline::observer::{Calibration, Method, Sample, Selected, Settings};

const H: f64 = 1e-3;
/// Largest RMSE of T_c1/T_c2/T_o under each error [% of RMS], and with speed noise.
const LIMITS: [f64; 3] = [4.0, 4.0, 2.0];
const NOISY: [f64; 3] = [5.5, 5.5, 2.5];

/// Runs along a drive with an engine inertia that is believed to be `j_e` times the true one.
fn run(
    method: Method,
    drive: &Drive,
    j_e: f64,
    sensors: impl FnMut(Sample) -> Sample,
) -> ([f64; 3], Calibration) {
    let p = Params {
        j_e: drive.p.j_e * j_e,
        ..drive.p
    };
    let mut last = Calibration::default();
    let mut observer = Selected::new(method);
    let settings = Settings::CASE_1;
    let score = observe(
        drive,
        &mut observer,
        &p,
        &settings,
        sensors,
        |_, estimate| {
            last = estimate.calibration;
        },
    );
    (score.percent(), last)
}

fn check(drive: &Drive, limits: [f64; 3], j_e: f64, sensors: impl FnMut(Sample) -> Sample) {
    let (errors, learnt) = run(Method::Calibrating, drive, j_e, sensors);
    println!("{} J_e x {j_e}: {errors:.1?} % {learnt:.3?}", drive.name);
    let within = errors
        .iter()
        .zip(limits)
        .all(|(error, limit)| *error <= limit);
    assert!(
        within,
        "{} J_e x {j_e}: {errors:.2?} > {limits:?} %",
        drive.name
    );
}

#[test]
fn errors_of_inertia_torque_and_wheel_speed_cost_nothing() {
    for scenario in [scenarios::paper(), scenarios::creep(), scenarios::random(2)] {
        let drive = scenario.drive(H);
        for j_e in [1.0, 1.2, 0.8] {
            check(&drive, LIMITS, j_e, perfect);
        }
        check(&drive, LIMITS, 1.0, torque_error);
        check(&drive, LIMITS, 1.0, wheel_bias);
    }
}

/// On scenarios in which engine and shaft are excited; the paper's, with its long steady drives, misses
/// this limit in T_c1 with some seeds.
#[test]
fn noise_costs_little() {
    for scenario in [1, 3].map(scenarios::random) {
        check(&scenario.drive(H), NOISY, 1.0, noisy(0.1, 1));
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
    let (_, inertia) = run(Method::Calibrating, &drive, 1.2, perfect);
    let expected = j_ed(&drive.p) / j_ed(&believed) - 1.0;
    assert!((inertia.value[2] - expected).abs() < 0.01, "{inertia:?}");
    let (_, torque) = run(Method::Calibrating, &drive, 1.0, torque_error);
    assert!(
        (torque.value[0] - (1.0 / 1.05 - 1.0)).abs() < 0.005,
        "{torque:?}"
    );
    assert!((torque.value[1] + 2.0 / 1.05).abs() < 0.05, "{torque:?}");
    let (_, wheel) = run(Method::Calibrating, &drive, 1.0, wheel_bias);
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
    let (plain, _) = run(Method::Kalman, &drive, 1.2, perfect);
    let (learning, _) = run(Method::Calibrating, &drive, 1.2, perfect);
    println!("kalman {plain:.1?} %, calibrating {learning:.1?} %");
    assert!(
        (0..3).all(|i| learning[i] < 0.2 * plain[i]),
        "{plain:?} {learning:?}"
    );
}
