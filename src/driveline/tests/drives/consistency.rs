//! Filters that know how wrong they may be, and every method while the engine brakes.

use crate::bench::sensors::{encoder, noisy, perfect};
use crate::bench::{observe, scenarios};
use dct_driveline::observer::{Fault, Method, Observer, Sample, Selected, Settings};

const H: f64 = 1e-3;

/// Mean of the normalised innovation over a drive by chance, and the last fault told.
fn run(method: Method, sensors: impl FnMut(Sample) -> Sample) -> (f64, Option<Fault>) {
    let drive = scenarios::random(4).drive(H);
    let (mut sum, mut fault) = (0.0, None);
    let mut observer = Selected::new(method);
    observe(
        &drive,
        &mut observer,
        &drive.p,
        &Settings::CASE_1,
        sensors,
        |_, estimate| {
            sum += estimate.consistency;
            fault = estimate.fault.or(fault);
        },
    );
    (sum / drive.moments.len() as f64, fault)
}

/// Sensors as noisy as the filter believes (0.1 rad/s): innovation² is chi-square of mean 1. 120 000 of them
/// would be within 0.01 of 1; what is allowed beyond is that torques are no random walks.
#[test]
fn innovations_are_as_large_as_the_filters_expect() {
    const WITHIN: f64 = 0.1;
    for method in [Method::Kalman, Method::Calibrating] {
        let (mean, fault) = run(method, noisy(0.1, 1));
        println!("{method:?}: {mean:.3}");
        assert!((mean - 1.0).abs() < WITHIN, "{method:?}: {mean:.3}");
        assert_eq!(fault, None, "{method:?}");
    }
}

#[test]
fn sensors_far_noisier_than_believed_are_told() {
    for method in [Method::Kalman, Method::Calibrating] {
        let (mut count, mut bus) = (encoder(1024.0, H), noisy(1e-3, 1));
        let counted = |sample| bus(count(sample)); // no longer whole ticks, which would be recognised
        for (_, fault) in [run(method, noisy(1.0, 1)), run(method, counted)] {
            assert_eq!(fault, Some(Fault::Inconsistent), "{method:?}");
        }
    }
}

/// T_e falls to −50 N·m in first gear and comes back: the torque of clutch 1 is negative while the true one
/// clearly is, and no more than 2 N·m off over the whole of it.
#[test]
fn every_method_has_sign_and_size_of_engine_braking() {
    const RMS: f64 = 2.0;
    const CLEARLY: f64 = -2.0;
    /// Engine braking of the paper's scenario [s].
    const FROM: f64 = 21.8;
    const TO: f64 = 24.2;
    let drive = scenarios::paper().drive(H);
    for method in Method::ALL {
        let mut observer = Selected::new(method);
        let (mut square, mut count) = (0.0, 0.0);
        observe(
            &drive,
            &mut observer,
            &drive.p,
            &Settings::CASE_1,
            perfect,
            |moment, estimate| {
                if moment.time > FROM && moment.time < TO {
                    let [ours, truth, time] = [estimate.t_c[0], moment.y.t_c[0], moment.time];
                    let right = ours < 0.0 || truth > CLEARLY;
                    assert!(
                        right,
                        "{method:?}: {ours:.1} of {truth:.1} N·m at {time:.3} s"
                    );
                    square += (ours - truth).powi(2);
                    count += 1.0;
                }
            },
        );
        let rms = f64::sqrt(square / count);
        println!("{method:?}: {rms:.2} N·m");
        assert!(rms <= RMS, "{method:?}: {rms:.2} N·m RMS");
    }
}

/// Steps reckoned as differences of times are 10 ms but for their last bits; no decision depends on these. The times
/// that a lock or a learnt friction takes are whole numbers of such steps: one step more for them was up to 16 N·m.
#[test]
fn estimates_do_not_depend_on_the_last_bit_of_a_step() {
    const STEP: f64 = 1e-2;
    let drive = scenarios::paper().drive(STEP);
    for method in Method::ALL {
        let [mut ours, mut theirs] = [Selected::new(method), Selected::new(method)];
        let (p, settings) = (&drive.p, Settings::CASE_1);
        ours.start(p, &settings, &drive.start);
        theirs.start(p, &settings, &drive.start);
        let mut last = 0.0;
        for (k, moment) in drive.moments.iter().enumerate() {
            let time = (k + 1) as f64 * STEP;
            let one = ours.step(p, &settings, &moment.sample, STEP);
            let other = theirs.step(p, &settings, &moment.sample, time - last);
            last = time;
            let apart = (one.t_o - other.t_o).abs();
            assert!(apart < 1e-5, "{method:?} t = {time:.2} s: {apart:e} N·m");
        }
    }
}
