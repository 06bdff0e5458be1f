//! Gears that lose power: what is left of the torque, which way power flows, and gears that jam.

use dct_driveline::Params;
use dct_driveline::coupling::Coupling;
use dct_driveline::integrate::{Propagators, TICKS};
use dct_driveline::matrices::{O, State, Systems, Torques, W, slip};
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{Input, InputRate, Output, Plant};

const H: f64 = 1e-3;
/// What T_v of (11), a ramp over a step, leaves of 10 ms [rad/s]: second order.
const BY_LOAD: f64 = 2e-4;
const ETA: [f64; 2] = [0.94, 0.9];
/// Gear 1 behind clutch 1, the even shaft in neutral.
const DRIVE: Input = Input {
    t_e: 60.0,
    force: [4000.0, 0.0],
    gear: [1, 0],
    t_brake: 0.0,
    phi: 0.0,
};

fn lossy() -> Params {
    let mut p = Params::TABLE_1;
    (p.eta[0][0], p.eta[1][0]) = (ETA[0], ETA[1]);
    p
}

/// A plant in gear at `omega_e` [rad/s], after `steps` of 1 ms.
fn driven(p: &Params, input: &Input, omega_e: f64, steps: u32) -> (Plant, Output) {
    let v = omega_e / p.g(input.gear)[0] * p.road.r_w;
    let mut propagators = Propagators::new(p, input.gear, H);
    let mut plant = Plant::start(p, input, omega_e, v);
    for _ in 0..steps {
        plant.step(p, &mut propagators, input, &InputRate::default());
    }
    let residual = plant.energy_residual(&propagators.systems);
    assert!(residual.abs() < 1e-9 * plant.work.engine.abs().max(plant.stored_at_start));
    let y = plant.outputs(p, &propagators.systems, input);
    (plant, y)
}

/// T_o + J_o ω̇_o is what reaches the output; when the swing is over its acceleration is the vehicle's.
#[test]
fn a_gear_takes_its_share_of_the_torque_in_either_direction() {
    let p = lossy();
    for (t_e, factor, power) in [(60.0, ETA[0], 1), (-40.0, 1.0 / ETA[0], -1)] {
        let (plant, y) = driven(&p, &Input { t_e, ..DRIVE }, 200.0, 1500);
        let reached = y.t_o + p.j_o * y.vehicle_acceleration / p.road.r_w;
        let share = reached / (p.i_f[0] * y.t_t[0]);
        assert!((share / factor - 1.0).abs() < 1e-4, "{t_e}: {share}");
        assert_eq!(plant.coupling().power, [power, 0]);
    }
}

/// At any instant what is lost beside the dampers is what a gear does not pass on, either way.
#[test]
fn the_power_lost_is_what_does_not_arrive() {
    let p = lossy();
    let x = State::from([
        200.0, 198.0, 190.0, 150.0, 10.5, 10.4, 0.03, 2e-3, -1e-3, 0.05,
    ]);
    let v = Torques::from([60.0, 40.0, -25.0, 300.0]);
    for power in [[1, -1], [-1, 1], [1, 0], [-1, -1]] {
        let coupling = Coupling {
            power,
            ..Coupling::from([1, 2])
        };
        let systems = Systems::new(&p, coupling);
        let x_dot = systems.by_stuck[0].derivative(&x, &v);
        let stored = systems.storage.component_mul(&x).dot(&x_dot);
        let [one, two] = slip(&x);
        let given = v[0] * x[0] - v[1] * one - v[2] * two - v[3] * x[W];
        let lost = systems.power_lost(0, &x, &v);
        assert!(
            (given - stored - lost).abs() < 1e-9 * given.abs(),
            "{power:?}"
        );
        let dampers = Systems::new(&p, [1, 2]).power_lost(0, &x, &v);
        let [_, t_t @ .., _] = systems.spring_torques(&x);
        let share = |i: usize| match power[i] {
            1 => 1.0 - ETA[i],
            -1 => 1.0 - 1.0 / ETA[i],
            _ => 0.0,
        };
        let of = |i: usize| p.i_f[i] * t_t[i] * x[O] * share(i);
        assert!((lost - dampers - of(0) - of(1)).abs() < 1e-9 * lost.abs());
    }
}

/// The brake holds the wheels and the engine winds up the drive shaft: once the output has swung, the gear
/// jams where it comes to rest, at any torque between η and 1/η of the shaft's.
#[test]
fn an_output_that_comes_to_rest_under_load_is_jammed() {
    let p = lossy();
    let input = Input {
        t_brake: 5000.0,
        force: [1500.0, 0.0],
        ..DRIVE
    };
    let mut propagators = Propagators::new(&p, input.gear, H);
    let mut plant = Plant::start(&p, &input, 200.0, 0.0);
    assert_eq!(plant.meshes.output, Mode::Stuck);
    let mut seen = Vec::new();
    for _ in 0..1000 {
        let held = InputRate::default();
        plant.step_observed(&p, &mut propagators, &input, &held, |_, _, after| {
            if seen.last() != Some(&after[5]) {
                seen.push(after[5]);
            }
        });
    }
    assert!(seen.contains(&Mode::Forward), "{seen:?}");
    assert_eq!((plant.meshes.output, plant.x[O]), (Mode::Stuck, 0.0));
    let y = plant.outputs(&p, &propagators.systems, &input);
    let share = y.t_o / (p.i_f[0] * y.t_t[0]);
    assert!((ETA[0]..=1.0 / ETA[0]).contains(&share), "{share}");
    assert!(y.t_o > 100.0 && y.held, "{y:?}");
}

