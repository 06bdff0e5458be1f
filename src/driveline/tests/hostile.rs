//! Parameters, inputs and measurements that make no sense: calls come back, and nothing panics.

use dct_driveline::Params;
use dct_driveline::control::{Demand, Servo, Tuning};
use dct_driveline::integrate::Propagators;
use dct_driveline::observer::{Method, Observer, Sample, Selected, Settings};
use dct_driveline::plant::{Input, InputRate, Plant};

const H: f64 = 1e-3;
const NUMBERS: [f64; 10] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    0.0,
    -1.0,
    1e-300,
    1e150,
];

/// Puts a number somewhere.
type Spoil<T> = fn(&mut T, f64);

const PARAMS: [Spoil<Params>; 29] = [
    |p, x| p.j_e = x,
    |p, x| p.j_d = x,
    |p, x| p.k_d = x,
    |p, x| p.c_d = x,
    |p, x| p.j_ct = [x; 2],
    |p, x| p.k_t[0] = x,
    |p, x| p.c_t[1] = x,
    |p, x| p.i_t[0] = [x; 4],
    |p, x| p.i_t[1] = [x; 4],
    |p, x| p.j_gear[0] = [x; 4],
    |p, x| p.eta[1] = [x; 4],
    |p, x| p.t_s = [x; 2],
    |p, x| p.i_f = [x; 2],
    |p, x| p.j_o = x,
    |p, x| p.k_o = x,
    |p, x| p.c_o = x,
    |p, x| p.j_v = x,
    |p, x| p.clutch[0].mu_k = x,
    |p, x| p.clutch[0].mu_s = x,
    |p, x| p.clutch[0].curve.slip[4] = x,
    |p, x| p.clutch[0].thermal.capacity = x,
    |p, x| p.clutch[1].r_c_n = x,
    |p, x| p.clutch[0].map.position[3] = x,
    |p, x| p.clutch[0].map.force[9] = x,
    |p, x| p.clutch[1].piston_area = x,
    |p, x| p.road.m_v = x,
    |p, x| p.road.r_w = x,
    |p, x| p.road.c_drag = x,
    |p, x| p.road.v_eps = x,
];

const SETTINGS: [Spoil<Settings>; 10] = [
    |s, x| s.mu_n[0] = x,
    |s, x| s.gains.l_11 = x,
    |s, x| s.gains.l_c = [x; 2],
    |s, x| s.lyapunov.l_22 = x,
    |s, x| s.lyapunov.p_3 = x,
    |s, x| s.energy.l_c = x,
    |s, x| s.calibrating.sensor = x,
    |s, x| s.calibrating.sigma[0] = x,
    |s, x| s.calibrating.friction[0] = [x; 5],
    |s, x| s.encoder = [x; 4],
];

const SAMPLES: [Spoil<Sample>; 9] = [
    |s, x| s.t_e = x,
    |s, x| s.omega_e = x,
    |s, x| s.omega_c[0] = x,
    |s, x| s.omega_w = x,
    |s, x| s.actuation[0].position = x,
    |s, x| s.actuation[1].pressure = x,
    |s, x| s.t_brake = x,
    |s, x| s.phi = x,
    |s, x| s.t_y = x,
];

/// Two clutches, of which one slips and one is pressed home.
fn sample() -> Sample {
    let mut sample = Sample {
        t_e: 60.0,
        omega_e: 200.0,
        omega_c: [180.0, 200.0],
        omega_w: 10.0,
        gear: [1, 2],
        ..Sample::default()
    };
    sample.actuation[0].position = 5e-3;
    sample.actuation[1].position = 9e-3;
    sample
}

/// Takes `ordinary`, each of `spoils` with each of the numbers in it, and lets `run` have it.
fn for_each<T: Clone>(ordinary: &T, spoils: &[Spoil<T>], mut run: impl FnMut(&T)) {
    for spoil in spoils {
        for number in NUMBERS {
            let mut spoiled = ordinary.clone();
            spoil(&mut spoiled, number);
            run(&spoiled);
        }
    }
}

fn observe(p: &Params, settings: &Settings, first: &Sample, then: &Sample) {
    for method in Method::ALL {
        let mut observer = Selected::new(method);
        observer.start(p, settings, first);
        for sample in [first, then, then, first] {
            observer.step(p, settings, sample, H);
        }
    }
}

fn drive(p: &Params, input: &Input) {
    for rigid in [false, true] {
        let p = Params { rigid, ..*p };
        let mut propagators = Propagators::new(&p, input.gear, H);
        let mut plant = Plant::start(&p, input, 200.0, 3.0);
        for _ in 0..3 {
            plant.step(&p, &mut propagators, input, &InputRate::default());
            plant.outputs(&p, &propagators.systems, input);
        }
    }
}

#[test]
fn observers_come_back_from_whatever_they_are_given() {
    let (p, settings, good) = (Params::TABLE_1, Settings::CASE_1, sample());
    for_each(&p, &PARAMS, |p| observe(p, &settings, &good, &good));
    for_each(&settings, &SETTINGS, |s| observe(&p, s, &good, &good));
    for_each(&good, &SAMPLES, |bad| observe(&p, &settings, &good, bad));
    for_each(&good, &SAMPLES, |bad| observe(&p, &settings, bad, &good));
}

#[test]
fn the_plant_comes_back_from_whatever_it_is_given() {
    let force = [900.0, 8000.0];
    let good = Input {
        t_e: 60.0,
        force,
        gear: [1, 2],
        ..Input::default()
    };
    for_each(&Params::TABLE_1, &PARAMS, |p| drive(p, &good));
    let spoils: [Spoil<Input>; 4] = [
        |u, x| u.t_e = x,
        |u, x| u.force[0] = x,
        |u, x| u.t_brake = x,
        |u, x| u.phi = x,
    ];
    for_each(&good, &spoils, |bad| drive(&Params::TABLE_1, bad));
}

#[test]
fn clutch_control_comes_back_and_stays_a_number() {
    let tuning = Tuning {
        rate: 0.2,
        stroke: [0.0, 9e-3],
        torque_gain: Tuning::TORQUE_GAIN,
        damping: 0.01,
    };
    let demand = Demand {
        request: 50.0,
        slip: 20.0,
        mu: 0.26,
        torque: Some(40.0),
        t_o_rate: 10.0,
    };
    let run = |tuning: &Tuning, demand: &Demand| {
        let clutch = &Params::TABLE_1.clutch[0];
        let mut servo = Servo::start(clutch, tuning, demand);
        servo.step(clutch, tuning, demand, H);
        servo.step(clutch, tuning, demand, H);
        servo
    };
    let spoils: [Spoil<Tuning>; 4] = [
        |t, x| t.rate = x,
        |t, x| t.stroke = [x, 9e-3],
        |t, x| t.torque_gain = x,
        |t, x| t.damping = x,
    ];
    for_each(&tuning, &spoils, |bad| {
        run(bad, &demand);
    });
    let spoils: [Spoil<Demand>; 5] = [
        |d, x| d.request = x,
        |d, x| d.slip = x,
        |d, x| d.mu = x,
        |d, x| d.torque = Some(x),
        |d, x| d.t_o_rate = x,
    ];
    for_each(&demand, &spoils, |bad| {
        let position = run(&tuning, bad).position;
        assert!((0.0..=9e-3).contains(&position), "{bad:?}: {position} m");
    });
}
