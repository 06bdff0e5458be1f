//! Vehicles with the same speeds and other torques: what no observer can tell apart, whatever its method, unless the road is told
//! (`vouched.rs`).
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
//!
//! A handover to the other clutch shows b, as g T_o's share of it changes: the drive shaft winds by (g_1 − g_2) b/k_o. If the
//! wheels of one vehicle lag by as little as that takes, (g_1 − g_2) b/(k_o t), and its clutches and its road carry what is left,
//! no other speed differs. On speeds with white noise of σ two vehicles with shares p and q, of p + q = 1, are then Δ apart, and
//!
//! ```text
//! Δ² = Σ (y_1 − y_2)²/σ²    over the sensors and samples so far         p q ρ (T_1 − T_2)²  in place of  p q (T_1 − T_2)²
//! ρ = ∫ f_1 f_2/(p f_1 + q f_2) dz,  f_1, f_2 normal about 0 and Δ         the mean variance of who it is, after Bayes
//! ```
//!
//! is what the best of all observers misses in the mean, even if told both vehicles and that it is one of them.

mod vehicle;

use crate::bench::sensors::{noisy, torque_error, torque_offset};
use crate::bench::{Drive, Moment, Scenario, calibrated, observe, scenarios};
use dct_driveline::observer::{Method, Sample, Selected, Settings};
use dct_driveline::plant::Output;
use std::ops::Range;
use vehicle::{H, Handover, NEVER, Twin};

/// Speeds that count as the same [rad/s]: a quarter of the least noise that `calibrating` hears. The one step in which clutch 2
/// breaks away parts vehicles of 4 N·m more so far; up to then they are the same to 12 digits.
const ALIKE: f64 = 5e-3;

/// Steps before a time [s].
fn steps(time: f64) -> usize {
    (time / H).round() as usize
}

/// What is driven before a time [s].
fn up_to(drive: &Drive, until: f64) -> &[Moment] {
    &drive.moments[..steps(until)]
}

/// Differences of the speeds that are measured [rad/s], shape (4).
fn differences(one: &Output, other: &Output) -> [f64; 4] {
    let speeds = |y: &Output| [y.omega_e, y.omega_c[0], y.omega_c[1], y.omega_w];
    let (one, other) = (speeds(one), speeds(other));
    [0, 1, 2, 3].map(|k| one[k] - other[k])
}

/// Largest difference of a speed [rad/s].
fn apart(one: &Output, other: &Output) -> f64 {
    differences(one, other)
        .map(f64::abs)
        .into_iter()
        .fold(0.0, f64::max)
}

