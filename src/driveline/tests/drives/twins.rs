//! Vehicles with the same speeds and other torques: what no observer can tell apart, whatever its method.
//!
//! An engine torque that is reported b too high, and one that is reported b too low while the road is steeper: with a clutch
//! engaged, or one slipping alone, all of 2 g b goes through the drive shaft into the load, and no speed differs. What an
//! observer says of the one it says of the other as well. So of vehicles v with shares p_v, that are alike up to now,
//!
//! ```text
//! Σ p_v (T̂ − T_v)² ≥ Σ p_v (T̄ − T_v)²,  T̄ = Σ p_v T_v/Σ p_v             of two: b² in the clutch, (g b)² in the drive shaft
//! ```
//!
//! whatever T̂ is, and of one of them its error is at least that. It holds over all instants as well, with Σ p_v = 1 over all
//! vehicles that are alike at first: an observer that is better on one of them is worse on another.

use crate::bench::sensors::{torque_error, torque_offset};
use crate::bench::{Drive, Moment, Scenario, calibrated, observe, scenarios};
use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::{E, TWIST_D, TWIST_O, TWIST_T, slip};
use dct_driveline::observer::{Method, Sample, Selected, Settings};
use dct_driveline::plant::{InputRate, Output, Plant};
use std::ops::Range;

const H: f64 = 1e-3;
/// Speeds that count as the same [rad/s]: a quarter of the least noise that `calibrating` hears. The one step in which clutch 2
/// breaks away parts vehicles of 4 N·m more so far; up to then they are the same to 12 digits.
const ALIKE: f64 = 5e-3;
/// Slip of a clutch that is not stuck [rad/s].
const SLIPS: f64 = 1e-9;

/// φ on which the load is `more` [N·m] than on `phi` [rad], by secants, at the speed of the vehicle `omega_w` [rad/s].
fn steeper(p: &Params, omega_w: f64, phi: f64, more: f64) -> f64 {
    let load = |phi| p.road.load_torque(omega_w, phi);
    let slope = (load(phi + 1e-3) - load(phi)) / 1e-3;
    let goal = load(phi) + more;
    (0..5).fold(phi, |phi, _| phi + (goal - load(phi)) / slope)
}

/// The drive of `scenario` up to `until` [s] with so much `more` engine torque [N·m], which the load takes, and a
/// clutch 2 whose friction, static and kinetic, carries as much more: what is driven, and measured, after every step.
fn twin(scenario: &Scenario, drive: &Drive, more: f64, until: f64) -> Drive {
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
    let moved = |moment: &Moment| {
        u = input(moment.time - H, plant.x[E], slip(&plant.x)[1]);
        plant.step(p, &mut propagators, &u, &InputRate::default());
        let y = plant.outputs(p, &propagators.systems, &u);
        let sample = Sample {
            omega_e: y.omega_e,
            omega_c: y.omega_c,
            omega_w: y.omega_w,
            ..moment.sample
        };
        Moment {
            y,
            sample,
            ..*moment
        }
    };
    let moments = up_to(drive, until).iter().map(moved).collect();
    Drive {
        moments,
        ..drive.clone()
    }
}

/// Steps before a time [s].
fn steps(time: f64) -> usize {
    (time / H).round() as usize
}

/// What is driven before a time [s].
fn up_to(drive: &Drive, until: f64) -> &[Moment] {
    &drive.moments[..steps(until)]
}

/// Largest difference of a speed [rad/s].
fn apart(one: &Output, other: &Output) -> f64 {
    let speeds = |y: &Output| [y.omega_e, y.omega_c[0], y.omega_c[1], y.omega_w];
    let both = speeds(one).into_iter().zip(speeds(other));
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// T_c2 and T_o [N·m], shape (2).
fn torques(y: &Output) -> [f64; 2] {
    [y.t_c[1], y.t_o]
}

/// What a sensor reads.
type Reads = fn(Sample) -> Sample;

/// A vehicle, driven up to a time.
struct Vehicle {
    drive: Drive,
    /// The torque that is reported, from that of the first vehicle.
    reads: Reads,
    /// p_v, of which all have 1 together.
    share: f64,
}

/// Vehicles with the same speeds.
struct Family {
    vehicles: Vec<Vehicle>,
    /// Sums of squares of T_c2 and T_o over the whole drive of the first [(N·m)²].
    whole: [f64; 2],
}

impl Family {
    /// The drive of `scenario` up to `until` [s] by vehicles of so much more engine torque [N·m], reported as told, with
    /// these shares.
    fn new(scenario: &Scenario, until: f64, all: &[(f64, Reads, f64)]) -> Self {
        let (drive, mut whole) = (scenario.drive(H), [0.0; 2]);
        for moment in &drive.moments {
            let of = torques(&moment.y);
            (0..2).for_each(|k| whole[k] += of[k] * of[k]);
        }
        let vehicles = all.iter().map(|(more, reads, share)| Vehicle {
            drive: twin(scenario, &drive, *more, until),
            reads: *reads,
            share: *share,
        });
        Self {
            vehicles: vehicles.collect(),
            whole,
        }
    }

    /// What vehicles that are alike between two instants [s] add to the sums of squares.
    fn parted(&self, alike: Range<usize>, from: f64, until: f64) -> [f64; 2] {
        let (vehicles, mut sum, mut most) = (&self.vehicles[alike], [0.0; 2], 0.0_f64);
        let all: f64 = vehicles.iter().map(|v| v.share).sum();
        for j in steps(from)..steps(until) {
            let of = |v: &Vehicle| v.drive.moments[j].y;
            let first = of(&vehicles[0]);
            for (k, sum) in sum.iter_mut().enumerate() {
                let torque = |v: &Vehicle| torques(&of(v))[k];
                let mean = vehicles.iter().map(|v| v.share * torque(v)).sum::<f64>() / all;
                let off = |v: &Vehicle| v.share * (torque(v) - mean).powi(2);
                *sum += vehicles.iter().map(off).sum::<f64>();
            }
            let apart = vehicles.iter().map(|v| apart(&first, &of(v)));
            most = apart.fold(most, f64::max);
        }
        println!("from {from} to {until} s: speeds {most:.1e} rad/s apart");
        assert!(most < ALIKE, "{most:.1e} rad/s");
        sum
    }

    /// Root of what the sums of squares are in the mean of the vehicles [% of RMS].
    fn percent(&self, sum: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| 100.0 * (sum[k] / self.whole[k]).sqrt())
    }

    /// RMS errors of T_c2 and T_o up to where the vehicles are driven, root mean square of all of them [% of RMS].
    fn reached(&self, method: Method) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for Vehicle {
            drive,
            reads,
            share,
        } in &self.vehicles
        {
            let (mut observer, settings) = (Selected::new(method), Settings::CASE_1);
            let score = observe(drive, &mut observer, &drive.p, &settings, *reads, |_, _| {});
            (0..2).for_each(|k| sum[k] += share * score.error[k + 1]);
        }
        self.percent(sum)
    }
}

