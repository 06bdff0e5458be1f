//! The life cycle and its checks, on a tank that fills.

use super::plain::nominal;
use super::*;
use crate::{Category, Enumeration, Experiment, Item, StateFields, Status, Unit, Variable};
use core::fmt;

/// A tank: level' = inflow / area; negative areas make it fail, a level above 100 makes it panic.
#[derive(Clone)]
struct Tank {
    area: f64,
    gain: f64,
    inflow: f64,
    inflow_rate: f64,
    level: f64,
    open: bool,
    mode: i32,
    steps: i32,
    last_step: f64,
}

static MODE: Enumeration = Enumeration {
    name: "Mode",
    description: "Mode",
    items: &[
        Item {
            name: "slow",
            value: 1,
            description: "",
        },
        Item {
            name: "fast",
            value: 3,
            description: "",
        },
    ],
};

impl Default for Tank {
    fn default() -> Self {
        Self {
            area: 2.0,
            gain: 1.0,
            inflow: 0.0,
            inflow_rate: 0.0,
            level: 0.0,
            open: true,
            mode: 1,
            steps: 0,
            last_step: 0.0,
        }
    }
}

const AREA: u32 = 0;
const GAIN: u32 = 1;
const INFLOW: u32 = 2;
const LEVEL: u32 = 3;
const OPEN: u32 = 4;
const MODE_REFERENCE: u32 = 5;

impl Model for Tank {
    const NAME: &'static str = "Tank";
    const DESCRIPTION: &'static str = "A tank";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 10.0,
        step: 0.1,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::parameter(
            "area",
            Unit::SQUARE_METRE,
            |m: &mut Self| &mut m.area,
            "Area",
        )
        .max(50.0),
        Variable::parameter("gain", Unit::ONE, |m: &mut Self| &mut m.gain, "Gain").tunable(),
        Variable::input("inflow", Unit::ONE, |m: &mut Self| &mut m.inflow, "Inflow")
            .min(0.0)
            .rate(|m| &mut m.inflow_rate),
        Variable::output("level", Unit::METRE, |m: &mut Self| &mut m.level, "Level")
            .depends_on(&[])
            .slope(|m| &mut m.inflow),
        Variable::boolean_input("open", |m: &mut Self| &mut m.open, "Open"),
        Variable::enumeration_parameter("mode", &MODE, |m: &mut Self| &mut m.mode, "Mode"),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.consistent()?;
        self.level = 1.0;
        Ok(())
    }

    fn consistent(&self) -> Result<(), Failure> {
        if self.area <= 0.0 {
            return Err(Failure::Invalid {
                variable: "area",
                value: self.area,
                remedy: "must be above 0",
            });
        }
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        self.level += step * self.gain * (self.inflow + 0.5 * step * self.inflow_rate) / self.area;
        self.steps += 1;
        self.last_step = step;
        log.event(format_args!("t = {time}"));
        Ok(())
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        fields.integer(&mut self.steps);
        fields.real(&mut self.last_step);
    }
}

