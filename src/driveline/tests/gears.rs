//! Gears that go out, are synchronised and come in while the plant runs.

#![allow(clippy::panic, reason = "helpers of tests")]

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::{C, O};
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{Input, InputRate, Plant};

const H: f64 = 1e-3;
const TWO_ODD_GEARS: [f64; 4] = [3.0, 1.4, 0.0, 0.0];
const DRIVE: Input = Input {
    t_e: 50.0,
    force: [3000.0, 0.0],
    gear: [1, 0],
    t_brake: 0.0,
    phi: 0.0,
};
const COAST: Input = Input {
    t_e: 0.0,
    force: [0.0; 2],
    ..DRIVE
};

/// Compliant, rigid, with friction that varies with the slip, with gears that have inertia, that lose power.
fn variants() -> [Params; 5] {
    let [mut plain, mut rigid, mut fades, mut heavy, mut lossy] = [Params::TABLE_1; 5];
    for p in [&mut plain, &mut rigid, &mut fades, &mut heavy, &mut lossy] {
        p.i_t[0] = TWO_ODD_GEARS;
    }
    rigid.rigid = true;
    for clutch in &mut fades.clutch {
        clutch.curve.slip = [0.0, 50.0, 100.0, 200.0, 400.0];
        clutch.curve.factor = [1.1, 1.0, 0.9, 0.8, 0.7];
    }
    heavy.j_gear = [[0.02, 0.05, 0.0, 0.0], [0.03, 0.0, 0.0, 0.0]];
    lossy.eta = [[0.95, 0.97, 1.0, 1.0], [0.96, 1.0, 1.0, 1.0]];
    [plain, rigid, fades, heavy, lossy]
}

/// A run that can be gone on with.
struct Run {
    p: Params,
    plant: Plant,
    propagators: Propagators,
    /// Time since the start of the last call of [`Self::go`] at which modes changed [s].
    changes: Vec<(f64, [Mode; 6])>,
}

impl Run {
    fn new(p: &Params, input: &Input) -> Self {
        Self {
            p: *p,
            plant: Plant::start(p, input, 90.0, 90.0 / 18.0 * p.road.r_w),
            propagators: Propagators::new(p, input.gear, H),
            changes: Vec::new(),
        }
    }

    fn go(&mut self, input: &Input, steps: u32) -> &Plant {
        let (held, changes) = (InputRate::default(), &mut self.changes);
        changes.clear();
        for k in 0..steps {
            let propagators = &mut self.propagators;
            self.plant
                .step_observed(&self.p, propagators, input, &held, |after, old, new| {
                    if old != new {
                        changes.push((f64::from(k) * H + after, new));
                    }
                });
        }
        &self.plant
    }

    fn residual(&self) -> f64 {
        self.plant.energy_residual(&self.propagators.systems).abs()
    }

    fn difference(&self, shaft: usize) -> f64 {
        let g = self.p.g(self.plant.gear)[shaft];
        self.plant.x[C + shaft] - g * self.plant.x[O]
    }
}

/// The closed form of two inertias that a constant torque brings together, before the output's springs
/// have moved: the output is far heavier than the shaft.
#[test]
fn a_shaft_is_synchronised_by_its_torque() {
    for p in variants() {
        let heavy = Params { j_o: 1e5, ..p };
        let mut run = Run::new(
            &heavy,
            &Input {
                gear: [1, 0],
                ..COAST
            },
        );
        let omega_o = run.plant.x[O];
        run.go(
            &Input {
                gear: [1, 2],
                ..COAST
            },
            1000,
        );
        let lag = p.g([1, 2])[1] * omega_o;
        let [(start, begun), (end, done)] = run.changes[..] else {
            panic!("{:?}", run.changes)
        };
        assert_eq!(
            (begun[4], done[4], start),
            (Mode::Backward, Mode::Open, 0.0)
        );
        let expected = lag * p.j_ct[1] / p.t_s[1];
        assert!((end / expected - 1.0).abs() < 1e-3, "{end} s, {expected} s");
        let lost = 0.5 * p.j_ct[1] * lag * lag;
        let booked = run.plant.work.synchroniser;
        assert!((booked / lost - 1.0).abs() < 1e-3, "{booked} J, {lost} J");
    }
}

#[test]
fn a_gear_comes_in_with_the_energy_balance_closed() {
    for p in variants() {
        let mut run = Run::new(&p, &DRIVE);
        run.go(&DRIVE, 500);
        assert_eq!(run.plant.modes[0], Mode::Stuck);
        let to = Input {
            gear: [1, 2],
            ..DRIVE
        };
        run.go(&to, 20);
        assert_eq!(run.plant.gear_in(), [1, 0]);
        assert!(run.residual() < 1e-9 * run.plant.work.engine);
        run.go(&to, 500);
        assert_eq!(run.plant.gear_in(), [1, 2]);
        assert!(run.difference(1).abs() < 1.0);
        assert_eq!(run.plant.slip()[0], 0.0);
        assert!(run.plant.work.synchroniser > 0.0 && run.plant.work.friction[1] == 0.0);
        let residual = run.residual();
        assert!(residual < 1e-9 * run.plant.work.engine, "{residual} J");
    }
}

