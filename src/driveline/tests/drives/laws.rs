//! What holds for a plant whatever it is driven with, on inputs by chance: capacities, signs of slips, events,
//! standstill under the brake, energy; and that a long step is many short ones.

use crate::bench::sensors::Random;
use dct_driveline::friction::FrictionCurve;
use dct_driveline::integrate::Propagators;
use dct_driveline::params::{Params, RoadParams};
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{ClutchState, Input, InputRate, Output, Plant};

/// Round-off of a capacity [1], and of a slip that an engaged clutch leaves in the state [rad/s].
const ROUND_OFF: f64 = 1e-9;
/// Energy that does not close, of what engine, load and brake turned over [1].
const UNBALANCED: f64 = 1e-9;
/// What is told as a change: time within the step [s], modes before and after.
type Change = (f64, [Mode; 6], [Mode; 6]);

impl Random {
    fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.between(0.0, all.len() as f64) as usize]
    }

    /// Inputs that jump: an open clutch, a closed one and anything between are as likely; forces of a box whose
    /// clutches carry up to `most` [N].
    fn input(&mut self, last: &Input, most: f64) -> Input {
        let force = [0, 1].map(|_| match self.of(&[0, 1, 2, 2]) {
            0 => 0.0,
            1 => most,
            _ => self.between(0.0, 0.5 * most),
        });
        let gear = if self.chance(0.15) {
            [self.of(&[0, 1, 3]), self.of(&[0, 2, 4])]
        } else {
            last.gear
        };
        Input {
            t_e: self.between(-60.0, 180.0),
            force,
            gear,
            t_brake: if self.chance(0.3) {
                self.between(0.0, 1500.0)
            } else {
                0.0
            },
            phi: self.between(-0.1, 0.1),
        }
    }

    /// Slopes over a step of `h` [s] that leave no force and no brake torque below zero.
    fn rate(&mut self, input: &Input, h: f64) -> InputRate {
        if self.chance(0.7) {
            return InputRate::default();
        }
        let mut ramp = |value: f64, reach: f64| self.between(-value.min(reach), reach) / h;
        InputRate {
            t_e: ramp(40.0, 40.0),
            force: input
                .force
                .map(|force| if force > 0.0 { ramp(force, 400.0) } else { 0.0 }),
            t_brake: ramp(input.t_brake, 100.0),
            phi: 0.0,
        }
    }
}

