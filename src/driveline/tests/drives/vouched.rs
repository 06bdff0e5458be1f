//! The method `calibrating` where the road is vouched for, `load.method` = grade: what no speed tells in time (`twins.rs`), it does.

use crate::bench::sensors::{noisy, perfect, torque_deficit, torque_error, wheel_bias};
use crate::bench::{Drive, VOUCHED, calibrated, scenarios};
use crate::calibrating::{HIDDEN, LIMITS, NOISY, PARAMETERS, check_as, every_drive};
use dct_driveline::observer::{Sample, Settings};

const H: f64 = 1e-3;

/// T_e too high and too low, on every drive.
#[test]
fn an_error_of_torque_costs_little_on_every_drive() {
    for drive in every_drive() {
        for sensors in [perfect, torque_error, torque_deficit] {
            check_as(&VOUCHED, &drive, LIMITS, |_| {}, sensors);
        }
    }
}

/// Drives that begin with open clutches, all but two, are the same to the bit.
#[test]
fn a_road_is_believed_only_behind_an_engaged_clutch() {
    let differs = |drive: &Drive| {
        let [fresh, vouched] =
            [Settings::CASE_1, VOUCHED].map(|s| calibrated(drive, &s, torque_error).0);
        fresh != vouched
    };
    let names = every_drive().filter(differs).map(|drive| drive.name);
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert_eq!(names, HIDDEN);
}

/// Tip-in and kick-down.
fn hidden() -> impl Iterator<Item = Drive> {
    every_drive().filter(|drive| HIDDEN.contains(&drive.name.as_str()))
}

/// What is believed of the road turns no other error into one.
#[test]
fn no_other_error_costs_more_where_the_offset_was_hidden() {
    for drive in hidden() {
        check_as(&VOUCHED, &drive, LIMITS, |_| {}, wheel_bias);
        for believed in PARAMETERS {
            check_as(&VOUCHED, &drive, LIMITS, believed, perfect);
        }
        for seed in 1..=20 {
            check_as(&VOUCHED, &drive, NOISY, |_| {}, noisy(0.1, seed));
        }
    }
}

/// T_v of (11) is vouched for to a share: a vehicle that is believed 10 % too light or too heavy costs little; together with an
/// error of T_e, T_c2 and T_o are still better than without a road.
#[test]
fn a_wrong_mass_costs_little() {
    for mut drive in hidden() {
        let (fresh, _) = calibrated(&drive, &Settings::CASE_1, torque_error);
        let truth = drive.p.road.m_v;
        for share in [0.9, 1.1] {
            drive.p.road.m_v = share * truth;
            check_as(&VOUCHED, &drive, LIMITS, |_| {}, perfect);
            let (both, _) = calibrated(&drive, &VOUCHED, torque_error);
            println!("{} x {share}: {both:.2?} of {fresh:.2?} %", drive.name);
            assert!(
                both[1] < fresh[1] && both[2] < fresh[2],
                "{both:.2?} {fresh:.2?} %"
            );
        }
    }
}

/// The price, T_c2 and T_o [% of RMS]: what is told wrong of the road is taken for an offset of T_e, 3.8 N·m for each percent.
#[test]
fn a_road_that_is_told_wrong_is_taken_for_an_offset_of_torque() {
    const FRESH: f64 = 1.0;
    const PRICE: f64 = 10.0;
    let drive = scenarios::tip_in_tip_out().drive(H);
    let steeper: fn(Sample) -> Sample = |sample| Sample {
        phi: sample.phi + 0.03,
        ..sample
    };
    let [fresh, vouched] = [Settings::CASE_1, VOUCHED].map(|s| calibrated(&drive, &s, steeper).0);
    println!("{fresh:.2?} %, vouched for {vouched:.2?} %");
    for k in [1, 2] {
        assert!(
            fresh[k] < FRESH && vouched[k] > PRICE,
            "{fresh:.2?} {vouched:.2?} %"
        );
    }
}
