//! Whether a saved state brings everything back: in the same instance, and as bytes in another one.

use super::super::Report;
use super::super::native::Saved;
use super::super::refused::done;
use super::session::{Run, Session, values};
use super::stimuli::{Rows, Stimuli};
use crate::Result;

/// Steps before the state is saved, and after all; inputs change before and after.
const BEFORE: usize = 6;
const END: usize = 14;
const CLAUSE: &str = "2.1.8";

/// What a run does after its state was saved.
struct Expected {
    time: f64,
    now: Rows,
    later: Rows,
}

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    if !session.can(|can| can.can_save) {
        return Ok(());
    }
    let stimuli = Stimuli::of(session)?;
    let run = session.run()?;
    stimuli.record(&run, 0..BEFORE)?;
    let (time, now) = (run.time.get(), values(&run.instance, &stimuli.outputs)?);
    let saved = done(run.instance.save()?)?;
    let bytes = match session.can(|can| can.can_serialize) {
        true => Some(bytes(&run, &saved, report)?),
        false => None,
    };
    let expected = Expected {
        time,
        now: vec![now],
        later: stimuli.record(&run, BEFORE..END)?,
    };
    restore(&stimuli, &run, &saved, &expected, ["", ""], report)?;
    drop(saved);
    let Some(bytes) = bytes else {
        return Ok(());
    };
    if session.can(|can| can.only_once) {
        drop(run);
        return restore_bytes(session, &stimuli, &bytes, &expected, report);
    }
    restore_bytes(session, &stimuli, &bytes, &expected, report)
}

fn bytes(run: &Run<'_>, saved: &Saved<'_>, report: &mut Report) -> Result<Vec<u8>> {
    let (bytes, beyond) = done(run.instance.serialize(saved)?)?;
    if beyond {
        let text = "fmi2SerializeFMUstate writes more than fmi2SerializedFMUstateSize tells";
        report.error(CLAUSE, text);
    }
    Ok(bytes)
}

/// In an instance that was only made, as importers do that continue a run in another process.
fn restore_bytes(
    session: &Session<'_>,
    stimuli: &Stimuli<'_>,
    bytes: &[u8],
    expected: &Expected,
    report: &mut Report,
) -> Result<()> {
    let run = session.bare()?;
    let saved = done(run.instance.deserialize(bytes)?)?;
    let where_from = [" of a serialised state", " in a new instance"];
    restore(stimuli, &run, &saved, expected, where_from, report)
}

fn restore(
    stimuli: &Stimuli<'_>,
    run: &Run<'_>,
    saved: &Saved<'_>,
    expected: &Expected,
    [of, place]: [&str; 2],
    report: &mut Report,
) -> Result<()> {
    done(run.instance.restore(saved)?)?;
    run.time.set(expected.time);
    let now = vec![values(&run.instance, &stimuli.outputs)?];
    if let Some((_, text)) = stimuli.difference(&expected.now, &now) {
        report.error(CLAUSE, format!("after fmi2SetFMUstate{of}{place}: {text}"));
        return Ok(());
    }
    let later = stimuli.record(run, BEFORE..END)?;
    if let Some((row, text)) = stimuli.difference(&expected.later, &later) {
        let step = row + 1;
        report.error(
            CLAUSE,
            format!("step {step} after fmi2SetFMUstate{of}{place}: {text}"),
        );
    }
    Ok(())
}
