//! What holds for a plant whatever it is driven with: friction laws, momentum, energy, symmetry.

use dct_driveline::Params;
use dct_driveline::friction::FrictionCurve;
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::{C, D, State};
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{ClutchState, Input, InputRate, Output, Plant};

const GEAR: [i32; 2] = [1, 2];
const H: f64 = 1e-3;

/// Inputs that drive both clutches through every state: frequencies [rad/s] without a common period.
fn busy_input(time: f64) -> Input {
    let wave = |omega: f64, phase: f64| (omega * time + phase).sin();
    Input {
        t_e: 40.0 + 120.0 * wave(3.1, 0.0),
        force: [
            (4000.0 * wave(1.7, 0.3)).max(0.0),
            (4000.0 * wave(2.3, 2.0)).max(0.0),
        ],
        gear: GEAR,
        t_brake: (400.0 * wave(0.9, 4.0)).max(0.0),
        phi: 0.05 * wave(0.4, 0.0),
    }
}

/// Runs `seconds` of the busy inputs; `seen` gets every step's input and output.
fn busy_run(p: &Params, swap: bool, seconds: u32, mut seen: impl FnMut(&Input, &Output)) -> Plant {
    let mut propagators = Propagators::new(p, GEAR, H);
    let input = |k: u32| {
        let mut input = busy_input(f64::from(k) * H);
        if swap {
            input.force.swap(0, 1);
        }
        input
    };
    let mut plant = Plant::start(p, &input(0), 120.0, 1.0);
    for k in 0..seconds * 1000 {
        plant.step(p, &mut propagators, &input(k), &InputRate::default());
        seen(
            &input(k),
            &plant.outputs(p, &propagators.systems, &input(k)),
        );
    }
    plant
}

/// Compliant and rigid, with gears that lose power, and with friction that varies with slip.
fn variants() -> [Params; 5] {
    let rigid = Params {
        rigid: true,
        ..Params::TABLE_1
    };
    let mut curved = Params::TABLE_1;
    for (clutch, first) in curved.clutch.iter_mut().zip([1.1, 0.9]) {
        clutch.curve = FrictionCurve {
            slip: [0.0, 6.0, 20.0, 60.0, 150.0],
            factor: [first, 1.0, 0.95, 1.0, 0.7],
        };
    }
    let lossy = |p: Params| {
        let mut p = p;
        (p.eta[0][0], p.eta[1][0]) = (0.94, 0.9);
        p
    };
    [
        Params::TABLE_1,
        rigid,
        curved,
        lossy(Params::TABLE_1),
        lossy(rigid),
    ]
}

#[test]
fn every_clutch_obeys_its_friction_law() {
    for p in variants() {
        let mut visits = [[0; 3]; 2];
        busy_run(&p, false, 30, |input, y| {
            for i in [0, 1] {
                let reach = input.force[i] * p.clutch[i].r_c_n;
                let torque = y.t_c[i].abs();
                match y.state[i] {
                    ClutchState::Disengaged => assert_eq!(y.t_c[i], 0.0),
                    ClutchState::Slipping => {
                        let factor = p.clutch[i].curve.at(y.slip[i].abs()).0;
                        let friction = p.clutch[i].mu_k * factor * reach;
                        assert!((torque - friction).abs() <= 1e-12 * torque);
                    }
                    ClutchState::Engaged => {
                        assert!(torque <= p.clutch[i].mu_s * reach * (1.0 + 1e-9));
                        assert_eq!(y.slip[i], 0.0);
                    }
                }
                assert!(y.friction_power[i] >= -1e-9, "{} W", y.friction_power[i]);
                visits[i][y.state[i] as usize - 1] += 1;
            }
        });
        assert!(
            visits.as_flattened().iter().all(|count| *count > 100),
            "{visits:?}"
        );
    }
}

