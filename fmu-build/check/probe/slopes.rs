//! Slopes of inputs and of outputs, and steps of other sizes.

use super::super::Report;
use super::super::refused::done;
use super::session::{Session, values};
use super::stimuli::{Nudge, Rows, Stimuli, is_smooth};
use super::value::Value;
use crate::Result;

/// Steps in which an input's slope must show, and the same for steps of half the size.
const STEPS: usize = 4;
/// Steps over which outputs are compared with their derivatives.
const LONG: usize = 20;
/// Of these, the share in which an event may part both.
const EVENTS: usize = LONG / 2;
/// What curvature within a step may add, as a share of the slope itself.
const SHARE: f64 = 0.05;
/// Rounding errors of an output, in units of its last place.
const ROUNDING: f64 = 64.0;

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let stimuli = Stimuli::of(session)?;
    if session.can(|can| can.interpolates) {
        for input in stimuli.inputs.iter().filter(|input| is_smooth(input)) {
            check_input(session, &stimuli, input, report)?;
        }
    }
    if session.can(|can| can.output_derivatives > 0) {
        check_outputs(session, &stimuli, report)?;
    }
    if session.can(|can| can.variable_step) {
        check_half_steps(session, &stimuli, report)?;
    }
    Ok(())
}

/// An input that grows during a step must not act like one that stays, if its value matters at all.
fn check_input(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    input: &Nudge<'_>,
    report: &mut Report,
) -> Result<()> {
    let (Some(start), Some(other)) = (input.start.real(), input.other.real()) else {
        return Ok(());
    };
    let slope = (other - start) / session.step();
    let held = ramp(session, stimuli, input, (start, None))?;
    let moved = ramp(session, stimuli, input, (other, None))?;
    let rising = ramp(session, stimuli, input, (start, Some(slope)))?;
    let matters = stimuli.difference(&held, &moved).is_some();
    if matters && stimuli.difference(&held, &rising).is_none() {
        let name = input.variable.name();
        let text = format!("canInterpolateInputs is true, but the slope of {name} changes nothing");
        report.error("4.2.1", text);
    }
    Ok(())
}

/// The outputs while an input has a value at the beginning of each step, and perhaps a slope.
///
/// They are read with the input at its start: what it feeds through does not count.
fn ramp(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    input: &Nudge<'_>,
    (value, slope): (f64, Option<f64>),
) -> Result<Rows> {
    let run = session.run()?;
    let mut rows = Rows::new();
    let variable = &input.variable;
    for _ in 0..STEPS {
        variable.set(&run.instance, &Value::Real(value))?;
        if let Some(slope) = slope {
            done(run.instance.set_slope(variable.reference(), slope)?)?;
        }
        run.step(session.step())?;
        variable.set(&run.instance, &input.start)?;
        rows.push(values(&run.instance, &stimuli.outputs)?);
    }
    Ok(rows)
}

/// Over most steps, an output moves as its derivatives at both ends say.
fn check_outputs(session: &Session<'_>, stimuli: &Stimuli<'_>, report: &mut Report) -> Result<()> {
    let smooth = stimuli.outputs.iter().filter(|output| output.is_smooth());
    for output in smooth {
        let (step, scale) = (session.step(), output.nominal());
        let run = session.run()?;
        stimuli.nudge(&run)?;
        run.step(step)?;
        let mut points = Vec::new();
        for _ in 0..=LONG {
            let value = output.get(&run.instance)?.real().unwrap_or(f64::NAN);
            points.push((value, done(run.instance.slope(output.reference())?)?));
            run.step(step)?;
        }
        let apart = points.windows(2).filter(|pair| !agree(pair, step, scale));
        if apart.count() > EVENTS {
            let name = output.name();
            let text = format!(
                "{name} does not move as fmi2GetRealOutputDerivatives says: {}",
                shown(&points, step, scale)
            );
            report.error("4.2.1", text);
        }
    }
    Ok(())
}

/// Whether the mean slope of a step lies between or near those at its ends; `scale`: nominal value.
fn agree(pair: &[(f64, f64)], step: f64, scale: f64) -> bool {
    let [(before, rate), (after, next)] = pair else {
        return true;
    };
    let mean = (after - before) / step;
    let bend = (next - rate).abs();
    let rounding = ROUNDING * f64::EPSILON * before.abs().max(after.abs()).max(scale) / step;
    let room = bend + SHARE * mean.abs().max(rate.abs()) + rounding;
    (mean - 0.5 * (rate + next)).abs() <= room
}

/// The first step that does not agree.
fn shown(points: &[(f64, f64)], step: f64, scale: f64) -> String {
    let first = points.windows(2).find(|pair| !agree(pair, step, scale));
    let Some([(before, rate), (after, _)]) = first else {
        return String::new();
    };
    format!("{rate} /s, while it goes from {before} to {after} in {step} s")
}

/// In half a step an FMU must not get as far as in a whole one.
fn check_half_steps(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    report: &mut Report,
) -> Result<()> {
    let steps = |size: f64| -> Result<Rows> {
        let run = session.run()?;
        stimuli.nudge(&run)?;
        let mut rows = Rows::new();
        for _ in 0..2 * STEPS {
            run.step(size)?;
            rows.push(values(&run.instance, &stimuli.outputs)?);
        }
        Ok(rows)
    };
    let (whole, half) = (steps(session.step())?, steps(0.5 * session.step())?);
    let moves = whole.windows(2).any(|pair| match pair {
        [before, after] => stimuli
            .difference(&vec![before.clone()], &vec![after.clone()])
            .is_some(),
        _ => false,
    });
    if moves && stimuli.difference(&whole, &half).is_none() {
        let text = "a step of half the size gets as far as a whole one, though canHandleVariableCommunicationStepSize is true";
        report.error("4.3.1", text);
    }
    Ok(())
}