/// Runs `body` with a log that nobody reads.
fn quietly<T>(body: impl FnOnce(&mut Log<'_>) -> T) -> T {
    body(&mut Log::new(&mut |_: Category, _: fmt::Arguments<'_>| {}))
}

fn level(tank: &mut Instance<Tank>) -> f64 {
    quietly(|log| tank.get::<f64>(&[LEVEL], log).unwrap().next().unwrap())
}

fn set(tank: &mut Instance<Tank>, reference: u32, value: f64) -> Result<(), Error> {
    tank.set(&[reference], [value].into_iter())
}

fn step(tank: &mut Instance<Tank>, time: f64, step: f64) -> Result<(), Error> {
    quietly(|log| tank.step(time, step, log))
}

/// A tank in initialisation mode.
fn initialising() -> Instance<Tank> {
    let mut tank = Instance::<Tank>::default();
    tank.setup_experiment(0.0, Some(1.0)).unwrap();
    tank.enter_initialization().unwrap();
    tank
}

/// A tank at its first communication point.
fn running() -> Instance<Tank> {
    let mut tank = initialising();
    quietly(|log| tank.exit_initialization(log)).unwrap();
    tank
}

#[test]
fn a_run_gives_the_closed_form() {
    let mut tank = running();
    set(&mut tank, INFLOW, 4.0).unwrap();
    for k in 0..10 {
        step(&mut tank, f64::from(k) * 0.1, 0.1).unwrap();
    }
    assert!((level(&mut tank) - 3.0).abs() < 1e-12);
    tank.terminate().unwrap();
    assert_eq!(tank.state(), State::Terminated);
}

#[test]
fn an_illegal_call_is_named_and_changes_nothing() {
    let mut tank = Instance::<Tank>::default();
    let illegal = quietly(|log| tank.step(0.0, 0.1, log)).unwrap_err();
    assert_eq!(illegal.status(), Status::Error);
    assert!(
        illegal
            .to_string()
            .contains("fmi2DoStep is illegal in state instantiated")
    );
    assert_eq!(tank.state(), State::Instantiated);
}

#[test]
fn a_refused_set_writes_nothing() {
    let mut tank = running();
    let cases = [
        (LEVEL, 1.0, Status::Error),
        (AREA, 1.0, Status::Error),
        (99, 1.0, Status::Error),
        (OPEN, 1.0, Status::Error),
        (INFLOW, -1.0, Status::Discard),
        (INFLOW, f64::NAN, Status::Discard),
        (INFLOW, f64::INFINITY, Status::Discard),
    ];
    for (reference, value, status) in cases {
        let error = tank
            .set(&[GAIN, reference], [7.0, value].into_iter())
            .unwrap_err();
        assert_eq!(error.status(), status, "{error}");
        let gain = quietly(|log| tank.get::<f64>(&[GAIN], log).unwrap().next());
        assert_eq!(gain, Some(1.0), "{error}");
    }
    set(&mut tank, GAIN, 7.0).unwrap();
}

#[test]
fn an_enumeration_takes_its_items_only() {
    let mut tank = Instance::<Tank>::default();
    let error = tank.set(&[MODE_REFERENCE], [2].into_iter()).unwrap_err();
    assert_eq!(error.to_string(), "mode = 2 is no value of Mode");
    tank.set(&[MODE_REFERENCE], [3].into_iter()).unwrap();
}

#[test]
fn initial_outputs_follow_parameters_set_in_initialisation_mode() {
    let mut tank = initialising();
    assert_eq!(level(&mut tank), 1.0);
    set(&mut tank, AREA, -1.0).unwrap();
    let error = quietly(|log| tank.exit_initialization(log)).unwrap_err();
    assert_eq!(error.to_string(), "area = -1 must be above 0");
    assert_eq!(tank.state(), State::Error);
    tank.reset().unwrap();
    assert_eq!(tank.state(), State::Instantiated);
}

#[test]
fn steps_that_no_model_can_take_are_refused() {
    let refused = [
        (0.0, 0.0),
        (0.0, -0.1),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
        (0.0, 1e-300),
        (0.5, 0.1),
        (f64::NAN, 0.1),
        (0.0, 1e9),
    ];
    for (time, size) in refused {
        let mut tank = running();
        // A step too small to add to t = 0 is a step; later it is none.
        if size == 1e-300 {
            step(&mut tank, 0.0, 0.1).unwrap();
            assert!(step(&mut tank, 0.1, size).is_err());
        } else {
            assert!(step(&mut tank, time, size).is_err(), "{time} {size}");
        }
    }
}

#[test]
fn rounded_communication_points_are_tolerated() {
    let mut tank = running();
    let mut time = 0.0;
    for _ in 0..9 {
        step(&mut tank, time + 3e-10, 0.1 - 2e-12).unwrap();
        time += 0.1;
    }
    step(&mut tank, time, 0.1 + 5e-10).unwrap();
    assert_eq!(tank.time(), 1.0, "the stop time is met exactly");
}

#[test]
fn the_model_is_handed_the_importers_step_bit_for_bit() {
    let mut tank = running();
    for k in 0..9 {
        let time = f64::from(k) * 0.1;
        step(&mut tank, time, 0.1).unwrap();
        assert_eq!(tank.now.model.last_step, 0.1, "at t = {time}");
    }
}

#[test]
fn reset_is_a_fresh_instance_bit_for_bit() {
    let mut tank = running();
    set(&mut tank, INFLOW, 4.0).unwrap();
    step(&mut tank, 0.0, 0.1).unwrap();
    tank.reset().unwrap();
    let fresh = Instance::<Tank>::default().save().unwrap().to_bytes();
    assert_eq!(tank.save().unwrap().to_bytes(), fresh);
}

#[test]
fn a_state_that_went_through_bytes_continues_bit_for_bit() {
    let mut tank = running();
    set(&mut tank, INFLOW, 0.3).unwrap();
    tank.set_input_derivatives(&[INFLOW], &[1], &[0.7]).unwrap();
    step(&mut tank, 0.0, 0.1).unwrap();
    let bytes = tank.save().unwrap().to_bytes();
    let mut other = Instance::<Tank>::default();
    other.restore(&Saved::from_bytes(&bytes).unwrap()).unwrap();
    for tank in [&mut tank, &mut other] {
        step(tank, 0.1, 0.1).unwrap();
    }
    assert_eq!(
        tank.save().unwrap().to_bytes(),
        other.save().unwrap().to_bytes()
    );
}

#[test]
fn damaged_states_are_refused() {
    let bytes = running().save().unwrap().to_bytes();
    for position in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[position] ^= 0x10;
        assert!(
            Saved::<Tank>::from_bytes(&damaged).is_err(),
            "byte {position}"
        );
        assert!(
            Saved::<Tank>::from_bytes(&bytes[..position]).is_err(),
            "length {position}"
        );
    }
    assert!(Saved::<Tank>::from_bytes(&[&bytes[..], &[0]].concat()).is_err());
}

/// A state whose payload was written over at `at`, under a checksum that fits.
fn forged(bytes: &[u8], at: usize, value: &[u8]) -> Vec<u8> {
    const CHECKSUM: core::ops::Range<usize> = 36..52;
    let mut forged = bytes.to_vec();
    forged[CHECKSUM.end + at..][..value.len()].copy_from_slice(value);
    let mut hash = crate::hash::Hash::new();
    hash.bytes(&forged[CHECKSUM.end..]);
    forged[CHECKSUM].copy_from_slice(&hash.value().to_le_bytes());
    forged
}

#[test]
fn states_that_no_run_can_leave_behind_are_refused_though_their_checksum_fits() {
    // State, stale, three times, area, gain, inflow with its rate, level.
    let [time, stop, area, inflow, rate, level] = [2, 18, 26, 42, 50, 58];
    let bytes = running().save().unwrap().to_bytes();
    assert!(Saved::<Tank>::from_bytes(&forged(&bytes, inflow, &1.0_f64.to_le_bytes())).is_ok());
    let cases = [
        (time, f64::NAN),
        (stop, f64::NAN),
        (area, 50.1),
        (area, -1.0),
        (inflow, -0.1),
        (inflow, f64::INFINITY),
        (rate, f64::NAN),
        (level, f64::INFINITY),
    ];
    for (at, value) in cases {
        let refused = Saved::<Tank>::from_bytes(&forged(&bytes, at, &value.to_le_bytes()));
        assert!(
            matches!(refused, Err(Error::Serialised(_))),
            "{value} at {at}"
        );
    }
}

#[test]
fn derivatives_have_order_one_and_belong_to_rows_that_offer_them() {
    let mut tank = running();
    assert!(tank.set_input_derivatives(&[INFLOW], &[2], &[0.0]).is_err());
    assert!(tank.set_input_derivatives(&[LEVEL], &[1], &[0.0]).is_err());
    set(&mut tank, INFLOW, 0.3).unwrap();
    let slope = quietly(|log| tank.output_derivatives(&[LEVEL], &[1], log).unwrap().next());
    assert_eq!(slope, Some(0.3));
}

#[test]
fn a_model_that_leaves_the_numbers_ends_in_error() {
    let mut tank = running();
    set(&mut tank, GAIN, f64::MAX).unwrap();
    set(&mut tank, INFLOW, f64::MAX).unwrap();
    let error = step(&mut tank, 0.0, 0.1).unwrap_err();
    assert!(
        error.to_string().contains("level is no longer finite"),
        "{error}"
    );
    assert_eq!(tank.state(), State::Error);
    let mut value = [0.0];
    assert!(!tank.get_plainly(&[LEVEL], &mut value));
    let told = quietly(|log| tank.get::<f64>(&[LEVEL], log).map(drop));
    assert!(told.is_err(), "an importer is handed what is no number");
}

#[test]
fn steps_reckoned_as_differences_are_equal_to_the_bit() {
    for h in [1e-4, 1e-3, 7e-4, 1e-2, 0.013, 0.001_953_125] {
        for k in 1..100_000_u32 {
            let step = f64::from(k + 1) * h - f64::from(k) * h;
            assert_eq!(nominal(step).to_bits(), h.to_bits(), "{k} {h}");
        }
    }
}

#[test]
fn a_step_that_no_rounding_explains_is_kept() {
    for step in [1e-300, 1.234_567_89e-9, f64::MIN_POSITIVE, 1.0 / 3e4] {
        assert_eq!(nominal(step).to_bits(), step.to_bits(), "{step}");
    }
    let third = 1.0 / 3.0;
    assert!((nominal(third) - third).abs() <= 0.5e-12);
}

#[test]
fn another_number_of_values_than_of_variables_sets_nothing() {
    let (mut tank, variables, values) = (Instance::<Tank>::default(), 2, 1);
    let told = tank.set(&[AREA, GAIN], [3.0].into_iter());
    assert_eq!(told, Err(Error::Lengths { variables, values }));
    assert_eq!(tank.now.model.area, 2.0);
}
