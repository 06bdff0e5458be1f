//! Steps that are still being computed when fmi2DoStep returns: promised, signalled, cancelled.

use super::super::Report;
use super::super::native::{Begun, Transition, finished};
use super::super::refused::done;
use super::session::{Run, Session};
use super::stimuli::Stimuli;
use crate::Result;
use std::thread;
use std::time::{Duration, Instant};

/// Steps that tell whether a cancelled one left anything behind.
const STEPS: usize = 5;
/// What an FMU may take between the end of a step and its call of `stepFinished`, on a busy machine too.
const GRACE: Duration = Duration::from_secs(2);
/// Between two looks whether it has called.
const PAUSE: Duration = Duration::from_millis(1);

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let run = session.run()?;
    let before = finished();
    if let Begun::Over(called) = run.instance.begin_step(session.start(), session.step())? {
        return done(called);
    }
    if !session.can(|can| can.asynchronous) {
        let text = "fmi2DoStep returns fmi2Pending though canRunAsynchronuously is not true";
        report.error("4.2.2", text);
    }
    done(run.instance.wait()?)?;
    let end = Instant::now() + GRACE;
    while finished() == before && Instant::now() < end {
        thread::sleep(PAUSE);
    }
    if finished() == before {
        let text = "stepFinished is not called at the end of a step that was pending";
        report.error("4.2.2", text);
    }
    drop(run);
    check_cancelled(session, report)
}

/// After fmi2CancelStep and fmi2Reset an FMU is as new.
fn check_cancelled(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let stimuli = Stimuli::of(session)?;
    let run = session.run()?;
    let first = stimuli.record(&run, 0..STEPS)?;
    run.reset(session)?;
    if !cancelled(&run, session, report)? {
        return Ok(());
    }
    run.reset(session)?;
    let again = stimuli.record(&run, 0..STEPS)?;
    if let Some((_, text)) = stimuli.difference(&first, &again) {
        let text = format!("after fmi2CancelStep and fmi2Reset: {text}");
        report.error("4.2.2", text);
    }
    Ok(())
}

/// Whether a pending step was cancelled; one that ends before cannot be.
fn cancelled(run: &Run<'_>, session: &Session<'_>, report: &mut Report) -> Result<bool> {
    if let Begun::Over(called) = run.instance.begin_step(session.start(), session.step())? {
        return done(called).map(|()| false);
    }
    if run.instance.call(Transition::CancelStep)?.is_ok() {
        return Ok(true);
    }
    if run.instance.is_pending()? {
        let text = "fmi2CancelStep is refused while a step is being computed";
        report.error("4.2.2", text);
    }
    done(run.instance.wait()?).map(|()| false)
}
