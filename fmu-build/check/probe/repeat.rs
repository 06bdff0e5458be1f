//! Whether a run can be repeated: after fmi2Reset, in a new instance, and beside another one.

use super::super::Report;
use super::session::{Run, Session, values};
use super::stimuli::{Rows, Stimuli};
use crate::Result;

const STEPS: usize = 20;

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let stimuli = Stimuli::of(session)?;
    let run = session.run()?;
    let first = stimuli.record(&run, 0..STEPS)?;
    check_finite(&stimuli, &first, report);
    check_constants(session, &run, report)?;
    run.reset(session)?;
    let again = stimuli.record(&run, 0..STEPS)?;
    compare(
        session,
        &stimuli,
        [&first, &again],
        "after fmi2Reset",
        report,
    );
    drop(run);
    let fresh = stimuli.record(&session.run()?, 0..STEPS)?;
    let what = "in a second run, with a new instance";
    compare(session, &stimuli, [&first, &fresh], what, report);
    if session.can(|can| can.only_once) {
        return Ok(());
    }
    check_neighbours(session, &stimuli, &first, report)
}

fn check_finite(stimuli: &Stimuli<'_>, rows: &Rows, report: &mut Report) {
    for (at, output) in stimuli.outputs.iter().enumerate() {
        let numbers = rows.iter().filter_map(|row| row.get(at)?.real());
        if let Some(wrong) = numbers.into_iter().find(|value| !value.is_finite()) {
            let name = output.name();
            report.warn(
                "2.1.7",
                format!("{name} becomes {wrong} though fmi2DoStep returns fmi2OK"),
            );
        }
    }
}

/// They are as the description says after steps, too.
fn check_constants(session: &Session<'_>, run: &Run<'_>, report: &mut Report) -> Result<()> {
    for constant in session.constants() {
        let found = constant.get(&run.instance)?;
        let start = constant.attributes.start.as_deref();
        if let Some(start) = start.filter(|start| !found.equals(start)) {
            let name = constant.name();
            let text = format!("{name} is a constant of {start}, but {found} after {STEPS} steps");
            report.error("2.2.7", text);
        }
    }
    Ok(())
}

/// Two instances at once, of which the other sees other inputs and takes its steps in between.
fn check_neighbours(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    first: &Rows,
    report: &mut Report,
) -> Result<()> {
    let run = session.run()?;
    let Some(instance) = session.instantiated_with(&session.description.guid)? else {
        report.error(
            "4.3.1",
            "a second instance is refused, though canBeInstantiatedOnlyOncePerProcess is not true",
        );
        return Ok(());
    };
    drop(instance);
    let other = session.run()?;
    let mut rows = Rows::new();
    for number in 0..STEPS {
        rows.push(stimuli.advance(&run, number)?);
        stimuli.nudge(&other)?;
        other.step(session.step())?;
        values(&other.instance, &stimuli.outputs)?;
    }
    let what = "while another instance runs";
    compare(session, stimuli, [first, &rows], what, report);
    Ok(())
}

fn compare(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    [first, again]: [&Rows; 2],
    what: &str,
    report: &mut Report,
) {
    if let Some((row, text)) = stimuli.difference(first, again) {
        let step = session.step();
        let clause = "2.1.6";
        report.error(
            clause,
            format!("{what}, step {} of {step} s: {text}", row + 1),
        );
    }
}
