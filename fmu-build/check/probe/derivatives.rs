//! Directional derivatives against differences, at a communication point and in initialization mode.

use super::super::Report;
use super::super::native::Instance;
use super::super::refused::done;
use super::session::{Session, Variable};
use super::stimuli::{Nudge, Stimuli, is_smooth};
use super::value::Value;
use crate::Result;

/// Steps before the derivatives are compared.
const BEFORE: usize = 6;
/// Parts of a nudge by which an input is moved, to either side: a corner of a map or a curve shows.
const PARTS: [f64; 4] = [-0.1, -0.01, 0.01, 0.1];
/// Relative error that differences may have beside what they differ by among themselves.
const SHARE: f64 = 1e-3;
/// Rounding errors of an output, in units of its last place.
const ROUNDING: f64 = 64.0;

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    if !session.can(|can| can.directional) {
        return Ok(());
    }
    let stimuli = Stimuli::of(session)?;
    let start = session.initializing()?;
    check_at(session, &start, &stimuli, "in initialization mode", report)?;
    drop(start);
    let run = session.run()?;
    stimuli.record(&run, 0..BEFORE)?;
    check_at(session, &run.instance, &stimuli, "after a step", report)
}

fn check_at(
    session: &Session<'_>,
    instance: &Instance<'_>,
    stimuli: &Stimuli<'_>,
    when: &str,
    report: &mut Report,
) -> Result<()> {
    for (unknown, known) in pairs(session, stimuli) {
        let [unknown_at, known_at] = [unknown.reference(), known.variable.reference()];
        let given = done(instance.directional(unknown_at, known_at)?)?;
        let slopes = slopes(instance, unknown, known)?;
        if !fits(given, &slopes) {
            let (y, u) = (unknown.name(), known.variable.name());
            let found = slopes.last().map_or(f64::NAN, |slope| slope.value);
            let text = format!(
                "the directional derivative of {y} by {u} is {given} {when}, the difference gives {found}"
            );
            report.error("2.1.9", text);
        }
    }
    Ok(())
}

/// Every output with the inputs it may depend on; one pair at least, so that the function is called.
fn pairs<'s, 'a>(
    session: &Session<'_>,
    stimuli: &'s Stimuli<'a>,
) -> Vec<(&'s Variable<'a>, &'s Nudge<'a>)> {
    let unknowns = &session.description.structure.outputs.unknowns;
    let outputs = stimuli.outputs.iter().filter(|output| output.is_smooth());
    let all: Vec<_> = outputs
        .flat_map(|y| {
            stimuli
                .inputs
                .iter()
                .filter(|u| is_smooth(u))
                .map(move |u| (y, u))
        })
        .collect();
    let declared = |(y, u): &(&Variable<'_>, &Nudge<'_>)| {
        let unknown = unknowns.iter().find(|unknown| unknown.index == y.index);
        unknown.is_some_and(|unknown| unknown.may_depend_on(u.variable.index))
    };
    let some: Vec<_> = all.iter().copied().filter(declared).collect();
    if some.is_empty() {
        return all.into_iter().take(1).collect();
    }
    some
}

/// A difference quotient and what rounding can make of it.
struct Slope {
    value: f64,
    error: f64,
}

/// Difference quotients to both sides, as far as the FMU accepts the values.
fn slopes(
    instance: &Instance<'_>,
    unknown: &Variable<'_>,
    known: &Nudge<'_>,
) -> Result<Vec<Slope>> {
    let now = known.variable.get(instance)?;
    let (Some(at), Some(start), Some(other)) = (now.real(), known.start.real(), known.other.real())
    else {
        return Ok(Vec::new());
    };
    let [min, max] = [known.variable.attributes.min, known.variable.attributes.max];
    let before = unknown.get(instance)?.real().unwrap_or(f64::NAN);
    let (mut slopes, scale) = (Vec::new(), unknown.nominal());
    for part in PARTS {
        let moved = at + part * (other - start);
        if min.is_some_and(|min| moved < min) || max.is_some_and(|max| moved > max) {
            continue;
        }
        known.variable.set(instance, &Value::Real(moved))?;
        let after = unknown.get(instance)?.real().unwrap_or(f64::NAN);
        slopes.push(Slope {
            value: (after - before) / (moved - at),
            error: ROUNDING * f64::EPSILON * before.abs().max(after.abs()).max(scale)
                / (moved - at).abs(),
        });
    }
    known.variable.set(instance, &now)?;
    Ok(slopes)
}

/// Whether a derivative lies among the quotients, or as near to them as they are to each other.
fn fits(given: f64, slopes: &[Slope]) -> bool {
    let values = || slopes.iter().map(|slope| slope.value);
    let (least, most) = (
        values().fold(f64::INFINITY, f64::min),
        values().fold(f64::NEG_INFINITY, f64::max),
    );
    let rounding = slopes.iter().map(|slope| slope.error).fold(0.0, f64::max);
    let room = (most - least) + SHARE * least.abs().max(most.abs()) + rounding;
    slopes.is_empty() || (given >= least - room && given <= most + room)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits_one_of(given: f64, values: &[f64]) -> bool {
        let slopes = values.iter().map(|value| Slope {
            value: *value,
            error: 0.0,
        });
        fits(given, &slopes.collect::<Vec<_>>())
    }

    #[test]
    fn a_derivative_fits_to_either_side_of_a_corner_and_not_to_a_line() {
        assert!(fits_one_of(1.0, &[1.0, 1.0, 3.0, 3.0]));
        assert!(fits_one_of(3.0, &[1.0, 1.0, 3.0, 3.0]));
        assert!(fits_one_of(2.001, &[2.0, 2.0]));
        assert!(!fits_one_of(2.01, &[2.0, 2.0]));
        assert!(!fits_one_of(f64::NAN, &[2.0, 2.0]));
        assert!(!fits_one_of(-2.0, &[2.0, 2.0]));
    }
}
