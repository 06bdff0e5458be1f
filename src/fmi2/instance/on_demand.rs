//! Outputs on demand, on a counter that squares what it counted when it is asked.

use super::Instance;
use crate::saved::Saved;
use crate::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

#[derive(Clone, Default)]
struct Counter {
    gain: f64,
    count: f64,
    square: f64,
    large: bool,
    updates: i32,
}

const GAIN: u32 = 0;
const COUNT: u32 = 1;
const SQUARE: u32 = 2;
const LARGE: u32 = 3;

impl Model for Counter {
    const NAME: &'static str = "Counter";
    const DESCRIPTION: &'static str = "";
    const STEPS_STAY_FINITE: bool = true;
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 10.0,
        step: 1.0,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("gain", Unit::ONE, |m: &mut Self| &mut m.gain, ""),
        Variable::output("count", Unit::ONE, |m: &mut Self| &mut m.count, "").depends_on(&[]),
        Variable::output("square", Unit::ONE, |m: &mut Self| &mut m.square, "").on_demand(),
        Variable::boolean_output("large", |m: &mut Self| &mut m.large, "").on_demand(),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _: f64, step: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.count += step;
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.square = self.gain * self.count * self.count;
        self.large = self.square > 10.0;
        self.updates += 1;
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

fn silent<T>(act: impl FnOnce(&mut Log<'_>) -> T) -> T {
    act(&mut Log::new(&mut |_, _| ()))
}

/// A counter after two steps with gain 3.
fn counted() -> Instance<Counter> {
    let mut counter = Instance::<Counter>::default();
    counter.enter_initialization().unwrap();
    silent(|log| counter.exit_initialization(log)).unwrap();
    counter.set(&[GAIN], [3.0].into_iter()).unwrap();
    for k in [0.0, 1.0] {
        silent(|log| counter.step(k, 1.0, log)).unwrap();
    }
    counter
}

fn read(counter: &mut Instance<Counter>, reference: u32) -> f64 {
    silent(|log| counter.get(&[reference], log).unwrap().next()).unwrap()
}

fn read_plainly(counter: &mut Instance<Counter>, reference: u32) -> Option<f64> {
    let mut value = [f64::NAN];
    let plain = counter.get_plainly(&[reference], &mut value);
    plain.then_some(value[0])
}

#[test]
fn it_is_computed_once_when_it_is_read() {
    let mut counter = counted();
    let before = counter.now.model.updates;
    assert_eq!(read_plainly(&mut counter, COUNT), Some(2.0));
    assert_eq!(read(&mut counter, COUNT), 2.0);
    assert_eq!(counter.now.model.updates, before);
    for _ in 0..2 {
        assert_eq!(read_plainly(&mut counter, SQUARE), Some(12.0));
        assert_eq!(read(&mut counter, SQUARE), 12.0);
    }
    assert_eq!(counter.now.model.updates, before + 1);
}

#[test]
fn who_reads_many_after_every_step_gets_them_at_once() {
    let mut counter = counted();
    let mut at_once = |time: f64, reference: u32| {
        silent(|log| counter.step(time, 1.0, log)).unwrap();
        counter.get_plainly(&[reference; 12], &mut [f64::NAN; 12])
    };
    let looks = [SQUARE, SQUARE, COUNT, COUNT, SQUARE, SQUARE];
    let looks: Vec<bool> = (2..8)
        .zip(looks)
        .map(|(k, reference)| at_once(f64::from(k), reference))
        .collect();
    // Where it was not read after the step before, the first look finds out that it is wanted.
    assert_eq!(looks, [false, true, true, true, false, true]);
}

fn read_flag(counter: &mut Instance<Counter>, reference: u32) -> Option<bool> {
    let mut value = [false];
    let plain = counter.get_others_plainly(&[reference], &mut value);
    plain.then_some(value[0])
}

#[test]
fn a_flag_is_handed_out_when_it_is_computed_and_is_one() {
    let mut counter = counted();
    assert_eq!(read_flag(&mut counter, LARGE), None);
    assert_eq!(read_plainly(&mut counter, SQUARE), Some(12.0));
    assert_eq!(read_flag(&mut counter, LARGE), Some(true));
    for other in [SQUARE, LARGE + 1] {
        assert_eq!(read_flag(&mut counter, other), None);
    }
    counter.set(&[GAIN], [1.0].into_iter()).unwrap();
    assert_eq!(read_flag(&mut counter, LARGE), None);
}

#[test]
fn it_follows_what_is_set_after_the_step() {
    for also_before in [false, true] {
        let mut counter = counted();
        if also_before {
            assert_eq!(read(&mut counter, SQUARE), 12.0);
        }
        counter.set(&[GAIN], [5.0].into_iter()).unwrap();
        assert_eq!(read_plainly(&mut counter, SQUARE), None);
        assert_eq!(read(&mut counter, SQUARE), 20.0);
    }
}

#[test]
fn saved_states_hold_it_as_if_it_had_been_read() {
    let (mut asked, mut left) = (counted(), counted());
    assert_eq!(read(&mut asked, SQUARE), 12.0);
    let bytes = left.save().unwrap().to_bytes();
    assert_eq!(bytes, asked.save().unwrap().to_bytes());
    let mut resumed = Instance::<Counter>::default();
    let saved = Saved::<Counter>::from_bytes(&bytes).unwrap();
    resumed.restore(&saved).unwrap();
    assert_eq!(read_plainly(&mut resumed, SQUARE), Some(12.0));
    let mut copied = Instance::<Counter>::default();
    copied.restore(&left.save().unwrap()).unwrap();
    assert_eq!(read_plainly(&mut copied, SQUARE), Some(12.0));
}

#[test]
fn a_state_is_not_made_of_an_output_that_is_no_number() {
    let mut counter = counted();
    counter.set(&[GAIN], [f64::MAX].into_iter()).unwrap();
    silent(|log| counter.step(2.0, 1.0, log)).unwrap();
    let told = counter.save().map_err(|error| error.to_string());
    assert!(told.is_err_and(|text| text.starts_with("square = ")));
}

#[test]
fn one_that_is_no_number_is_not_handed_out() {
    let mut counter = counted();
    counter.set(&[GAIN], [f64::MAX].into_iter()).unwrap();
    silent(|log| counter.step(2.0, 1.0, log)).unwrap();
    assert_eq!(read_plainly(&mut counter, COUNT), Some(3.0));
    for _ in 0..2 {
        assert_eq!(read_plainly(&mut counter, SQUARE), None);
    }
    let told = silent(|log| counter.get::<f64>(&[SQUARE], log).map(drop));
    assert!(told.is_err_and(|error| error.to_string().starts_with("square = ")));
    counter.set(&[GAIN], [3.0].into_iter()).unwrap();
    assert_eq!(read(&mut counter, SQUARE), 27.0);
}

#[test]
fn it_is_there_after_the_last_step_of_a_run() {
    let mut counter = counted();
    counter.terminate().unwrap();
    assert_eq!(read_plainly(&mut counter, SQUARE), Some(12.0));
}
