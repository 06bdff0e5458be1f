//! Goes through the life cycle twice and reads every start value.

use super::super::Report;
use super::super::native::{Binary, Instance, Refused, Transition, take_messages};
use super::super::parsed::ScalarVariable;
use super::session::Session;
use super::value::Value;
use crate::Result;

/// Whether the FMU can be instantiated and initialised.
pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<bool> {
    check_texts(session.binary, report)?;
    if session
        .instantiated_with("not the guid of any model")?
        .is_some()
    {
        report.error(
            "2.1.5",
            "an instance is made though the GUID is not that of the description",
        );
    }
    take_messages();
    let description = session.description;
    let Some(instance) = session.instantiated_with(&description.guid)? else {
        let mut text = String::from("no instance with the description's GUID");
        if session.can(|can| can.needs_tool) {
            text.push_str(" (needsExecutionTool is true: is that tool installed?)");
        }
        let messages = take_messages().join("; ");
        report.error("2.1.5", format!("{text}: {messages}"));
        return Ok(false);
    };
    let runs = check_life(&instance, session, "", report)?;
    if accepted(instance.call(Transition::Reset)?, report) {
        check_life(&instance, session, " after fmi2Reset", report)?;
    }
    Ok(runs)
}

fn check_texts(binary: &Binary, report: &mut Report) -> Result<()> {
    for (function, expected) in [
        ("fmi2GetVersion", "2.0"),
        ("fmi2GetTypesPlatform", "default"),
    ] {
        let found = binary.text(function)?;
        if found != expected {
            report.error(
                "2.1.4",
                format!("{function} returns {found:?}, not {expected:?}"),
            );
        }
    }
    Ok(())
}

/// From instantiated or reset to terminated; `stage` tells which in findings. Whether it got there.
fn check_life(
    instance: &Instance<'_>,
    session: &Session<'_>,
    stage: &str,
    report: &mut Report,
) -> Result<bool> {
    if !accepted(instance.setup_experiment(session.start())?, report)
        || !accepted(instance.call(Transition::EnterInitializationMode)?, report)
    {
        return Ok(false);
    }
    report.compared = 0;
    for variable in session.description.variables() {
        check_start(instance, variable, stage, report)?;
    }
    let runs = accepted(instance.call(Transition::ExitInitializationMode)?, report);
    if runs {
        accepted(instance.call(Transition::Terminate)?, report);
    }
    Ok(runs)
}

fn check_start(
    instance: &Instance<'_>,
    variable: &ScalarVariable,
    stage: &str,
    report: &mut Report,
) -> Result<()> {
    let Some((kind, attributes)) = variable.kind() else {
        return Ok(());
    };
    let read = match Value::read(instance, kind, variable.value_reference)? {
        Ok(read) => read,
        Err(refused) => {
            accepted::<()>(Err(refused), report);
            return Ok(());
        }
    };
    let exact = variable.initial.as_deref() == Some("exact")
        || variable.is_constant()
        || matches!(variable.causality.as_str(), "input" | "parameter");
    let Some(start) = attributes.start.as_ref().filter(|_| exact) else {
        return Ok(());
    };
    report.compared += 1;
    if !read.equals(start) {
        let name = &variable.name;
        let text = format!("{name} starts at {read}{stage}, the description says {start}");
        report.error("2.2.7", text);
    }
    Ok(())
}

/// Whether a call was carried out; if not, reports it with what the FMU logged.
fn accepted<T>(result: std::result::Result<T, Refused>, report: &mut Report) -> bool {
    let messages = take_messages().join("; ");
    let Err(Refused { function, status }) = result else {
        return true;
    };
    report.error(
        "2.1",
        format!("{function} returns fmi2Status {status}: {messages}"),
    );
    false
}