/// Nothing moves at the instant at which a gear goes out or comes in.
#[test]
fn speeds_do_not_jump() {
    for p in variants() {
        let mut run = Run::new(&p, &DRIVE);
        run.go(&DRIVE, 500);
        let shift = Input {
            gear: [1, 2],
            ..DRIVE
        };
        let mut before = *run.go(&DRIVE, 1);
        while run.plant.gear_in() != [1, 2] {
            let now = *run.go(&shift, 1);
            let jump = (now.x - before.x).amax();
            let torque = p.t_s[1] * p.g([1, 2])[1];
            assert!(jump < H * torque / p.j_o, "{jump} rad/s");
            assert!((now.x[C + 1] - before.x[C + 1]).abs() < 2.0 * H * p.t_s[1] / p.j_ct[1]);
            before = now;
        }
    }
}

#[test]
fn a_shaft_changes_between_two_of_its_gears_while_the_other_one_does() {
    for p in variants() {
        let both = Input {
            gear: [1, 2],
            ..COAST
        };
        let mut run = Run::new(&p, &both);
        run.go(&both, 100);
        let to = Input {
            gear: [3, 0],
            t_brake: 300.0,
            ..COAST
        };
        run.go(&to, 400);
        assert_eq!(run.plant.gear_in(), [3, 0]);
        let back = Input {
            gear: [1, 2],
            ..COAST
        };
        run.go(&back, 5);
        assert_eq!(run.plant.synchroniser, [Mode::Backward, Mode::Forward]);
        run.go(&back, 400);
        assert_eq!(run.plant.gear_in(), [1, 2]);
        assert!(run.residual() < 1e-9 * run.plant.stored_at_start);
    }
}

#[test]
fn a_shaft_keeps_its_gear_while_its_clutch_transmits() {
    let p = Params::TABLE_1;
    let mut run = Run::new(&p, &DRIVE);
    let plant = run.go(&DRIVE, 10);
    let (other, held) = (
        Input {
            gear: [3, 2],
            ..DRIVE
        },
        InputRate::default(),
    );
    assert_eq!(plant.gear_granted(&other, &held), [1, 2]);
    let pressed = Input {
        force: [3000.0, 1.0],
        ..other
    };
    assert_eq!(plant.gear_granted(&pressed, &held), [1, 0]);
}

/// A clutch that is pressed too early finds its shaft in neutral, and the shift starts anew later.
#[test]
fn a_clutch_that_is_pressed_too_early_stops_its_synchroniser() {
    for p in variants() {
        let mut run = Run::new(&p, &DRIVE);
        run.go(&DRIVE, 500);
        let shift = Input {
            gear: [1, 2],
            ..DRIVE
        };
        run.go(&shift, 10);
        let early = Input {
            force: [3000.0, 3000.0],
            ..shift
        };
        run.go(&early, 300);
        assert_eq!((run.plant.gear, run.plant.modes[1]), ([1, 0], Mode::Stuck));
        run.go(&shift, 10);
        assert_eq!(run.plant.synchroniser[1], Mode::Forward);
        run.go(&shift, 400);
        assert_eq!(run.plant.gear_in(), [1, 2]);
        assert!(run.residual() < 1e-9 * run.plant.work.engine);
    }
}

#[test]
fn standing_shafts_take_their_gears_at_once() {
    let p = Params::TABLE_1;
    let neutral = Input {
        gear: [0, 0],
        ..COAST
    };
    let mut plant = Plant::start(&p, &neutral, 90.0, 0.0);
    let mut propagators = Propagators::new(&p, neutral.gear, H);
    let gear = Input {
        gear: [1, 2],
        ..COAST
    };
    plant.step(&p, &mut propagators, &gear, &InputRate::default());
    assert_eq!(plant.gear_in(), [1, 2]);
}

/// What a gear adds while it is in is inertia of its shaft like any other.
#[test]
fn inertia_of_a_gear_turns_with_its_shaft() {
    for rigid in [false, true] {
        let p = Params {
            rigid,
            ..Params::TABLE_1
        };
        let (mut gear, mut shaft) = (p, p);
        (gear.j_gear[0][0], gear.j_r[1]) = (0.05, 7.0);
        shaft.j_ct[0] += 0.05;
        let [of_gear, of_shaft] = [gear, shaft].map(|p| {
            let mut run = Run::new(&p, &DRIVE);
            run.go(&DRIVE, 500);
            run.plant.outputs(&p, &run.propagators.systems, &DRIVE)
        });
        assert_eq!(of_gear, of_shaft);
        let mut run = Run::new(&p, &DRIVE);
        run.go(&DRIVE, 500);
        let light = run.plant.outputs(&p, &run.propagators.systems, &DRIVE);
        assert!(light.omega_w > of_gear.omega_w);
    }
}
