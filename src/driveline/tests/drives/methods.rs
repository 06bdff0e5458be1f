//! Every method on the exact plant: accuracy on the paper's scenario, and on scenarios no gain was tuned on.

use crate::bench::sensors::{delayed, dropping, noisy, perfect};
use crate::bench::{Drive, Score, faded, observe, scenarios, wet};
use dct_driveline::observer::{Fault, Method, Observer, Sample, Selected, Settings};

/// Speed noise of the accuracy limits [rad/s].
const NOISE: f64 = 0.1;

/// Runs a method along a drive with true parameters; nothing may leave the realm of numbers.
fn run(method: Method, drive: &Drive, sensors: impl FnMut(Sample) -> Sample) -> Score {
    let mut observer = Selected::new(method);
    let settings = Settings::CASE_1;
    observe(
        drive,
        &mut observer,
        &drive.p,
        &settings,
        sensors,
        |moment, estimate| {
            let torques = [estimate.t_c[0], estimate.t_c[1], estimate.t_o];
            let finite = torques.iter().all(|torque| torque.is_finite());
            assert!(finite, "{method:?} {} t = {} s", drive.name, moment.time);
        },
    )
}

/// Checks the RMSE of a method on a drive [% of RMS], T_c1/T_c2/T_o.
fn check(method: Method, drive: &Drive, sigma: f64, limits: [f64; 3]) {
    let errors = run(method, drive, noisy(sigma, 1)).percent();
    let (h, name) = (drive.h, &drive.name);
    println!("{method:?} {name} h = {h} s, noise {sigma}: {errors:.1?} of {limits:?} %");
    let within = errors
        .iter()
        .zip(limits)
        .all(|(error, limit)| *error <= limit);
    assert!(
        within,
        "{method:?} {name} h = {h} s, noise {sigma}: {errors:.1?} > {limits:?} %"
    );
}

#[test]
fn methods_are_within_their_limits_on_the_paper_scenario_at_1_khz() {
    let drive = scenarios::paper().drive(1e-3);
    check(Method::Paper, &drive, 0.0, [2.9, 3.8, 1.3]);
    check(Method::Lyapunov, &drive, 0.0, [2.7, 3.8, 1.2]);
    check(Method::Energy, &drive, 0.0, [1.5, 2.0, 1.0]);
    check(Method::Energy, &drive, NOISE, [3.3, 3.5, 3.0]);
    check(Method::Kalman, &drive, 0.0, [1.4, 1.5, 0.9]);
    check(Method::Kalman, &drive, NOISE, [3.0, 3.2, 1.1]);
    check(Method::Calibrating, &drive, 0.0, [0.9, 0.9, 0.4]);
}

#[test]
fn methods_are_within_their_limits_on_the_paper_scenario_at_100_hz() {
    let drive = scenarios::paper().drive(1e-2);
    check(Method::Paper, &drive, 0.0, [3.5, 4.3, 1.5]);
    check(Method::Lyapunov, &drive, 0.0, [3.4, 4.1, 1.5]);
    check(Method::Energy, &drive, 0.0, [1.5, 3.0, 1.0]);
    check(Method::Kalman, &drive, 0.0, [2.0, 2.2, 1.7]);
}

/// T_v was short by a twentieth of the accelerating torque while E was taken as held over a step: T_o of these seeds
/// missed by 4.6 to 5.9 %, that of energy by 1.7 to 2.0 %. Taken as held over a step at what it is at its end, the torque
/// of an engaged clutch, which swings with the damper, took T_c1 of paper and lyapunov to 3.6 to 4.5 %.
#[test]
fn methods_are_within_their_limits_on_drives_by_chance_at_100_hz() {
    for seed in [2, 3, 9] {
        let drive = scenarios::random(seed).drive(1e-2);
        check(Method::Paper, &drive, 0.0, [3.0, 2.8, 3.6]);
        check(Method::Lyapunov, &drive, 0.0, [2.8, 2.7, 3.4]);
        check(Method::Energy, &drive, 0.0, [2.0, 2.0, 1.5]);
    }
}

/// Shifts under power: in a handover only the engaged clutch adapts, after it the damper swings by more than the
/// slip of an engaged clutch, and the clutch is pressed home while its torque stays.
#[test]
fn methods_are_within_their_limits_on_drives_by_chance() {
    for seed in [1, 2, 3, 5] {
        let drive = scenarios::random(seed).drive(1e-3);
        check(Method::Paper, &drive, 0.0, [1.8, 3.0, 2.7]);
        check(Method::Lyapunov, &drive, 0.0, [1.6, 3.2, 3.0]);
        check(Method::Energy, &drive, 0.0, [1.7, 2.0, 2.3]);
        check(Method::Energy, &drive, NOISE, [2.3, 2.3, 3.5]);
        check(Method::Kalman, &drive, 0.0, [1.1, 1.4, 0.6]);
        check(Method::Kalman, &drive, NOISE, [2.2, 2.6, 1.2]);
        check(Method::Calibrating, &drive, 0.0, [0.6, 1.0, 0.4]);
        check(Method::Calibrating, &drive, NOISE, [2.3, 2.6, 2.0]);
    }
}

