//! The observer `paper` on the exact plant over the paper's scenario, both friction cases.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    dead_code,
    reason = "helpers of tests"
)]

mod golden_files;

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::observer::{Estimate, LoadMethod, Observer, Paper, Sample, Settings};
use dct_driveline::params::Actuation;
use dct_driveline::plant::{Input, InputRate, Output, Plant};
use golden_files::{Case, Table};

const CASE_1: [f64; 2] = [0.4, 0.1];
const CASE_2: [f64; 2] = [0.1, 0.4];
const GEAR: [i32; 2] = [1, 2];

/// Sums of squares of truth and of the errors of both estimates: T_c1, T_c2, T_o.
#[derive(Debug, Default)]
struct Score {
    truth: [f64; 3],
    observer: [f64; 3],
    map: [f64; 3],
}

impl Score {
    fn add(&mut self, y: &Output, estimate: &Estimate) {
        let truth = [y.t_c[0], y.t_c[1], y.t_o];
        let ours = [estimate.t_c[0], estimate.t_c[1], estimate.t_o];
        let map = [estimate.t_c_map[0], estimate.t_c_map[1], estimate.t_o_map];
        for i in 0..3 {
            self.truth[i] += truth[i].powi(2);
            self.observer[i] += (ours[i] - truth[i]).powi(2);
            self.map[i] += (map[i] - truth[i]).powi(2);
        }
    }

    /// RMSE in % of the RMS torque, shape (3).
    fn percent(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| 100.0 * (self.observer[i] / self.truth[i]).sqrt())
    }

    /// RMSE of the map-based estimate over that of the observer, shape (3).
    fn gain(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| (self.map[i] / self.observer[i]).sqrt())
    }
}

fn actuation(scenario: &Table, time: f64) -> [Actuation; 2] {
    ["clutch1.position", "clutch2.position"].map(|name| Actuation {
        position: scenario.at(name, time),
        pressure: 0.0,
    })
}

/// One run of plant and observer at steps of `h` [s]; `each` sees every step.
fn run(settings: &Settings, h: f64, each: impl FnMut(f64, &Output, &Estimate)) -> Score {
    run_in(settings, h, GEAR, f64::INFINITY, each)
}

/// The same with these gears preselected, until `stop` [s].
fn run_in(
    settings: &Settings,
    h: f64,
    gear: [i32; 2],
    stop: f64,
    mut each: impl FnMut(f64, &Output, &Estimate),
) -> Score {
    let (p, case) = (Params::TABLE_1, Case::read("paper_compliant"));
    let input = |time: f64| Input {
        t_e: case.scenario.at("engine.torque", time),
        force: [0, 1].map(|i| p.clutch[i].force(actuation(&case.scenario, time)[i])),
        gear,
        t_brake: 0.0,
        phi: case.scenario.at("road.grade", time),
    };
    let mut propagators = Propagators::new(&p, gear, h);
    let mut plant = Plant::start(&p, &input(0.0), case.omega_e, case.v);
    let mut observer = Paper::default();
    let mut score = Score::default();
    let mut k = 0_u32;
    let steps = case.stop.min(stop) / h;
    while f64::from(k) < steps - 0.5 {
        let time = f64::from(k) * h;
        let u = input(time);
        if k == 0 {
            let y = plant.outputs(&p, &propagators.systems, &u);
            observer.start(&p, settings, &sample(&case.scenario, time, &u, &y));
        }
        plant.step(&p, &mut propagators, &u, &InputRate::default());
        let y = plant.outputs(&p, &propagators.systems, &u);
        let estimate = observer.step(&p, settings, &sample(&case.scenario, time, &u, &y), h);
        score.add(&y, &estimate);
        each(time + h, &y, &estimate);
        k += 1;
    }
    score
}

/// What is measured at the end of a step whose inputs were those of `time`.
fn sample(scenario: &Table, time: f64, u: &Input, y: &Output) -> Sample {
    Sample {
        t_e: u.t_e,
        omega_e: y.omega_e,
        omega_c: y.omega_c,
        omega_w: y.omega_w,
        actuation: actuation(scenario, time),
        gear: u.gear,
        t_brake: u.t_brake,
        phi: u.phi,
        t_y: 0.0,
    }
}

fn settings(mu_n: [f64; 2], load: LoadMethod) -> Settings {
    Settings {
        mu_n,
        load,
        ..Settings::CASE_1
    }
}

