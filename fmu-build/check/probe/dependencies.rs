//! Which outputs change at once with an input: no others than those that ModelStructure names.

use super::super::Report;
use super::super::parsed::Unknown;
use super::session::{Session, Variable, values};
use super::stimuli::{Nudge, Stimuli, other};
use super::value::Value;
use crate::Result;

/// Steps before inputs are moved.
const BEFORE: usize = 6;

pub(super) fn check(session: &Session<'_>, report: &mut Report) -> Result<()> {
    check_outputs(session, report)?;
    check_initial(session, report)
}

/// At a communication point.
fn check_outputs(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let unknowns = &session.description.structure.outputs.unknowns;
    let stimuli = Stimuli::of(session)?;
    let run = session.run()?;
    stimuli.record(&run, 0..BEFORE)?;
    for Nudge {
        variable: known,
        start,
        other,
    } in &stimuli.inputs
    {
        let now = known.get(&run.instance)?;
        let moved = if now.same(other) { start } else { other };
        let before = values(&run.instance, &stimuli.outputs)?;
        known.set(&run.instance, moved)?;
        let after = values(&run.instance, &stimuli.outputs)?;
        known.set(&run.instance, &now)?;
        for name in silent(unknowns, known, &stimuli.outputs, &before, &after) {
            let text = format!(
                "{name} changes at once with {}, which is not among its dependencies",
                known.name()
            );
            report.error("2.2.8", text);
        }
    }
    Ok(())
}

/// In initialization mode, where parameters count, too.
fn check_initial(session: &Session<'_>, report: &mut Report) -> Result<()> {
    let unknowns = &session.description.structure.initial_unknowns.unknowns;
    if unknowns
        .iter()
        .all(|unknown| unknown.dependencies.is_none())
    {
        return Ok(());
    }
    let computed = [session.all("output"), session.all("calculatedParameter")].concat();
    let knowns = [session.all("input"), session.all("parameter")].concat();
    let mut instance = session.initializing()?;
    for known in knowns {
        let start = known.get(&instance)?;
        let before = values(&instance, &computed)?;
        let Some(moved) = other(&known, &start) else {
            continue;
        };
        let after = known
            .set(&instance, &moved)
            .and_then(|()| values(&instance, &computed));
        let Ok(after) = after else {
            // Alone, this value does not fit to the others; after fmi2Error an instance is of no use.
            drop(instance);
            instance = session.initializing()?;
            continue;
        };
        for name in silent(unknowns, &known, &computed, &before, &after) {
            let text = format!(
                "{name} starts elsewhere with another {}, which is not among its dependencies in InitialUnknowns",
                known.name()
            );
            report.error("2.2.8", text);
        }
        known.set(&instance, &start)?;
    }
    Ok(())
}

/// The variables that changed though they name their dependencies and `known` is not among them.
fn silent<'a>(
    unknowns: &[Unknown],
    known: &Variable<'_>,
    computed: &[Variable<'a>],
    before: &[Value],
    after: &[Value],
) -> Vec<&'a str> {
    let pairs = computed.iter().zip(before.iter().zip(after));
    let changed = pairs.filter(|(_, (before, after))| !before.same(after));
    let undeclared = changed.filter(|(variable, _)| {
        let unknown = unknowns
            .iter()
            .find(|unknown| unknown.index == variable.index);
        unknown.is_some_and(|unknown| !unknown.may_depend_on(known.index))
    });
    undeclared.map(|(variable, _)| variable.name()).collect()
}
