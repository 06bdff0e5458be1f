//! What to do when an FMU cannot take a step: fmi2Discard of fmi2DoStep (FMI 2.0.4, 4.2.2).
//!
//! It is asked first whether it wants the simulation to end (fmi2Terminated).

use crate::derivatives::advance;
use crate::error::{Error, Seconds};
use crate::fmu::Fmu;

/// Of the step: the shortest part that is tried.
const SHORTEST: f64 = 1.0 / 4096.0;

/// Of the step: what is left at its end and counts as nothing.
const ROUNDING: f64 = 1e-9;

/// Sets the inputs in use and advances an FMU from `time` by `step` [s]; a step that it discards is divided.
///
/// `slopes` are none, or one for each input.
#[inline(always)]
pub fn step(
    fmu: &mut Fmu,
    inputs: &mut [f64],
    slopes: &[f64],
    (time, step): (f64, f64),
) -> Result<(), Error> {
    fmu.at(time);
    if fmu.attempt(inputs, slopes, time, step)? {
        return Ok(());
    }
    finish(fmu, inputs, slopes, (time, step))
}

/// Takes the rest of a discarded step from `time` to `time + step` [s], in smaller ones.
///
/// An FMU that got part of the way goes on from there; one that did not move tries half the step.
/// `inputs` stay as they are, or go on with their `slopes`; afterwards they are as before.
#[cold]
fn finish(
    fmu: &mut Fmu,
    inputs: &mut [f64],
    slopes: &[f64],
    (time, step): (f64, f64),
) -> Result<(), Error> {
    let given = inputs.to_vec();
    let done = divide(fmu, inputs, slopes, (time, step));
    inputs.copy_from_slice(&given);
    done?;
    fmu.note_discard(time);
    Ok(())
}

fn divide(
    fmu: &mut Fmu,
    inputs: &mut [f64],
    slopes: &[f64],
    (time, step): (f64, f64),
) -> Result<(), Error> {
    let end = time + step;
    let (mut at, mut part, mut discarded) = (time, step, true);
    while end - at > ROUNDING * step {
        if discarded {
            if fmu.is_terminated() {
                return Err(over(fmu, at, (time, step)));
            }
            let before = at;
            (at, part) = after(fmu, at, (end, ROUNDING * step), part)?;
            advance(inputs, slopes, at - before);
            if part < SHORTEST * step {
                let at = Seconds(at);
                let why = format!("it does not get past t = {at} s, whatever the step");
                return Err(fmu.give_up(&why));
            }
        }
        part = part.min(end - at);
        discarded = !fmu.attempt(inputs, slopes, at, part)?;
        if !discarded {
            at += part;
            advance(inputs, slopes, part);
        }
    }
    Ok(())
}

/// The end of the simulation where the FMU got to from `at` on in the step; `at` when it does not tell.
fn over(fmu: &mut Fmu, at: f64, (time, step): (f64, f64)) -> Error {
    let rounding = ROUNDING * step;
    let told = fmu
        .reached()
        .filter(|reached| (at - rounding..=time + step + rounding).contains(reached));
    fmu.end(told.unwrap_or(at))
}

/// Whether an error is that an FMU asked to end the simulation where the step from `time` by `step` [s] ends: this step is
/// whole, and no other one follows.
pub fn is_over_after(error: &Error, (time, step): (f64, f64)) -> bool {
    matches!(error, Error::Over { time: over, .. } if *over >= time + step - ROUNDING * step)
}

/// Where the FMU is after a discarded step of `part` from `at`, and the next step.
///
/// An FMU that adds up its steps is elsewhere than their product by `rounding` [s] at most.
fn after(
    fmu: &mut Fmu,
    at: f64,
    (end, rounding): (f64, f64),
    part: f64,
) -> Result<(f64, f64), Error> {
    if !fmu.varies_step() {
        let why = "it cannot take this step and takes no other one; change system.step";
        return Err(fmu.give_up(why));
    }
    let Some(reached) = fmu.reached() else {
        let why = "it does not tell how far it got (fmi2GetRealStatus); choose a smaller step";
        return Err(fmu.give_up(why));
    };
    if !(at - rounding..=at + part + rounding).contains(&reached) {
        let reached = Seconds(reached);
        let why = format!("it says that it is at t = {reached} s, outside the step");
        return Err(fmu.give_up(&why));
    }
    Ok(if reached > at + rounding {
        (reached, end - reached)
    } else {
        (at, part / 2.0)
    })
}