/// Checks a case against its limits on the RMSE [% of RMS], shape (3).
fn check(settings: &Settings, h: f64, limits: [f64; 3]) {
    let score = run(settings, h, |time, _, estimate| {
        assert!(estimate.t_o.is_finite(), "t = {time} s");
    });
    println!(
        "{:.1?} % of RMS, map-based / observer {:.1?}",
        score.percent(),
        score.gain()
    );
    let within = score
        .percent()
        .iter()
        .zip(limits)
        .all(|(error, limit)| *error <= limit);
    assert!(within, "{:?} % of RMS", score.percent());
    assert!(
        score.gain().iter().all(|gain| *gain >= 4.0),
        "map-based / observer {:?}",
        score.gain()
    );
}

#[test]
fn case_1_with_exact_load_is_within_its_limits() {
    check(
        &settings(CASE_1, LoadMethod::Grade),
        1e-3,
        [12.0, 14.0, 3.0],
    );
}

#[test]
fn case_2_with_exact_load_is_within_its_limits() {
    check(
        &settings(CASE_2, LoadMethod::Grade),
        1e-3,
        [16.0, 19.0, 3.5],
    );
}

#[test]
fn load_by_momentum_costs_little() {
    check(
        &settings(CASE_1, LoadMethod::Momentum),
        1e-3,
        [12.0, 15.0, 3.5],
    );
    check(
        &settings(CASE_2, LoadMethod::Momentum),
        1e-3,
        [16.0, 19.0, 3.5],
    );
}

#[test]
fn momentum_finds_the_load_better_than_the_rigid_form() {
    let error = |load| {
        let (mut error, mut truth) = (0.0, 0.0);
        run(&settings(CASE_1, load), 1e-3, |_, y, estimate| {
            error += (estimate.t_v - y.t_v).powi(2);
            truth += y.t_v.powi(2);
        });
        f64::sqrt(error / truth)
    };
    assert!(error(LoadMethod::Momentum) < 0.05);
    assert!(error(LoadMethod::Momentum) < 0.2 * error(LoadMethod::Engine));
}

#[test]
fn without_adaptation_the_nominal_friction_stays() {
    let frozen = Settings {
        adapts: false,
        ..settings(CASE_1, LoadMethod::Grade)
    };
    run(&frozen, 1e-3, |_, _, estimate| {
        assert_eq!(estimate.epsilon, [0.0; 2])
    });
}

#[test]
fn engine_braking_shows_in_the_sign_of_the_clutch_torque() {
    run(
        &settings(CASE_1, LoadMethod::Momentum),
        1e-3,
        |time, y, estimate| {
            if (22.5..23.5).contains(&time) {
                assert!(y.t_c[0] < 0.0 && estimate.t_c[0] < 0.0, "t = {time} s");
            }
        },
    );
}

/// The clutch control relies on it: friction is learnt while slipping and kept in an engaged clutch.
#[test]
fn friction_is_learnt_while_slipping_and_kept_while_engaged() {
    /// Relative error of the friction at lock-up.
    const NEAR: f64 = 0.1;
    for mu_n in [CASE_1, CASE_2] {
        let mut last = [0.0; 2];
        run(
            &settings(mu_n, LoadMethod::Momentum),
            1e-3,
            |time, y, estimate| {
                if y.slip[0] == 0.0 && estimate.engaged[0] {
                    assert_eq!(estimate.friction[0], last[0], "t = {time} s");
                }
                if (2.5..2.53).contains(&time) {
                    let error = estimate.friction[0] / Params::TABLE_1.clutch[0].mu_k - 1.0;
                    assert!(error.abs() < NEAR, "t = {time} s: {error}");
                }
                last = estimate.friction;
            },
        );
    }
}

/// From 0.1 ms to 20 ms, with the gains that follow the step. Limits widen with the step: a sample held
/// for longer corrects less.
#[test]
fn every_step_from_0_1_to_20_ms_gives_usable_estimates() {
    for (h, limits) in [
        (1e-4, [12.0, 14.0, 3.0]),
        (2e-3, [12.0, 14.0, 4.0]),
        (1e-2, [12.0, 14.0, 7.0]),
        (2e-2, [16.0, 19.0, 12.0]),
    ] {
        for mu_n in [CASE_1, CASE_2] {
            check(&settings(mu_n, LoadMethod::Momentum), h, limits);
        }
    }
}

