#![no_std]
//! The observer for a control unit: `dct_observer.h` in Rust.
//!
//! The state lives in the caller's `dct_observer`; nothing allocates, and no `unsafe` block is needed:
//! a C pointer arrives as `Option<&T>`, so null is the one thing that has to be checked here. That what
//! is not null points at an object of its own is the caller's promise, as with every C library; so is
//! that `dct_observer_start` was called before `dct_observer_step`.

mod header;
mod interface;
mod methods;
mod vehicle;

use core::mem::{MaybeUninit, size_of};
use core::panic::PanicInfo;
use dct_driveline::Params;
use dct_driveline::observer::{self, Settings};
use interface::{Estimate, Sample, SettingsOfC};
use methods::Chosen;
use vehicle::Vehicle;

/// Everything went well.
const OK: i32 = 0;
/// A pointer is null.
const NULL: i32 = 1;
/// A value of vehicle or settings makes no sense.
const VEHICLE: i32 = 2;
/// A sample or a step is no number or out of range.
const SAMPLE: i32 = 3;

/// The library was built without this method.
const METHOD: i32 = 4;

/// Longest step [s], as of the observer's FMU.
const LONGEST_STEP: f64 = 0.1;

/// `dct_observer` of the header.
pub struct State {
    vehicle: Params,
    settings: Settings,
    observer: Chosen,
}

const ROOM: usize = header::number("#define DCT_OBSERVER_DOUBLES ") * size_of::<f64>();
const _: () = assert!(
    size_of::<State>() <= ROOM,
    "dct_observer.h has too little room"
);

/// Fills in Table 1, friction case 1 and method `paper`.
// SAFETY: no other symbol of this library or of C has this name.
#[unsafe(no_mangle)]
pub extern "C" fn dct_table_1(
    vehicle: Option<&mut MaybeUninit<Vehicle>>,
    settings: Option<&mut MaybeUninit<SettingsOfC>>,
) -> i32 {
    let (Some(vehicle), Some(settings)) = (vehicle, settings) else {
        return NULL;
    };
    vehicle.write(Vehicle::from(&Params::TABLE_1));
    settings.write(SettingsOfC::CASE_1);
    OK
}

/// Starts from measurements.
// SAFETY: no other symbol of this library or of C has this name.
#[unsafe(no_mangle)]
pub extern "C" fn dct_observer_start(
    state: Option<&mut MaybeUninit<State>>,
    vehicle: Option<&Vehicle>,
    settings: Option<&SettingsOfC>,
    sample: Option<&Sample>,
    estimate: Option<&mut MaybeUninit<Estimate>>,
) -> i32 {
    let (Some(state), Some(vehicle), Some(settings)) = (state, vehicle, settings) else {
        return NULL;
    };
    let (Some(sample), Some(estimate)) = (sample, estimate) else {
        return NULL;
    };
    let sample: observer::Sample = sample.into();
    match fill(state, vehicle, settings, &sample) {
        Ok(state) => {
            estimate.write(begin(state, &sample));
            OK
        }
        Err(refusal) => refusal,
    }
}

/// The state before its start, if everything makes sense.
#[inline(never)] // its room on the stack is free again when the observer starts
fn fill<'a>(
    state: &'a mut MaybeUninit<State>,
    vehicle: &Vehicle,
    settings: &SettingsOfC,
    sample: &observer::Sample,
) -> Result<&'a mut State, i32> {
    let (Some(vehicle), Some((method, settings))) = (vehicle.checked(), settings.checked()) else {
        return Err(VEHICLE);
    };
    let ratios = vehicle.g(sample.gear);
    let fitted = [0, 1]
        .iter()
        .all(|i| sample.gear[*i] == 0 || ratios[*i] != 0.0);
    if !fitted || !sample.is_finite() {
        return Err(SAMPLE);
    }
    let observer = Chosen::new(method).ok_or(METHOD)?;
    Ok(state.write(State {
        vehicle,
        settings,
        observer,
    }))
}

/// Starts the observer.
#[inline(never)]
fn begin(state: &mut State, sample: &observer::Sample) -> Estimate {
    let State {
        vehicle,
        settings,
        observer,
    } = state;
    observer.start(vehicle, settings, sample).into()
}

/// Advances by `step` [s].
// SAFETY: no other symbol of this library or of C has this name.
#[unsafe(no_mangle)]
pub extern "C" fn dct_observer_step(
    state: Option<&mut State>,
    sample: Option<&Sample>,
    step: f64,
    estimate: Option<&mut MaybeUninit<Estimate>>,
) -> i32 {
    let (Some(state), Some(sample), Some(estimate)) = (state, sample, estimate) else {
        return NULL;
    };
    let sample: observer::Sample = sample.into();
    if !(sample.is_finite() && step > 0.0 && step <= LONGEST_STEP) {
        return SAMPLE;
    }
    let State {
        vehicle,
        settings,
        observer,
    } = state;
    estimate.write(observer.step(vehicle, settings, &sample, step).into());
    OK
}

/// Takes over what was learnt, for the next start.
// SAFETY: no other symbol of this library or of C has this name.
#[unsafe(no_mangle)]
pub extern "C" fn dct_take_over(
    vehicle: Option<&mut Vehicle>,
    settings: Option<&mut SettingsOfC>,
    estimate: Option<&Estimate>,
) -> i32 {
    let (Some(vehicle), Some(settings), Some(estimate)) = (vehicle, settings, estimate) else {
        return NULL;
    };
    if !estimate.has_learnt() {
        return METHOD;
    }
    vehicle.take_over(estimate);
    settings.take_over(estimate);
    OK
}

/// Ends here what cannot happen: a control unit's watchdog notices.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