/// The wheel stands, and the brake carries what drive shaft and grade leave: no load, and no acceleration.
#[test]
fn torques_are_followed_against_a_brake_that_holds_the_wheel() {
    let drive = scenarios::hill_hold().drive(1e-3);
    for (method, clean, noisy) in [
        (Method::Paper, [0.7, 0.0, 1.1], [4.5, 0.0, 3.5]),
        (Method::Lyapunov, [0.7, 0.0, 0.8], [6.5, 0.0, 2.5]),
        (Method::Energy, [0.6, 0.0, 1.0], [1.5, 0.0, 2.2]),
        (Method::Kalman, [0.8, 0.0, 0.5], [2.5, 0.0, 1.0]),
        (Method::Calibrating, [0.4, 0.0, 0.5], [1.6, 0.0, 1.2]),
    ] {
        check(method, &drive, 0.0, clean);
        check(method, &drive, NOISE, noisy);
    }
}

/// Friction that falls with slip and heat, and a box with a tenth of the inertia, whose gains are those of Table 1.
#[test]
fn methods_hold_on_a_fading_friction_and_on_another_box() {
    let fading = faded::fading().drive(1e-3);
    let dry_7 = faded::dry_7().drive(1e-3);
    check(Method::Paper, &fading, 0.0, [4.5, 5.0, 2.0]);
    check(Method::Energy, &fading, 0.0, [2.0, 3.0, 1.5]);
    check(Method::Paper, &dry_7, 0.0, [6.3, 10.6, 2.6]);
    check(Method::Lyapunov, &dry_7, 0.0, [6.3, 9.6, 2.4]);
    check(Method::Energy, &dry_7, 0.0, [2.0, 3.0, 1.5]);
    let slow = faded::dry_7().drive(1e-2);
    check(Method::Paper, &slow, 0.0, [6.5, 12.7, 4.8]);
    check(Method::Lyapunov, &slow, 0.0, [6.5, 10.6, 3.7]);
    check(Method::Energy, &slow, 0.0, [4.0, 4.0, 2.0]);
    for method in [Method::Kalman, Method::Calibrating] {
        check(method, &fading, 0.0, [1.4, 1.7, 0.8]);
        check(method, &dry_7, 0.0, [1.7, 2.4, 1.0]);
    }
}

/// A box whose clutches are moved by pressure, through three gears; nothing was tuned on it.
///
/// The goals are 12/15/3.5 and 14/15/5 % (`paper`), 6.5/6.5/3 and 7/8/4 (`energy`), 3/3/1.5 and 4/4/2 (`kalman`),
/// 4/4/2 (`calibrating`); `lyapunov` has none.
#[test]
fn pressures_are_followed_through_three_gears() {
    let limits = [
        (Method::Paper, [5.0, 7.4, 3.0], [5.0, 8.2, 4.3]),
        (Method::Lyapunov, [5.2, 6.8, 2.7], [5.6, 7.5, 3.8]),
        (Method::Energy, [6.5, 6.5, 3.0], [7.0, 8.0, 4.0]),
        (Method::Kalman, [3.0, 3.0, 1.5], [4.0, 4.0, 2.0]),
        (Method::Calibrating, [1.0, 0.9, 0.6], [1.6, 0.9, 1.0]),
    ];
    for h in [1e-3, 1e-2] {
        let drive = wet::wet_6().drive(h);
        for (method, at_1_khz, at_100_hz) in limits {
            let limits = if h < 5e-3 { at_1_khz } else { at_100_hz };
            check(method, &drive, 0.0, limits);
        }
    }
    let drive = wet::wet_6().drive(1e-3);
    check(Method::Energy, &drive, NOISE, [7.0, 7.0, 4.0]);
    check(Method::Calibrating, &drive, NOISE, [1.7, 1.6, 0.8]);
}