/// Boxes whose clutches carry up to so much [N].
fn boxes() -> [(&'static str, Params, f64); 7] {
    let mut rigid = Params::TABLE_1;
    rigid.rigid = true;
    let mut curved = Params::TABLE_1;
    for clutch in &mut curved.clutch {
        clutch.curve = FrictionCurve {
            slip: [0.0, 6.0, 20.0, 60.0, 150.0],
            factor: [1.1, 1.0, 0.95, 1.0, 0.7],
        };
    }
    let lossy = |mut p: Params| {
        p.eta = [[0.94, 0.96, 1.0, 1.0], [0.9, 0.95, 1.0, 1.0]];
        p
    };
    let gears = |mut p: Params| {
        (p.i_t[0][1], p.i_t[1][1]) = (1.4, 1.1);
        p
    };
    [
        ("paper", gears(Params::TABLE_1), 8000.0),
        ("rigid", gears(rigid), 8000.0),
        ("curved", gears(curved), 8000.0),
        ("lossy", gears(lossy(Params::TABLE_1)), 8000.0),
        ("lossy, rigid", gears(lossy(rigid)), 8000.0),
        ("wet6_fade", Params::WET_6_FADE, 2000.0),
        ("dry7_fade", Params::DRY_7_FADE, 4000.0),
    ]
}

/// A drive by chance of `steps` steps of `h` [s]; `seen` gets the plant before each, its inputs, and what came of it.
fn drive(
    p: &Params,
    most: f64,
    (seed, h, steps): (u64, f64, u32),
    mut seen: impl FnMut(&Plant, &Input, &InputRate, &Plant, &Output, &[Change]),
) {
    let mut random = Random(seed);
    let gear = [random.of(&[1, 3]), random.of(&[2, 4])];
    let idle = Input {
        gear,
        ..Input::default()
    };
    let mut input = random.input(&idle, most);
    let mut propagators = Propagators::new(p, input.gear, h);
    let mut plant = Plant::start(
        p,
        &input,
        random.between(80.0, 250.0),
        random.between(-3.0, 15.0),
    );
    for _ in 0..steps {
        if random.chance(0.02 + h) {
            input = random.input(&input, most);
        }
        let rate = random.rate(&input, h);
        let (before, mut changes) = (plant, Vec::new());
        plant.step_observed(p, &mut propagators, &input, &rate, |time, old, new| {
            changes.push((time, old, new));
        });
        let end = input.after(&rate, h);
        let y = plant.outputs(p, &propagators.systems, &end);
        seen(&before, &input, &rate, &plant, &y, &changes);
        input = end;
    }
}

/// Each clutch obeys its friction law and its mode tells the sign of its slip.
fn check_clutches(name: &str, p: &Params, end: &Input, plant: &Plant, y: &Output) {
    let slip = [0, 1].map(|i| plant.x[1] - plant.x[2 + i]);
    for i in [0, 1] {
        let clutch = &p.clutch[i];
        let warm = clutch.thermal.at(y.temperature[i]).0;
        let most = clutch.mu_s.max(clutch.mu_k * clutch.curve.at(0.0).0);
        let reach = end.force[i] * clutch.r_c_n * warm;
        match y.state[i] {
            ClutchState::Disengaged => assert_eq!(y.t_c[i], 0.0, "{name}"),
            ClutchState::Engaged => {
                // Static friction is held over a step in which the clutch cools or warms.
                let held = if clutch.thermal.is_on() {
                    1e-4
                } else {
                    ROUND_OFF
                };
                let (torque, peak) = (y.t_c[i].abs(), most * reach);
                assert!(
                    torque <= peak * (1.0 + held) + ROUND_OFF,
                    "{name}: {torque} of {peak}"
                );
                assert!(slip[i].abs() < ROUND_OFF, "{name}: {} rad/s", slip[i]);
            }
            ClutchState::Slipping => {
                let direction = plant.modes[i].direction();
                assert!(
                    direction * slip[i] > -ROUND_OFF,
                    "{name}: {} rad/s",
                    slip[i]
                );
                let friction = clutch.mu_k * clutch.curve.at(slip[i].abs()).0 * reach;
                let apart = (y.t_c[i] - direction * friction).abs();
                assert!(
                    apart <= ROUND_OFF * friction + ROUND_OFF,
                    "{name}: {apart} N·m"
                );
            }
        }
    }
}

/// Modes change at events alone, each from where the one before led to, in order, within the step.
fn check_events(name: &str, h: f64, before: &Plant, plant: &Plant, changes: &[Change]) {
    let (mut time, mut modes) = (0.0, before.all_modes());
    for (at, old, new) in changes {
        assert!(
            (time..=h * (1.0 + ROUND_OFF)).contains(at),
            "{name}: {at} s after {time} s"
        );
        assert_eq!(*old, modes, "{name}: {at} s");
        (time, modes) = (*at, *new);
    }
    assert_eq!(modes, plant.all_modes(), "{name}");
    for i in [0, 1] {
        let pressed = before.modes[i] != Mode::Open && plant.modes[i] != Mode::Open;
        let passed = pressed && before.slip()[i] * plant.slip()[i] < 0.0;
        let told = changes.iter().any(|(_, old, new)| old[i] != new[i]);
        assert!(
            !passed || told,
            "{name}: slip {i} changed its sign in silence"
        );
    }
}

/// Held wheels stand, by no more than the brake can.
fn check_brake(name: &str, p: &Params, end: &Input, y: &Output) {
    if y.held {
        let dry = end.t_brake
            + if p.road.v_eps > 0.0 {
                0.0
            } else {
                p.road.m_v * RoadParams::GRAVITY * end.phi.cos() * p.road.c_rr * p.road.r_w
            };
        let slope = p.road.m_v * RoadParams::GRAVITY * end.phi.sin() * p.road.r_w;
        let carried = (y.t_o - slope).abs();
        assert_eq!(y.omega_w, 0.0, "{name}");
        assert!(
            carried <= dry * (1.0 + ROUND_OFF) + ROUND_OFF,
            "{name}: {carried} of {dry}"
        );
    }
}

/// What a drive by chance has shown.
#[derive(Debug, Default)]
struct Seen {
    states: [[u32; 3]; 2],
    held: u32,
    changes: usize,
}

/// A drive by chance of 20 s or 20,000 steps of `h` [s] that keeps every law.
fn check(name: &str, p: &Params, most: f64, seed: u64, h: f64, all: &mut Seen) {
    let steps = ((20.0 / h) as u32).clamp(3000, 20_000);
    let (mut turnover, mut residual) = (0.0, 0.0_f64);
    drive(
        p,
        most,
        (seed, h, steps),
        |before, input, rate, plant, y, changes| {
            let end = input.after(rate, h);
            check_clutches(name, p, &end, plant, y);
            check_events(name, h, before, plant, changes);
            check_brake(name, p, &end, y);
            turnover += h * ((end.t_e * y.omega_e).abs() + (y.t_v * y.omega_w).abs());
            residual = residual.max(y.energy_residual.abs());
            for i in [0, 1] {
                all.states[i][y.state[i] as usize - 1] += 1;
            }
            all.held += u32::from(y.held);
            all.changes += changes.iter().filter(|(_, old, new)| old != new).count();
        },
    );
    println!("{name}, h = {h} s: {residual:.1e} of {turnover:.1e} J");
    assert!(
        residual < UNBALANCED * turnover,
        "{name}: {residual} of {turnover} J"
    );
}

#[test]
fn drives_by_chance_keep_every_law() {
    for (name, p, most) in boxes() {
        let mut all = Seen::default();
        for (seed, h) in [(0, 1e-4), (1, 1e-3), (2, 1.7e-3), (3, 1e-2), (4, 2e-2)] {
            check(name, &p, most, seed, h, &mut all);
        }
        println!("{name}: {all:?}");
        let often = all.states.as_flattened().iter().all(|count| *count > 500);
        assert!(
            often && all.held > 300 && all.changes > 500,
            "{name}: {all:?}"
        );
    }
}

/// Rigid gears that lose power, both clutches engaged, strained against each other beyond what one of them can carry
/// without loss: five drives on which they slipped the wrong way, slipped by themselves or carried too much.
#[test]
fn what_strains_in_gears_that_lose_power_stands_until_it_can_move() {
    let (name, p, most) = boxes()[4];
    let drives = [
        (1345, 1e-3),
        (1022, 2e-3),
        (1023, 5e-3),
        (1097, 2e-2),
        (1463, 2e-2),
    ];
    for (seed, h) in drives {
        check(name, &p, most, seed, h, &mut Seen::default());
    }
}

/// A long step is as many short ones whatever happens within it: the same modes in the same order, the same state.
///
/// What is left is of second order where friction bends over slip; where gears lose power it is a load that changes its
/// sign and returns within 10 ms, as half a period of the fastest shaft is 8 ms in gear 3.
#[test]
fn a_long_step_is_many_short_ones() {
    /// Of the state [rad/s] after one step, by box; 10 ms are the worst.
    const LEFT: [f64; 7] = [5e-4, 3e-4, 3e-2, 2e-2, 2e-3, 0.2, 3e-2];
    /// Of steps with events: what happens at one instant may do so in another order.
    const OTHER_ORDER: f64 = 0.005;
    const PARTS: u32 = 16;
    for ((name, p, most), left) in boxes().into_iter().zip(LEFT) {
        let (mut worst, mut events, mut other) = (0.0_f64, 0, 0);
        for (seed, h) in [(11, 1e-3), (12, 5e-3), (13, 1e-2), (14, 1e-2)] {
            let part = h / f64::from(PARTS);
            let mut short = Propagators::new(&p, [0, 0], part);
            drive(
                &p,
                most,
                (seed, h, 3000),
                |before, input, rate, plant, _, changes| {
                    let (mut fine, mut seen) = (*before, Vec::new());
                    for k in 0..PARTS {
                        let now = input.after(rate, part * f64::from(k));
                        fine.step_observed(&p, &mut short, &now, rate, |_, old, new| {
                            seen.extend((old != new).then_some(new));
                        });
                    }
                    let told = changes.iter().filter(|(_, old, new)| old != new);
                    let told: Vec<_> = told.map(|change| change.2).collect();
                    events += told.len();
                    if told == seen {
                        worst = worst.max((plant.x - fine.x).amax());
                    } else {
                        other += 1;
                    }
                },
            );
        }
        println!("{name}: {events} events, {other} steps with others, {worst:.1e} rad/s");
        assert!(worst < left, "{name}: {worst} rad/s");
        let most = OTHER_ORDER * events as f64;
        assert!(
            events > 400 && f64::from(other) < most,
            "{name}: {other} of {events}"
        );
    }
}

/// A start, a launch and a stop on the brake, 20 s long, from rest to rest.
fn start_and_stop(time: f64) -> Input {
    let ramp = |from: f64, to: f64| ((time - from) / (to - from)).clamp(0.0, 1.0);
    Input {
        t_e: 65.0 * (ramp(0.0, 0.2) - ramp(5.0, 5.3)),
        force: [
            3000.0 * ramp(1.0, 3.0) * f64::from(u8::from(time < 19.5)),
            0.0,
        ],
        gear: [1, 0],
        t_brake: 900.0 * (ramp(6.0, 7.0) - ramp(19.6, 19.9)),
        phi: 0.0,
    }
}

/// An hour of 1 ms steps: the 180th launch locks up at the instant of the second, and the energy balance stays closed.
#[test]
fn an_hour_does_not_drift() {
    const CYCLE: u32 = 20_000;
    /// What the swing that is left after 12 s on the brake does to the next launch [s].
    const LEFT: f64 = 1e-9;
    let (p, h) = (Params::TABLE_1, 1e-3);
    let mut propagators = Propagators::new(&p, [1, 0], h);
    let mut plant = Plant::start(&p, &start_and_stop(0.0), 0.0, 0.0);
    let mut cycles = Vec::new();
    for _ in 0..180 {
        let mut events = Vec::new();
        for k in 0..CYCLE {
            let start = f64::from(k) * h;
            let input = start_and_stop(start);
            plant.step_observed(
                &p,
                &mut propagators,
                &input,
                &InputRate::default(),
                |time, old, new| {
                    events.extend((old != new).then_some((start + time, new)));
                },
            );
        }
        cycles.push(events);
    }
    println!("{:?}", cycles[1]);
    let last = &cycles[179];
    assert!(
        last.len() >= 4 && last.len() == cycles[1].len(),
        "{last:?} {:?}",
        cycles[1]
    );
    for ((late, modes), (early, same)) in last.iter().zip(&cycles[1]) {
        assert_eq!(modes, same);
        assert!((late - early).abs() < LEFT, "{late} {early} s");
    }
    let residual = plant.energy_residual(&propagators.systems).abs();
    println!("{residual:.1e} of {:.1e} J", plant.work.engine);
    assert!(residual < UNBALANCED * plant.work.engine, "{residual} J");
}
