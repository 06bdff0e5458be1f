//! Clutches that get hot: energy goes into heat, friction fades, steps converge.

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{ClutchState, Input, InputRate, Output, Plant};
use dct_driveline::thermal::Thermal;

const GEAR: [i32; 2] = [1, 2];
const LAUNCH: Input = Input {
    t_e: 60.0,
    force: [2300.0, 400.0],
    gear: GEAR,
    t_brake: 0.0,
    phi: 0.0,
};

/// A lining so light that one launch halves its friction.
fn params(conductance: f64) -> Params {
    let mut p = Params::TABLE_1;
    for clutch in &mut p.clutch {
        clutch.thermal = Thermal {
            capacity: 15.0,
            conductance,
            ambient: 300.0,
            start: 0.0,
            temperature: [300.0, 400.0, 500.0, 600.0],
            factor: [1.0, 0.9, 0.7, 0.5],
        };
        clutch.specific_wear = 5e-14;
    }
    p
}

/// Runs the launch for `time` [s] in steps of `h` [s].
fn launch(p: &Params, h: f64, time: f64, mut seen: impl FnMut(&Output)) -> (Plant, Output) {
    let mut propagators = Propagators::new(p, GEAR, h);
    let mut plant = Plant::start(p, &LAUNCH, 120.0, 0.0);
    let mut y = plant.outputs(p, &propagators.systems, &LAUNCH);
    let mut done = 0.0;
    seen(&y);
    while done < time - 0.5 * h {
        plant.step(p, &mut propagators, &LAUNCH, &InputRate::default());
        y = plant.outputs(p, &propagators.systems, &LAUNCH);
        seen(&y);
        done += h;
    }
    (plant, y)
}

#[test]
fn without_cooling_every_joule_of_friction_is_heat() {
    let p = params(0.0);
    for h in [1e-2, 1e-3] {
        let (_, y) = launch(&p, h, 1.0, |y| {
            for i in [0, 1] {
                let thermal = &p.clutch[i].thermal;
                let heat = thermal.capacity * (y.temperature[i] - thermal.ambient);
                assert!((heat - y.friction_energy[i]).abs() < 1e-9 * (1.0 + heat));
            }
        });
        assert!(y.temperature[0] > 350.0, "{} K", y.temperature[0]);
        assert_eq!(y.wear[0], 5e-14 * y.friction_energy[0]);
        assert!(y.energy_residual.abs() < 1e-6 * y.friction_energy[0]);
    }
}

#[test]
fn what_is_not_stored_went_through_the_conductance() {
    let p = params(10.0);
    let (h, mut lost, mut last) = (1e-3, [0.0; 2], [300.0; 2]);
    let (_, y) = launch(&p, h, 3.0, |y| {
        for i in [0, 1] {
            lost[i] += h * 10.0 * (0.5 * (y.temperature[i] + last[i]) - 300.0);
        }
        last = y.temperature;
    });
    for i in [0, 1] {
        let stored = p.clutch[i].thermal.capacity * (y.temperature[i] - 300.0);
        let missing = y.friction_energy[i] - stored - lost[i];
        assert!(missing.abs() < 1e-5 * y.friction_energy[i], "{missing} J");
        assert!(lost[i] > 0.1 * y.friction_energy[i], "{lost:?} J");
    }
}

#[test]
fn a_hot_lining_slips_with_less_friction() {
    let (p, mut least) = (params(0.0), 1.0_f64);
    launch(&p, 1e-3, 1.0, |y| {
        for i in (0..2).filter(|i| y.state[*i] == ClutchState::Slipping) {
            let clutch = &p.clutch[i];
            let factor = clutch.thermal.at(y.temperature[i]).0;
            let friction = clutch.mu_k * factor * LAUNCH.force[i] * clutch.r_c_n;
            assert!((y.t_c[i].abs() - friction).abs() < 1e-9);
            least = least.min(factor);
        }
    });
    assert!(least < 0.8, "{least}");
}

/// Speeds and temperatures of the launch at one time while it slips, in steps of 4, 2, 1 ms and a fine one.
#[test]
fn fade_by_heat_converges_with_second_order() {
    let p = params(10.0);
    let end = |h: f64| {
        let (plant, y) = launch(&p, h, 0.32, |_| ());
        [
            plant.x[0],
            plant.x[1],
            plant.x[5],
            y.temperature[0],
            y.temperature[1],
        ]
    };
    let exact = end(6.25e-5);
    let misfit = |h: f64| {
        let found = end(h);
        [0, 1, 2, 3, 4]
            .map(|k| (found[k] - exact[k]).abs())
            .into_iter()
            .fold(0.0, f64::max)
    };
    let misfits = [4e-3, 2e-3, 1e-3].map(misfit);
    for pair in misfits.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order >= 1.8, "order {order} from {misfits:?}");
    }
}

#[test]
fn a_clutch_starts_as_hot_as_it_is_said_to_be() {
    let mut p = params(10.0);
    p.clutch[0].thermal.start = 550.0;
    let plant = Plant::start(&p, &LAUNCH, 120.0, 0.0);
    assert_eq!(plant.temperature, [550.0, 300.0]);
    let y = plant.outputs(&p, &Propagators::new(&p, GEAR, 1e-3).systems, &LAUNCH);
    let friction = p.clutch[0].mu_k * 0.6 * LAUNCH.force[0] * p.clutch[0].r_c_n;
    assert!((y.t_c[0] - friction).abs() < 1e-9, "{}", y.t_c[0]);
}

/// What the source of its heat capacity says of an engagement: 30 to 35 K.
#[test]
fn a_launch_warms_the_dry_lining_of_the_preset_as_measured() {
    let (p, force) = (Params::DRY_7_FADE, 2500.0);
    let input = Input {
        t_e: p.clutch[0].mu_k * p.clutch[0].r_c_n * force,
        force: [force, 0.0],
        gear: [1, 2],
        ..Input::default()
    };
    let mut propagators = Propagators::new(&p, input.gear, 1e-3);
    let mut plant = Plant::start(&p, &input, 157.0, 0.0);
    let (mut hottest, mut steps) = (0.0_f64, 0);
    while plant.modes[0] != Mode::Stuck && steps < 3000 {
        plant.step(&p, &mut propagators, &input, &InputRate::default());
        (hottest, steps) = (hottest.max(plant.temperature[0]), steps + 1);
    }
    let warmer = hottest - p.clutch[0].thermal.ambient;
    println!("{warmer} K by {} J in {steps} ms", plant.work.friction[0]);
    assert_eq!(plant.modes[0], Mode::Stuck);
    assert!((30.0..35.0).contains(&warmer), "{warmer} K");
}