/// Friction over slip and temperature as the presets have them, which no observer knows; nothing was tuned on them.
///
/// At 100 Hz clutch 2 of dry7_fade locks at 190 N·m and its measured slip goes from 1 to −4.7 rad/s, by the swing of the
/// damper, from one sample to the next: taken as a slip the other way, it took T_c2 of `energy` to 19 %.
#[test]
fn linings_that_follow_slip_and_heat_are_followed() {
    let limits = [
        ([5.6, 9.0, 3.5], [6.0, 11.0, 5.0]),
        ([5.6, 8.6, 2.8], [5.9, 9.4, 4.2]),
        ([2.0, 3.0, 1.5], [5.0, 5.0, 2.3]),
        ([1.5, 2.1, 0.5], [2.0, 2.2, 1.0]),
        ([1.5, 2.1, 0.8], [2.5, 3.3, 1.3]),
    ];
    for h in [1e-3, 1e-2] {
        for scenario in [wet::wet_6_fade(), faded::dry_7_fade(), faded::dry_7_hot()] {
            let drive = scenario.drive(h);
            for (method, (at_1_khz, at_100_hz)) in Method::ALL.into_iter().zip(limits) {
                let limits = if h < 5e-3 { at_1_khz } else { at_100_hz };
                check(method, &drive, 0.0, limits);
            }
        }
    }
}

#[test]
fn a_noisy_speed_leaves_what_a_hot_lining_carries_known() {
    for scenario in [wet::wet_6_fade(), faded::dry_7_fade(), faded::dry_7_hot()] {
        let drive = scenario.drive(1e-3);
        check(Method::Energy, &drive, NOISE, [2.3, 3.2, 1.8]);
        check(Method::Kalman, &drive, NOISE, [2.1, 3.0, 0.6]);
        check(Method::Calibrating, &drive, NOISE, [2.2, 3.2, 1.2]);
    }
}

/// A gear that is synchronised turns the drive shaft against what no clutch explains: the drive shaft's torque
/// missed by 10 to 70 % before its torque was taken from the speed of its shaft. The two last ones forgot T_s with every gear,
/// which cost 0.9 and 1.2 % at 100 Hz.
#[test]
fn torques_are_followed_through_gear_changes() {
    let limits = [
        (Method::Paper, [3.3, 7.3, 2.4], [3.3, 13.5, 3.9]),
        (Method::Lyapunov, [3.4, 8.0, 2.8], [3.0, 10.8, 3.4]),
        (Method::Energy, [2.3, 3.0, 1.5], [3.5, 3.0, 2.6]),
        (Method::Kalman, [2.0, 2.0, 0.9], [2.8, 3.2, 0.7]),
        (Method::Calibrating, [1.4, 1.7, 0.95], [2.8, 4.0, 1.2]),
    ];
    for scenario in [scenarios::double_upshift(), scenarios::kick_down()] {
        for h in [1e-3, 1e-2] {
            let drive = scenario.drive(h);
            for (method, at_1_khz, at_100_hz) in limits {
                let limits = if h < 5e-3 { at_1_khz } else { at_100_hz };
                check(method, &drive, 0.0, limits);
            }
        }
    }
}

/// The goal of `kalman` with noise is 1.5 % of T_o. A gear taken as in 3 rad/s early left 3 N·m·s of its synchroniser out, and
/// its spike took seed 3 to 1.57 %.
#[test]
fn noise_does_not_hide_when_a_gear_is_in() {
    let drive = scenarios::kick_down().drive(1e-3);
    for seed in 1..=8 {
        let errors = run(Method::Kalman, &drive, noisy(NOISE, seed)).percent();
        println!("seed {seed}: {errors:.2?} %");
        assert!(
            errors[2] <= 1.5 && errors[0].max(errors[1]) < 4.0,
            "seed {seed}: {errors:.2?} %"
        );
    }
}

/// 2 % of the power lost in gears is less than what is known of them; no observer has a parameter for it.
#[test]
fn methods_hold_on_gears_that_lose_power() {
    let drive = faded::losing().drive(1e-3);
    check(Method::Paper, &drive, 0.0, [3.2, 4.0, 2.8]);
    check(Method::Energy, &drive, 0.0, [6.5, 6.5, 3.0]);
    check(Method::Kalman, &drive, 0.0, [2.1, 2.0, 2.7]);
    check(Method::Calibrating, &drive, 0.0, [1.6, 1.7, 1.9]);
}

/// Whatever was driven, the last second is followed: no method diverges, not even from the shock of a
/// synchroniser that acts at once (5 000 N·m in the drive shaft).
#[test]
fn no_method_diverges_on_scenarios_it_was_not_tuned_on() {
    /// RMSE over the last second [% of the RMS torque of the drive].
    const SETTLED: f64 = 35.0;
    for scenario in scenarios::unseen() {
        for h in [1e-3, 1e-2] {
            let drive = scenario.drive(h);
            for method in Method::ALL {
                let mut observer = Selected::new(method);
                let settings = Settings::CASE_1;
                let mut last = Score::default();
                let whole = observe(
                    &drive,
                    &mut observer,
                    &drive.p,
                    &settings,
                    perfect,
                    |moment, estimate| {
                        if moment.time > scenario.stop - 1.0 {
                            last.add(&moment.y, estimate);
                        }
                    },
                );
                let rms = (whole.truth[2] / drive.moments.len() as f64).sqrt();
                let error = (last.error[2] * drive.h).sqrt();
                let percent = 100.0 * error / rms;
                assert!(
                    percent < SETTLED,
                    "{method:?} {} h = {h} s: {percent:.1} %",
                    drive.name
                );
            }
        }
    }
}

