//! Whether what is set stays set, and small promises of the description: memory, log categories, fmi2CancelStep.

use super::super::Report;
use super::super::native::Transition;
use super::super::refused::done;
use super::session::{Session, Variable, values};
use super::stimuli::{Stimuli, other};
use super::value::Value;
use crate::Result;

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    check_starts(session, report)?;
    check_inputs(session, report)?;
    check_parameters(session, report)?;
    check_constants(session, report)?;
    check_categories(session, report)?;
    check_memory(session, report)?;
    check_cancel(session, report)
}

/// Importers set start values, often those of the description, before fmi2SetupExperiment.
fn check_starts(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let mut instance = session.instance()?;
    for variable in settable(session) {
        let start = variable.attributes.start.as_deref();
        let Some(start) = start.and_then(|text| Value::parse(variable.kind, text)) else {
            continue;
        };
        if let Err(error) = variable.set(&instance, &start) {
            let name = variable.name();
            report.error(
                "2.1.7",
                format!("{name} refuses its own start value {start}: {error}"),
            );
            drop(instance); // after fmi2Error an instance is of no use
            instance = session.instance()?;
        }
    }
    Ok(())
}

/// Inputs at a communication point.
fn check_inputs(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let stimuli = Stimuli::of(session)?;
    let run = session.run()?;
    for input in &stimuli.inputs {
        input.variable.set(&run.instance, &input.other)?;
        let found = input.variable.get(&run.instance)?;
        compare(&input.variable, &input.other, &found, report);
    }
    Ok(())
}

/// Parameters before the start, each in an instance of its own: it may not fit to the others. They are read in
/// initialization mode, before which FMI lets nobody read (4.2.4).
fn check_parameters(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let parameters = session.all("parameter");
    let starts = values(&session.initializing()?, &parameters)?;
    for (parameter, start) in parameters.iter().zip(&starts) {
        let Some(value) = other(parameter, start) else {
            continue;
        };
        let instance = session.instance()?;
        let set = parameter.set(&instance, &value);
        if set.and_then(|()| session.initialize(&instance)).is_ok() {
            compare(parameter, &value, &parameter.get(&instance)?, report);
        }
    }
    Ok(())
}

/// Nobody sets constants, not even before the start.
fn check_constants(session: &Session<'_>, report: &mut Report) -> Result<()> {
    for constant in session.constants() {
        let instance = session.initializing()?;
        let start = constant.get(&instance)?;
        let set = other(&constant, &start).map(|value| constant.set(&instance, &value));
        if set.is_some_and(|set| set.is_ok()) {
            let name = constant.name();
            report.warn("2.2.7", format!("{name} is a constant, but can be set"));
        }
    }
    Ok(())
}

fn settable<'a>(session: &Session<'a>) -> Vec<Variable<'a>> {
    [session.all("input"), session.all("parameter")].concat()
}

fn compare(variable: &Variable<'_>, set: &Value, found: &Value, report: &mut Report) {
    if !found.same(set) {
        let name = variable.name();
        report.error(
            "2.1.7",
            format!("{name} was set to {set}, then it is {found}"),
        );
    }
}

fn check_categories(session: &Session<'_>, report: &mut Report) -> Result<()> {
    for category in &session.description.log.categories {
        let instance = session.instance()?;
        if done(instance.log(&category.name)?).is_err() {
            let name = &category.name;
            report.error(
                "2.1.5",
                format!("fmi2SetDebugLogging refuses the log category {name}"),
            );
        }
    }
    Ok(())
}

fn check_memory(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let own = session.can(|can| can.own_memory);
    if own && session.instantiated_without_memory()?.is_none() {
        let text =
            "canNotUseMemoryManagementFunctions is true, but without them there is no instance";
        report.error("4.3.1", text);
    }
    Ok(())
}

/// fmi2CancelStep is for steps that are still being computed: there is none.
fn check_cancel(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let run = session.run()?;
    run.step(session.step())?;
    if run.instance.call(Transition::CancelStep)?.is_ok() {
        let text = "fmi2CancelStep returns fmi2OK though no step is being computed";
        report.warn("4.2.2", text);
    }
    Ok(())
}