/// A shaft whose torque passes zero bends, and the other matrices take over where it does.
#[test]
fn steps_of_any_size_find_the_same_bend() {
    let p = lossy();
    let tip_out = |steps: u32| {
        let h = 0.4 / f64::from(steps);
        let mut propagators = Propagators::new(&p, DRIVE.gear, h);
        let v = 200.0 / p.g(DRIVE.gear)[0] * p.road.r_w;
        let mut plant = Plant::start(&p, &DRIVE, 200.0, v);
        for k in 0..steps {
            let t_e = if k < steps / 2 { 60.0 } else { -40.0 };
            let input = Input { t_e, ..DRIVE };
            plant.step(&p, &mut propagators, &input, &InputRate::default());
        }
        plant.x
    };
    let (fine, coarse) = (tip_out(4000), tip_out(40));
    let apart = (fine - coarse).amax();
    assert!(apart < BY_LOAD, "{apart} rad/s");
}

/// A shift with its synchronisation, driven in gear 1 and then in gear 2; the state in the end.
fn shifted(p: &Params) -> State {
    let start = Input {
        t_e: 60.0,
        force: [4000.0, 0.0],
        gear: [1, 0],
        ..Input::default()
    };
    let mut propagators = Propagators::new(p, start.gear, H);
    let mut plant = Plant::start(p, &start, 180.0, 180.0 / p.g([1, 0])[0] * p.road.r_w);
    for k in 0..1600 {
        let time = f64::from(k) * H;
        let input = Input {
            t_e: if time < 0.6 { 60.0 } else { -20.0 },
            force: [
                (4000.0 * (1.0 - time / 0.5)).max(0.0),
                (8000.0 * (time - 0.4)).max(0.0),
            ],
            gear: [
                if time < 0.7 { 1 } else { 0 },
                if time < 0.1 { 0 } else { 2 },
            ],
            ..start
        };
        plant.step(p, &mut propagators, &input, &InputRate::default());
    }
    assert_eq!((plant.modes[1], plant.gear_in()), (Mode::Stuck, [0, 2]));
    let residual = plant.energy_residual(&propagators.systems);
    assert!(
        residual.abs() < 1e-9 * plant.stored_at_start,
        "{residual} J"
    );
    plant.x
}

/// Shafts a hundred times as stiff are a tenth as far from rigid ones in the end: their swings die out.
#[test]
fn rigid_gears_lose_what_very_stiff_ones_do() {
    let stiff = |factor: f64| {
        let mut p = lossy();
        p.k_t = p.k_t.map(|k_t| factor * k_t);
        p.c_t = p.c_t.map(|c_t| factor.sqrt() * c_t);
        shifted(&p)
    };
    let rigid = shifted(&Params {
        rigid: true,
        ..lossy()
    });
    let apart = |x: State| [0, W].map(|i| (x[i] - rigid[i]).abs());
    let ([engine, wheel], near) = (apart(stiff(1.0)), apart(stiff(100.0)));
    println!("{engine} {wheel} {near:?}");
    assert!(near[0] < 0.1 * engine && near[1] < 0.1 * wheel, "{near:?}");
}

/// Strains a tie of rigid gears with efficiency `eta` by an engine torque that begins `phase` [s] after the start and
/// rises by 1 N·m/ms, in steps of `h` [s]; the instant at which a clutch slips [s], and the state after 0.15 s.
fn strained(force: [f64; 2], eta: f64, phase: f64, h: f64) -> (f64, State) {
    const RISE: f64 = 1000.0;
    let mut p = Params::TABLE_1;
    (p.rigid, p.eta) = (true, [[eta; 4]; 2]);
    let at = |time: f64| Input {
        t_e: RISE * (time - phase),
        force,
        gear: [1, 2],
        ..DRIVE
    };
    let rate = InputRate {
        t_e: RISE,
        ..InputRate::default()
    };
    let mut propagators = Propagators::new(&p, [1, 2], h);
    let mut plant = Plant::start(&p, &at(0.0), 0.0, 0.0);
    let mut left = f64::INFINITY;
    let mut time = 0.0;
    while time < 0.15 - 1e-9 {
        plant.step_observed(&p, &mut propagators, &at(time), &rate, |since, _, modes| {
            if modes[..2] != [Mode::Stuck; 2] {
                left = left.min(time + since);
            }
        });
        time += h;
    }
    (left, plant.x)
}

/// A tie that stands because no motion is consistent moves when one is, not at the start of the next step: that was up to
/// 6.8 ms late and cost 0.76 rad/s.
#[test]
fn a_strained_tie_breaks_at_one_instant_in_steps_of_any_size() {
    /// What T_v of (11), bent where the wheels begin to turn, leaves of 10 ms [rad/s].
    const APART: f64 = 2e-3;
    let (coarse, fine) = (1e-2, 1e-4);
    for force in [[4000.0, 1000.0], [1000.0, 4000.0]] {
        for (eta, phase) in [0.8, 0.9, 0.97]
            .into_iter()
            .flat_map(|eta| (0..10).map(move |k| (eta, 1e-3 * f64::from(k))))
        {
            let (late, end) = strained(force, eta, phase, coarse);
            let (found, other) = strained(force, eta, phase, fine);
            let at = format!("{force:?} N, η {eta}, {phase} s: {late} {found} s");
            assert!((0.03..0.1).contains(&found), "{at}");
            assert!((late - found).abs() < coarse / f64::from(TICKS), "{at}");
            assert!((end - other).amax() < APART, "{at}: {end} {other}");
        }
    }
}