#[test]
fn a_launch_with_the_even_shaft_in_neutral_is_followed_as_well() {
    const DRIVE_IN_FIRST: f64 = 8.0;
    let error = |gear| {
        run_in(
            &settings(CASE_1, LoadMethod::Momentum),
            1e-3,
            gear,
            DRIVE_IN_FIRST,
            |_, _, _| {},
        )
        .percent()
    };
    let (both, neutral) = (error([1, 2]), error([1, 0]));
    println!("{both:.2?} with a gear on the even shaft, {neutral:.2?} in neutral");
    assert!(
        [0, 2].iter().all(|i| neutral[*i] < 1.5 * both[*i]),
        "{neutral:?}"
    );
}

fn steady() -> Sample {
    Sample {
        t_e: 50.0,
        omega_e: 150.0,
        omega_c: [144.0, 92.16],
        omega_w: 8.0,
        actuation: [4e-3, 0.0].map(|position| Actuation {
            position,
            pressure: 0.0,
        }),
        gear: GEAR,
        ..Sample::default()
    }
}

#[test]
fn nothing_that_is_no_number_gets_in() {
    let (p, s, good) = (
        Params::TABLE_1,
        settings(CASE_1, LoadMethod::Momentum),
        steady(),
    );
    let mut observer = Paper::default();
    observer.start(&p, &s, &good);
    observer.step(&p, &s, &good, 1e-3);
    let before = observer;
    let mut refuse = |sample: &Sample, h: f64| {
        assert!(!observer.step(&p, &s, sample, h).valid);
        assert_eq!(observer, before);
    };
    let spoils: [fn(&mut Sample, f64); 8] = [
        |sample, x| sample.t_e = x,
        |sample, x| sample.omega_e = x,
        |sample, x| sample.omega_c[1] = x,
        |sample, x| sample.omega_w = x,
        |sample, x| sample.actuation[0].position = x,
        |sample, x| sample.actuation[1].pressure = x,
        |sample, x| sample.t_brake = x,
        |sample, x| sample.phi = x,
    ];
    for (spoil, x) in spoils.iter().zip([f64::NAN, f64::INFINITY].iter().cycle()) {
        let mut bad = good;
        spoil(&mut bad, *x);
        refuse(&bad, 1e-3);
    }
    for h in [f64::NAN, f64::INFINITY, 0.0, -1e-3] {
        refuse(&good, h);
    }
    assert!(observer.step(&p, &s, &good, 1e-3).valid);
}

#[test]
fn a_start_that_is_no_number_is_made_up_for_by_the_first_sample() {
    let (p, s, good) = (
        Params::TABLE_1,
        settings(CASE_1, LoadMethod::Momentum),
        steady(),
    );
    let mut observer = Paper::default();
    let bad = Sample {
        omega_e: f64::NAN,
        ..good
    };
    assert!(!observer.start(&p, &s, &bad).valid);
    let estimate = observer.step(&p, &s, &good, 1e-3);
    assert!(estimate.valid && estimate.t_o.is_finite());
}

/// A brake acts at once, whatever the load that is held.
#[test]
fn brake_torque_counts_while_the_load_is_held() {
    const BRAKE: f64 = 300.0;
    let (p, s) = (Params::TABLE_1, settings(CASE_1, LoadMethod::Momentum));
    let engaged = Sample {
        omega_e: 144.0,
        actuation: [9e-3, 0.0].map(|position| Actuation {
            position,
            pressure: 0.0,
        }),
        ..steady()
    };
    let open = Sample {
        actuation: [Actuation::default(); 2],
        ..engaged
    };
    let mut observer = Paper::default();
    observer.start(&p, &s, &engaged);
    // 5 s: the filters, of 0.1 s, have forgotten the load of (11) that they began at.
    for _ in 0..5000 {
        observer.step(&p, &s, &engaged, 1e-3);
    }
    let held = observer.step(&p, &s, &open, 1e-3).t_v;
    // Steady speeds: the load is what the engine puts on the wheels.
    assert!((held - 18.0 * 50.0).abs() < 1e-6, "{held}");
    let braked = Sample {
        t_brake: BRAKE,
        ..open
    };
    let rise = observer.step(&p, &s, &braked, 1e-3).t_v - held;
    assert!(
        (rise - BRAKE * p.road.direction(braked.omega_w)).abs() < 1e-9,
        "{rise}"
    );
}
