//! Two vehicles with the same speeds and other torques: what no observer can tell apart, whatever its method.
//!
//! An engine torque that is reported ΔT too high, and one that is right while the road is steeper: with a clutch engaged,
//! or one slipping alone, all of g ΔT goes through the drive shaft into the load, and no speed differs. An observer that is
//! right about the one vehicle is wrong about the other by ΔT in its clutch and g ΔT in its drive shaft.

use crate::bench::sensors::{torque_error, torque_offset};
use crate::bench::{Drive, Scenario, calibrated, scenarios};
use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::{E, TWIST_D, TWIST_O, TWIST_T, slip};
use dct_driveline::observer::Settings;
use dct_driveline::plant::{InputRate, Output, Plant};

const H: f64 = 1e-3;
/// Speeds that count as the same [rad/s]: a fifth of the least noise that `calibrating` hears. The step in which clutch 2 breaks
/// away parts them; up to then they are the same to 12 digits.
const ALIKE: f64 = 4e-3;
/// Slip of a clutch that is not stuck [rad/s].
const SLIPS: f64 = 1e-9;

/// φ on which the load is `more` [N·m] than on `phi` [rad], by secants, at the speed of the vehicle `omega_w` [rad/s].
fn steeper(p: &Params, omega_w: f64, phi: f64, more: f64) -> f64 {
    let load = |phi| p.road.load_torque(omega_w, phi);
    let slope = (load(phi + 1e-3) - load(phi)) / 1e-3;
    let goal = load(phi) + more;
    (0..5).fold(phi, |phi, _| phi + (goal - load(phi)) / slope)
}

/// The drive of `scenario` up to `until` [s] with `more` engine torque [N·m], which the load takes, and a clutch 2, alone,
/// whose friction, static and kinetic, carries as much more: outputs after every step.
fn twin(scenario: &Scenario, more: f64, until: f64) -> Vec<Output> {
    let p = &scenario.p;
    let gear = scenario.gears[0].1;
    let (g, even) = (p.g(gear)[1], &p.clutch[1]);
    let friction = |slip: f64| {
        if slip.abs() > SLIPS {
            even.mu_k
        } else {
            even.mu_s
        }
    };
    let phi = |phi| steeper(p, scenario.v / p.road.r_w, phi, g * more);
    let input = |time: f64, omega_e: f64, slip: f64| {
        let mut u = scenario.input(time, omega_e);
        (u.t_e, u.phi) = (u.t_e + more, phi(u.phi));
        u.force[1] += more / (friction(slip) * even.r_c_n);
        u
    };
    let mut u = input(0.0, scenario.omega_e, 0.0);
    let mut propagators = Propagators::new(p, u.gear, H);
    let mut plant = Plant::start(p, &u, scenario.omega_e, scenario.v);
    plant.x[TWIST_D] += more / p.k_d;
    plant.x[TWIST_T + 1] += g / p.i_f[1] * more / p.k_t[1];
    plant.x[TWIST_O] += g * more / p.k_o;
    (0..(until / H).round() as u32)
        .map(|k| {
            u = input(f64::from(k) * H, plant.x[E], slip(&plant.x)[1]);
            plant.step(p, &mut propagators, &u, &InputRate::default());
            plant.outputs(p, &propagators.systems, &u)
        })
        .collect()
}

/// Largest difference of a speed [rad/s].
fn apart(one: &Output, other: &Output) -> f64 {
    let speeds = |y: &Output| [y.omega_e, y.omega_c[0], y.omega_c[1], y.omega_w];
    let both = speeds(one).into_iter().zip(speeds(other));
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Squares of what parts T_c2 and T_o of a drive from those of its twin, between two times [s], and how far the speeds
/// are apart up to then.
fn parted(drive: &Drive, twin: &[Output], from: f64) -> ([f64; 2], f64) {
    let (mut square, mut most) = ([0.0; 2], 0.0_f64);
    for (moment, other) in drive.moments.iter().zip(twin) {
        let y = &moment.y;
        most = most.max(apart(y, other));
        if moment.time > from {
            square[0] += (y.t_c[1] - other.t_c[1]).powi(2);
            square[1] += (y.t_o - other.t_o).powi(2);
        }
    }
    (square, most)
}

/// RMSE of T_c2 and T_o over the whole drive [% of RMS] that an observer cannot avoid if it is right about the twins:
/// (torque of the twin [N·m], from, until [s]), one after another.
fn floor(scenario: &Scenario, drive: &Drive, twins: &[(f64, f64, f64)]) -> [f64; 2] {
    let truth =
        |of: fn(&Output) -> f64| drive.moments.iter().map(|m| of(&m.y).powi(2)).sum::<f64>();
    let all = [truth(|y| y.t_c[1]), truth(|y| y.t_o)];
    let mut sum = [0.0; 2];
    for (more, from, until) in twins {
        let (square, most) = parted(drive, &twin(scenario, *more, *until), *from);
        println!(
            "{}: {more:.2} N·m up to {until} s: speeds {most:.1e} rad/s apart",
            drive.name
        );
        assert!(most < ALIKE, "{}: {most:.1e} rad/s", drive.name);
        (0..2).for_each(|k| sum[k] += square[k]);
    }
    [0, 1].map(|k| 100.0 * (sum[k] / all[k]).sqrt())
}

/// Floor of T_e +2 N·m, whose offset no speed shows before `until` [s], and what `calibrating` misses [% of RMS].
fn offset(scenario: &Scenario, until: f64) -> ([f64; 2], [f64; 3]) {
    let drive = scenario.drive(H);
    let floor = floor(scenario, &drive, &[(2.0, 0.0, until)]);
    (
        floor,
        calibrated(&drive, &Settings::CASE_1, torque_offset).0,
    )
}

/// The same of T_e +5 % +2 N·m: no scale shows before `pedal`, no offset before `until`.
fn both(scenario: &Scenario, pedal: f64, until: f64) -> ([f64; 2], [f64; 3]) {
    let drive = scenario.drive(H);
    let at_first = torque_error(drive.start).t_e - drive.start.t_e;
    let left = 2.0 / 1.05;
    let twins = [(at_first, 0.0, pedal), (left, pedal, until)];
    let floor = floor(scenario, &drive, &twins);
    (floor, calibrated(&drive, &Settings::CASE_1, torque_error).0)
}

/// What `calibrating` misses above that: T_c2, T_o [% of RMS].
const ABOVE: [f64; 2] = [0.9, 0.9];
/// Goals of `calibrating`: T_c2, T_o [% of RMS].
const GOALS: [f64; 2] = [4.0, 2.0];

/// In tip-in both goals are out of reach, in kick-down that of T_c2 where a scale is wrong as well. Where the goal is in reach
/// or not, `calibrating` is near what is possible.
#[test]
fn what_of_a_wrong_engine_torque_no_observer_can_find_in_time() {
    let (kick, tip) = (scenarios::kick_down(), scenarios::tip_in_tip_out());
    let cases = [
        (both(&kick, 1.0, 2.28), [true, false]),
        (offset(&kick, 2.28), [false, false]),
        (both(&tip, 0.5, tip.stop), [true, true]),
        (offset(&tip, tip.stop), [true, true]),
    ];
    for ((floor, ours), beyond) in cases {
        println!("T_c2, T_o at least {floor:.2?} %, ours {ours:.2?} %");
        for k in 0..2 {
            assert_eq!(floor[k] > GOALS[k], beyond[k], "{floor:.2?} %");
            assert!(
                ours[k + 1] < floor[k] + ABOVE[k],
                "{floor:.2?} {ours:.2?} %"
            );
        }
    }
}