#[test]
fn energy_balances_over_a_run() {
    for p in variants() {
        let (mut turnover, mut residual) = (0.0, 0.0_f64);
        let plant = busy_run(&p, false, 30, |input, y| {
            turnover += H * ((input.t_e * y.omega_e).abs() + (y.t_v * y.omega_w).abs());
            residual = residual.max(y.energy_residual.abs());
        });
        assert!(residual < 1e-6 * turnover, "{residual} J of {turnover} J");
        assert!(
            plant.work.friction.iter().all(|work| *work > 0.0),
            "{:?}",
            plant.work
        );
        assert!(plant.work.viscous > 0.0);
    }
}

/// A stop in neutral on a level road without any other resistance: the brake takes what was stored.
#[test]
fn the_brake_takes_the_energy_of_a_stop() {
    let mut p = Params::TABLE_1;
    (p.road.c_rr, p.road.c_drag) = (0.0, 0.0);
    let propagators = Propagators::new(&p, [0, 0], H);
    let mut plant = Plant::start(&p, &Input::default(), 0.0, 10.0);
    let stored =
        |plant: &Plant, propagators: &Propagators| propagators.systems.stored_energy(&plant.x);
    let (before, mut sum) = (stored(&plant, &propagators), 0.0);
    for k in 0..3000_u32 {
        let time = f64::from(k) * H;
        let input = Input {
            t_brake: 2000.0 * (1.0 - (3.0 * time).cos()),
            ..Input::default()
        };
        let rate = InputRate {
            t_brake: 6000.0 * (3.0 * (time + 0.5 * H)).sin(),
            ..InputRate::default()
        };
        let power = |plant: &Plant, input: &Input| {
            plant.outputs(&p, &propagators.systems, input).brake_power
        };
        let start = power(&plant, &input);
        plant.step(&p, &mut propagators.clone(), &input, &rate);
        sum += 0.5 * H * (start + power(&plant, &input.after(&rate, H)));
    }
    let y = plant.outputs(&p, &propagators.systems, &Input::default());
    assert_eq!(y.omega_w, 0.0);
    let spent = before - stored(&plant, &propagators) - plant.work.viscous;
    assert!(y.brake_energy > 0.99 * before, "{} J", y.brake_energy);
    assert!((y.brake_energy - spent).abs() < 1e-9 * before, "{spent} J");
    // Trapezoids of 1 ms, one of which holds the stop.
    assert!((y.brake_energy - sum).abs() < 1e-4 * before, "{sum} J");
}

/// Angular momentum at the engine and at the gearbox side of a clutch that locks up [N·m·s].
#[test]
fn lock_up_keeps_speed_and_momentum() {
    let p = Params::TABLE_1;
    let input = Input {
        t_e: 60.0,
        force: [3000.0, 0.0],
        gear: GEAR,
        ..Input::default()
    };
    let mut propagators = Propagators::new(&p, GEAR, H);
    let mut plant = Plant::start(&p, &input, 120.0, 1.0);
    let mut before = plant;
    while plant.modes[0] != Mode::Stuck {
        before = plant;
        plant.step(&p, &mut propagators, &input, &InputRate::default());
    }
    let bound = |x: &State| {
        let v = [
            60.0,
            p.clutch[0].mu_s * 3000.0 * p.clutch[0].r_c_n,
            0.0,
            0.0,
        ];
        2.0 * H
            * propagators.systems.by_stuck[0]
                .derivative(x, &v.into())
                .amax()
    };
    let jump = (plant.x - before.x).amax();
    assert!(jump < bound(&before.x), "{jump} rad/s in one step");
    assert_eq!(plant.slip()[0], 0.0);
    assert!((plant.x[D] - plant.x[C]).abs() < 1e-12);
    let residual = plant.energy_residual(&propagators.systems).abs();
    assert!(
        residual < 1e-9 * plant.work.engine,
        "{residual} J lost at lock-up"
    );
}