/// T_e as from a sensor that reads 5 % too low: of 30 N·m as [`torque_error`] reads it.
fn another_scale(mut sample: Sample) -> Sample {
    sample.t_e = 0.95 * sample.t_e + 5.0;
    sample
}

/// T_e that reads 5 % and 2 N·m wrong. Before the pedal no scale shows, so vehicles of all four signs are alike, up to `until`
/// those of one scale. The shares are those of a floor that is as high as possible.
fn both(scenario: &Scenario, pedal: f64, until: f64) -> (Family, [f64; 2]) {
    let t_e = scenario.drive(H).start;
    let reported = torque_error(t_e).t_e;
    assert_eq!(another_scale(t_e).t_e, reported);
    let more = |scale: f64, offset: f64| (reported - offset) / scale - t_e.t_e;
    let family = Family::new(
        scenario,
        until,
        &[
            (more(1.05, 2.0), torque_error, 0.35),
            (more(1.05, -2.0), torque_error, 0.15),
            (more(0.95, 2.0), another_scale, 0.15),
            (more(0.95, -2.0), another_scale, 0.35),
        ],
    );
    let parted = [
        family.parted(0..4, 0.0, pedal),
        family.parted(0..2, pedal, until),
        family.parted(2..4, pedal, until),
    ];
    let floor = family.percent([0, 1].map(|k| parted.iter().map(|sum| sum[k]).sum()));
    (family, floor)
}

/// T_e that reads 2 N·m too high or too low.
fn offset(scenario: &Scenario, until: f64) -> (Family, [f64; 2]) {
    let pair = [
        (0.0, torque_offset as Reads, 0.5),
        (4.0, torque_offset, 0.5),
    ];
    let family = Family::new(scenario, until, &pair);
    let floor = family.percent(family.parted(0..2, 0.0, until));
    (family, floor)
}

/// Goals of `calibrating`: T_c2, T_o [% of RMS].
const GOALS: [f64; 2] = [4.0, 2.0];
/// What `calibrating` misses over the floor [1].
const ABOVE: f64 = 1.2;

/// Both goals are out of reach in tip-in, that of T_c2 in kick-down where a scale is wrong as well. No method is below the
/// floor, and `calibrating` is near it.
#[test]
fn what_of_a_wrong_engine_torque_no_observer_can_find_in_time() {
    let (kick, tip) = (scenarios::kick_down(), scenarios::tip_in_tip_out());
    let cases = [
        (both(&kick, 1.0, 3.2), [true, false]),
        (offset(&kick, 3.2), [false, false]),
        (offset(&tip, tip.stop), [true, true]),
    ];
    for ((family, floor), beyond) in cases {
        println!("T_c2, T_o at least {floor:.2?} %");
        for method in Method::ALL {
            let reached = family.reached(method);
            println!("{method:?} {reached:.2?} %");
            for k in 0..2 {
                let near = method != Method::Calibrating || reached[k] < ABOVE * floor[k];
                assert!(reached[k] > floor[k] && near, "{floor:.2?} {reached:.2?} %");
            }
        }
        assert_eq!([0, 1].map(|k| floor[k] > GOALS[k]), beyond, "{floor:.2?} %");
    }
}

/// Over the whole drives, of which the twins are a part: T_c2, T_o [% of RMS].
#[test]
fn what_is_hidden_costs_a_whole_drive_little_more() {
    let (kick, tip) = (scenarios::kick_down(), scenarios::tip_in_tip_out());
    for (scenario, sensors, limits) in [
        (&kick, torque_error as Reads, [5.1, 2.5]),
        (&kick, torque_offset, [4.0, 2.1]),
        (&tip, torque_error, [4.1, 4.5]),
        (&tip, torque_offset, [4.1, 4.5]),
    ] {
        let (drive, settings) = (scenario.drive(H), Settings::CASE_1);
        let (percent, _) = calibrated(&drive, &settings, sensors);
        println!("{}: {percent:.2?} %", drive.name);
        let within = percent[1..]
            .iter()
            .zip(limits)
            .all(|(error, limit)| *error < limit);
        assert!(within, "{}: {percent:.2?} %", drive.name);
    }
}