/// ρ: what is left of the variance of who of two it is, the first with share `p` of both, that are `delta` apart [1].
fn left(delta: f64, p: f64) -> f64 {
    const STEP: f64 = 0.1;
    const TAIL: f64 = 6.0;
    let normal = |z: f64| (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    let points = ((delta + 2.0 * TAIL) / STEP) as u32;
    let at = |k: u32| {
        let z = f64::from(k) * STEP - TAIL;
        let (one, other) = (normal(z), normal(z - delta));
        one * other / (p * one + (1.0 - p) * other).max(f64::MIN_POSITIVE)
    };
    (0..=points).map(at).sum::<f64>() * STEP
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
    fn new(
        scenario: &Scenario,
        until: f64,
        handover: &Handover,
        all: &[(f64, Reads, f64)],
    ) -> Self {
        let (drive, mut whole) = (scenario.drive(H), [0.0; 2]);
        for moment in &drive.moments {
            let of = torques(&moment.y);
            (0..2).for_each(|k| whole[k] += of[k] * of[k]);
        }
        let vehicles = all.iter().map(|&(more, reads, share)| {
            let twin = Twin {
                scenario,
                more,
                handover,
            };
            Vehicle {
                drive: twin.drive(up_to(&drive, until), &drive),
                reads,
                share,
            }
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

    /// What two vehicles that differ by less than noise of `sigma` [rad/s] for a while add to the sums of squares.
    fn blurred(&self, pair: [usize; 2], from: f64, until: f64, sigma: f64) -> [f64; 2] {
        let [one, other] = pair.map(|j| &self.vehicles[j]);
        let (all, product) = (one.share + other.share, one.share * other.share);
        let (mut sum, mut square, mut most) = ([0.0; 2], 0.0, 0.0_f64);
        for j in steps(from)..steps(until) {
            let [a, b] = [one, other].map(|v| v.drive.moments[j].y);
            square += differences(&a, &b)
                .iter()
                .map(|d| (d / sigma).powi(2))
                .sum::<f64>();
            let weight = product / all * left(square.sqrt(), one.share / all);
            let off = [0, 1].map(|k| (torques(&a)[k] - torques(&b)[k]).powi(2));
            (0..2).for_each(|k| sum[k] += weight * off[k]);
            most = most.max(apart(&a, &b));
        }
        println!(
            "from {from} to {until} s: speeds {most:.1e} rad/s apart, {:.2} σ in all",
            square.sqrt()
        );
        sum
    }

    /// Root of what the sums of squares are in the mean of the vehicles [% of RMS].
    fn percent(&self, sum: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| 100.0 * (sum[k] / self.whole[k]).sqrt())
    }

    /// RMS errors of T_c2 and T_o up to where the vehicles are driven, root mean square of all of them [% of RMS], with
    /// noise of `sigma` [rad/s].
    fn reached(&self, method: Method, sigma: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (seed, vehicle) in (1..).zip(&self.vehicles) {
            let (mut observer, settings) = (Selected::new(method), Settings::CASE_1);
            let (drive, mut noise) = (&vehicle.drive, noisy(sigma, seed));
            let sensors = |sample| noise((vehicle.reads)(sample));
            let score = observe(
                drive,
                &mut observer,
                &drive.p,
                &settings,
                sensors,
                |_, _| {},
            );
            (0..2).for_each(|k| sum[k] += vehicle.share * score.error[k + 1]);
        }
        self.percent(sum)
    }
}

/// T_e as from a sensor that reads 5 % too low: of 30 N·m as [`torque_error`] reads it.
fn another_scale(mut sample: Sample) -> Sample {
    sample.t_e = 0.95 * sample.t_e + 5.0;
    sample
}

/// Vehicles whose T_e reads 5 % and 2 N·m wrong, of all four signs. The shares are those of a floor that is as high as possible.
fn four(scenario: &Scenario, until: f64, handover: &Handover) -> Family {
    let t_e = scenario.drive(H).start;
    let reported = torque_error(t_e).t_e;
    assert_eq!(another_scale(t_e).t_e, reported);
    let more = |scale: f64, offset: f64| (reported - offset) / scale - t_e.t_e;
    let all = [
        (more(1.05, 2.0), torque_error as Reads, 0.35),
        (more(1.05, -2.0), torque_error, 0.15),
        (more(0.95, 2.0), another_scale, 0.15),
        (more(0.95, -2.0), another_scale, 0.35),
    ];
    Family::new(scenario, until, handover, &all)
}

/// Before the pedal no scale shows, so all four are alike, up to `until` those of one scale.
fn both(scenario: &Scenario, pedal: f64, until: f64) -> (Family, [f64; 2]) {
    let family = four(scenario, until, &NEVER);
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
    let family = Family::new(scenario, until, &NEVER, &pair);
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
            let reached = family.reached(method, 0.0);
            println!("{method:?} {reached:.2?} %");
            for k in 0..2 {
                let near = method != Method::Calibrating || reached[k] < ABOVE * floor[k];
                assert!(reached[k] > floor[k] && near, "{floor:.2?} {reached:.2?} %");
            }
        }
        assert_eq!([0, 1].map(|k| floor[k] > GOALS[k]), beyond, "{floor:.2?} %");
    }
}

/// T_o of kick-down up to where second gear takes over, and whether its goal is out of reach where speeds are as noisy: 0.02 rad/s are
/// what `calibrating` believes of them at least.
#[test]
fn what_an_offset_costs_the_drive_shaft_of_kick_down_where_speeds_are_noisy() {
    const HANDOVER: Handover = 2.3..3.55;
    const UNTIL: f64 = 7.2;
    const PEDAL: f64 = 1.0;
    let family = four(&scenarios::kick_down(), UNTIL, &HANDOVER);
    let hidden = family.parted(0..4, 0.0, PEDAL);
    for (sigma, beyond) in [(0.01, false), (0.02, true), (0.1, true)] {
        let [one, other] = [[0, 1], [2, 3]].map(|pair| family.blurred(pair, PEDAL, UNTIL, sigma));
        let floor = family.percent([0, 1].map(|k| hidden[k] + one[k] + other[k]))[1];
        println!("{sigma} rad/s: T_o at least {floor:.2} %");
        assert_eq!(floor > GOALS[1], beyond, "{sigma} rad/s: {floor:.2} %");
        for method in Method::ALL {
            let reached = family.reached(method, sigma)[1];
            println!("{method:?} {reached:.2} %");
            assert!(reached > floor, "{method:?} {reached:.2} of {floor:.2} %");
        }
    }
}

/// A pair that noise does not part keeps its variance; of one far apart none is left.
#[test]
fn what_is_known_of_two_falls_with_their_distance() {
    for p in [0.3, 0.5] {
        assert!((left(0.0, p) - 1.0).abs() < 1e-6 && left(12.0, p) < 1e-6);
        assert!((1..12).all(|d| left(f64::from(d), p) < left(f64::from(d - 1), p)));
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