/// A slip removed by an impulse leaves the momentum of the two sides together as it was.
#[test]
fn impulse_in_a_clutch_keeps_momentum() {
    for p in variants() {
        let systems = dct_driveline::matrices::Systems::new(&p, GEAR);
        let g = p.g(GEAR);
        let mut x = State::zeros();
        (x[D], x[4], x[C], x[C + 1]) = (100.0, 5.0, 5.0 * g[0], 5.0 * g[1]);
        let mut after = x;
        dct_driveline::plant::modes::project(&systems, 1, &mut after);
        let moved = after - x;
        let gearbox = if p.rigid {
            p.j_out(g) / g[0] * moved[4]
        } else {
            p.j_ct[0] * moved[C]
        };
        assert!((p.j_d * moved[D] + gearbox).abs() < 1e-12, "{moved}");
        assert!((after[D] - after[C]).abs() < 1e-12);
    }
}

/// The engine drives the vehicle backwards through a reverse gear, with the energy balance closed.
#[test]
fn a_reverse_gear_drives_backwards() {
    for rigid in [false, true] {
        let p = Params {
            rigid,
            ..Params::DRY_7
        };
        let input = Input {
            t_e: 60.0,
            force: [0.0, 1500.0],
            gear: [1, Params::REVERSE],
            ..Input::default()
        };
        let mut propagators = Propagators::new(&p, input.gear, H);
        let mut plant = Plant::start(&p, &input, 120.0, 0.0);
        for _ in 0..3000 {
            plant.step(&p, &mut propagators, &input, &InputRate::default());
        }
        let y = plant.outputs(&p, &propagators.systems, &input);
        let ratio = y.omega_c[1] / y.omega_o;
        assert!(y.vehicle_speed < -2.0, "{} m/s", y.vehicle_speed);
        assert_eq!(y.state[1], ClutchState::Engaged);
        assert!((ratio / p.g(input.gear)[1] - 1.0).abs() < 1e-3, "{ratio}");
        let residual = y.energy_residual.abs();
        assert!(residual < 1e-9 * plant.work.engine, "{residual} J");
    }
}

/// The same vehicle with its two clutches and shafts swapped.
fn mirrored(p: &Params) -> Params {
    let mut mirror = *p;
    mirror.j_ct.swap(0, 1);
    mirror.k_t.swap(0, 1);
    mirror.c_t.swap(0, 1);
    mirror.i_t.swap(0, 1);
    mirror.i_f.swap(0, 1);
    mirror.eta.swap(0, 1);
    mirror.clutch.swap(0, 1);
    mirror
}

#[test]
fn swapped_clutches_mirror_the_result() {
    for p in variants() {
        let (mut straight, mut swapped) = (Vec::new(), Vec::new());
        busy_run(&p, false, 10, |_, y| straight.push(*y));
        busy_run(&mirrored(&p), true, 10, |_, y| swapped.push(*y));
        for (a, b) in straight.iter().zip(&swapped) {
            assert_eq!([a.state[1], a.state[0]], b.state);
            assert!(
                (a.omega_e - b.omega_e).abs() < 1e-7,
                "{} {}",
                a.omega_e,
                b.omega_e
            );
            assert!((a.t_o - b.t_o).abs() < 1e-5, "{} {}", a.t_o, b.t_o);
            for i in [0, 1] {
                assert!((a.t_c[i] - b.t_c[1 - i]).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn one_step_equals_two_halves() {
    let p = Params::TABLE_1;
    let mut whole = Propagators::new(&p, GEAR, 2.0 * H);
    let mut half = Propagators::new(&p, GEAR, H);
    let input = Input {
        t_e: 50.0,
        force: [900.0, 0.0],
        gear: GEAR,
        ..Input::default()
    };
    let rate = InputRate {
        t_e: 200.0,
        force: [5e3, 0.0],
        ..InputRate::default()
    };
    let mut one = Plant::start(&p, &input, 150.0, 5.0);
    let mut two = one;
    one.step(&p, &mut whole, &input, &rate);
    two.step(&p, &mut half, &input, &rate);
    two.step(&p, &mut half, &input.after(&rate, H), &rate);
    assert!((one.x - two.x).amax() < 1e-7, "{}", one.x - two.x);
}

#[test]
fn a_step_is_a_function_of_state_and_input_alone() {
    let p = Params::TABLE_1;
    let run = || busy_run(&p, false, 5, |_, _| ());
    assert_eq!(run(), run());
}