#[test]
fn no_method_diverges_at_any_step_to_20_ms() {
    for h in [1e-4, 2e-3, 5e-3, 2e-2] {
        let drive = scenarios::aborted_launch().drive(h);
        for method in Method::ALL {
            check(method, &drive, NOISE, [50.0; 3]);
        }
    }
}

/// A state that is visited out of one observer and into another goes on bit for bit.
#[test]
fn a_visited_state_is_the_whole_state() {
    let drive = scenarios::aborted_launch().drive(1e-2);
    let settings = Settings::CASE_1;
    let half = drive.moments.len() / 2;
    for method in Method::ALL {
        let mut observer = Selected::new(method);
        observer.start(&drive.p, &settings, &drive.start);
        for moment in &drive.moments[..half] {
            observer.step(&drive.p, &settings, &moment.sample, drive.h);
        }
        let mut numbers = Vec::new();
        observer.visit(&mut |value| numbers.push(*value));
        let mut copy = Selected::new(method);
        let mut next = numbers.iter();
        copy.visit(&mut |value| *value = *next.next().unwrap());
        for moment in &drive.moments[half..] {
            let [ours, theirs] = [&mut observer, &mut copy]
                .map(|observer| observer.step(&drive.p, &settings, &moment.sample, drive.h));
            assert_eq!(ours, theirs, "{method:?} t = {} s", moment.time);
        }
    }
}

/// The last fault told on a drive whose samples are spoilt from 6 s on.
fn fault(method: Method, spoil: fn(&mut Sample)) -> Option<Fault> {
    let drive = scenarios::aborted_launch().drive(1e-2);
    let (mut count, mut last) = (0, None);
    let sensors = |mut sample: Sample| {
        count += 1;
        if count > 600 {
            spoil(&mut sample);
        }
        sample
    };
    let mut observer = Selected::new(method);
    observe(
        &drive,
        &mut observer,
        &drive.p,
        &Settings::CASE_1,
        sensors,
        |_, estimate| {
            assert_eq!(estimate.valid, estimate.fault.is_none());
            last = estimate.fault.or(last);
        },
    );
    last
}

#[test]
fn inputs_that_make_no_sense_are_told() {
    for method in Method::ALL {
        let lost = fault(method, |sample| sample.omega_w = 0.0);
        let frozen = fault(method, |sample| sample.omega_c[0] = 60.0);
        let nan = fault(method, |sample| sample.omega_e = f64::NAN);
        assert_eq!(fault(method, |_| {}), None, "{method:?}");
        assert_eq!(lost, Some(Fault::NoSpeed), "{method:?}");
        assert_eq!(frozen, Some(Fault::Frozen), "{method:?}");
        assert_eq!(nan, Some(Fault::NotFinite), "{method:?}");
    }
}

#[test]
fn a_clean_drive_is_valid_throughout() {
    for scenario in [scenarios::paper(), scenarios::creep(), scenarios::random(7)] {
        for h in [1e-3, 1e-2] {
            let drive = scenario.drive(h);
            for method in Method::ALL {
                let mut observer = Selected::new(method);
                let settings = Settings::CASE_1;
                observe(
                    &drive,
                    &mut observer,
                    &drive.p,
                    &settings,
                    perfect,
                    |moment, estimate| {
                        let (name, time) = (&drive.name, moment.time);
                        assert!(
                            estimate.valid,
                            "{method:?} {name} t = {time} s: {:?}",
                            estimate.fault
                        );
                    },
                );
            }
        }
    }
}

/// What PAPER.md states of late and lost samples: they cost next to nothing [percentage points].
#[test]
fn a_sample_that_is_late_or_lost_costs_little() {
    const COST: f64 = 0.3;
    let drive = scenarios::paper().drive(1e-3);
    for method in [
        Method::Paper,
        Method::Lyapunov,
        Method::Energy,
        Method::Kalman,
        Method::Calibrating,
    ] {
        let clean = run(method, &drive, perfect).percent();
        let late = run(method, &drive, delayed()).percent();
        let lost = run(method, &drive, dropping(1)).percent();
        assert!(late != clean && lost != clean, "{method:?}");
        for worse in [late, lost] {
            let dear = worse.iter().zip(clean).any(|(w, c)| *w > c + COST);
            assert!(!dear, "{method:?}: {worse:.1?} after {clean:.1?} %");
        }
    }
}
