//! Rules that no validator covers: on roles, types, indices and the experiment.

use super::Report;
use super::parsed::{Attributes, Description, Kind, ScalarVariable, Unknown};
use std::collections::HashSet;

pub(super) fn check(description: &Description, report: &mut Report) {
    check_head(description, report);
    check_experiment(description, report);
    check_types(description, report);
    for variable in description.variables() {
        if let Some((kind, attributes)) = variable.kind() {
            check_role(variable, kind, report);
            check_numbers(description, variable, attributes, report);
            check_enumeration(description, variable, attributes, report);
        }
    }
    check_independents(description, report);
    check_structure(description, report);
}

fn check_head(description: &Description, report: &mut Report) {
    if description.guid.trim().is_empty() {
        report.error("2.2.1", "guid is empty");
    }
    if description.model_name.trim().is_empty() {
        report.error("2.2.1", "modelName is empty");
    }
    let Some(co_simulation) = &description.co_simulation else {
        return;
    };
    let identifier = &co_simulation.model_identifier;
    if !is_c_identifier(identifier) {
        report.error(
            "2.2.1",
            format!("modelIdentifier {identifier:?} is no C identifier"),
        );
    }
    if co_simulation.can_serialize && !co_simulation.can_save {
        report.error("4.3.1", "canSerializeFMUstate needs canGetAndSetFMUstate");
    }
    let names = description.log.categories.iter().map(|c| c.name.as_str());
    report_twice("2.2.4", "two log categories", names, report);
}

fn is_c_identifier(text: &str) -> bool {
    let legal = |c: char| c == '_' || c.is_ascii_alphanumeric();
    text.chars().all(legal) && !text.is_empty() && !text.starts_with(|c: char| c.is_ascii_digit())
}

fn report_twice<'a>(
    clause: &'static str,
    what: &str,
    names: impl Iterator<Item = &'a str>,
    report: &mut Report,
) {
    let mut seen = HashSet::new();
    for name in names.filter(|name| !seen.insert(*name)) {
        report.error(clause, format!("{what} are named {name}"));
    }
}

fn check_experiment(description: &Description, report: &mut Report) {
    let experiment = &description.experiment;
    let (start, stop) = (experiment.start.unwrap_or(0.0), experiment.stop);
    if stop.is_some_and(|stop| stop <= start || stop.is_nan()) {
        report.error(
            "2.2.5",
            format!("DefaultExperiment: the stop time is not above the start time {start}"),
        );
    }
    for (name, value) in [
        ("stepSize", experiment.step),
        ("tolerance", experiment.tolerance),
    ] {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
            report.error(
                "2.2.5",
                format!("DefaultExperiment: {name} = {value} is not above 0"),
            );
        }
    }
}

fn check_types(description: &Description, report: &mut Report) {
    report_twice("2.2.2", "two units", description.units(), report);
    let types = &description.types.types;
    let names = types.iter().map(|t| t.name.as_str());
    report_twice("2.2.3", "two types", names, report);
    for simple in types {
        let Some(enumeration) = &simple.enumeration else {
            continue;
        };
        let names = enumeration.items.iter().map(|item| item.name.as_str());
        report_twice(
            "2.2.3",
            &format!("two items of {}", simple.name),
            names,
            report,
        );
        let values: HashSet<_> = enumeration.items.iter().map(|item| item.value).collect();
        if values.len() < enumeration.items.len() {
            let name = &simple.name;
            report.error("2.2.3", format!("two items of {name} have the same value"));
        }
        if enumeration.items.is_empty() {
            report.error("2.2.3", format!("{} has no items", simple.name));
        }
    }
}

/// Which causality, variability and initial go together (FMI 2.0.4, 2.2.7, tables).
fn check_role(variable: &ScalarVariable, kind: Kind, report: &mut Report) {
    let name = &variable.name;
    let (causality, variability) = (variable.causality.as_str(), variable.variability.as_str());
    let legal: &[&str] = match causality {
        "parameter" | "calculatedParameter" => &["fixed", "tunable"],
        "input" => &["discrete", "continuous"],
        "output" => &["constant", "discrete", "continuous"],
        "local" => &["constant", "fixed", "tunable", "discrete", "continuous"],
        "independent" => &["continuous"],
        other => return report.error("2.2.7", format!("{name}: {other} is no causality")),
    };
    if !legal.contains(&variability) {
        report.error(
            "2.2.7",
            format!("{name}: no {causality} may be {variability}"),
        );
    }
    if variability == "continuous" && kind != Kind::Real {
        report.error("2.2.7", format!("{name} is continuous but no Real"));
    }
    let initial = variable.initial.as_deref();
    if matches!(causality, "input" | "independent") && initial.is_some() {
        report.error("2.2.7", format!("{name}: no {causality} has initial"));
    }
    let given = ["parameter", "constant"].into_iter();
    for given in given.filter(|given| [causality, variability].contains(given)) {
        if !matches!(initial, None | Some("exact")) {
            report.error("2.2.7", format!("{name}: initial of a {given} is exact"));
        }
    }
    if name.trim().is_empty() || name.contains(['\n', '\r']) {
        report.error("2.2.9", format!("{name:?} is no variable name"));
    }
}

fn check_numbers(
    description: &Description,
    variable: &ScalarVariable,
    attributes: &Attributes,
    report: &mut Report,
) {
    let name = &variable.name;
    if attributes
        .nominal
        .is_some_and(|nominal| nominal <= 0.0 || nominal.is_nan())
    {
        report.error("2.2.7", format!("{name}: nominal is not above 0"));
    }
    let limits = [attributes.min, attributes.max].into_iter().flatten();
    if limits.into_iter().any(f64::is_nan) {
        report.error("2.2.7", format!("{name}: a limit is no number"));
    }
    if attributes.display_unit.is_some() && attributes.unit.is_none() {
        report.error("2.2.7", format!("{name} has a displayUnit but no unit"));
    }
    let count = description.variables().len();
    if let Some(index) = attributes.derivative.filter(|i| !(1..=count).contains(i)) {
        report.error(
            "2.2.7",
            format!("{name}: derivative = {index} points at no variable"),
        );
    }
}

fn check_enumeration(
    description: &Description,
    variable: &ScalarVariable,
    attributes: &Attributes,
    report: &mut Report,
) {
    let name = &variable.name;
    let types = &description.types.types;
    let declared = attributes.declared_type.as_deref();
    let found = declared.and_then(|declared| types.iter().find(|t| t.name == declared));
    if let (Some(declared), None) = (declared, found) {
        return report.error(
            "2.2.7",
            format!("{name}: the type {declared} is not defined"),
        );
    }
    if !variable.is_enumeration() {
        return;
    }
    let Some(enumeration) = found.and_then(|found| found.enumeration.as_ref()) else {
        return report.error("2.2.7", format!("{name} names no enumeration"));
    };
    let start = attributes
        .start
        .as_deref()
        .and_then(|s| s.parse::<i32>().ok());
    if start.is_some_and(|start| enumeration.items.iter().all(|item| item.value != start)) {
        report.error(
            "2.2.7",
            format!("{name}: start is no value of its enumeration"),
        );
    }
}

fn check_independents(description: &Description, report: &mut Report) {
    let is_time = |variable: &&ScalarVariable| variable.causality == "independent";
    if description.variables().iter().filter(is_time).count() > 1 {
        report.error("2.2.7", "two variables are independent");
    }
}

fn check_structure(description: &Description, report: &mut Report) {
    let structure = &description.structure;
    let lists = [
        ("Outputs", &structure.outputs.unknowns),
        ("Derivatives", &structure.derivatives.unknowns),
        ("InitialUnknowns", &structure.initial_unknowns.unknowns),
    ];
    for (list, unknowns) in lists {
        let mut seen = HashSet::new();
        for unknown in unknowns {
            if !seen.insert(unknown.index) {
                report.error("2.2.8", format!("{list} lists {} twice", unknown.index));
            }
            check_kinds(list, unknown, report);
        }
    }
    refuse_set_unknowns(description, report);
    refuse_derivatives_of_nothing(description, report);
}

fn refuse_set_unknowns(description: &Description, report: &mut Report) {
    let set = |index: usize| {
        let variable = description.variables().get(index.wrapping_sub(1))?;
        let set = matches!(variable.causality.as_str(), "input" | "parameter");
        (set || variable.is_constant()).then_some(&variable.name)
    };
    let unknowns = &description.structure.initial_unknowns.unknowns;
    for name in unknowns.iter().filter_map(|unknown| set(unknown.index)) {
        let text = format!("InitialUnknowns: {name} is given, not computed");
        report.error("2.2.8", text);
    }
}

fn refuse_derivatives_of_nothing(description: &Description, report: &mut Report) {
    let count = description.variables().len();
    for unknown in &description.structure.derivatives.unknowns {
        if !(1..=count).contains(&unknown.index) {
            let index = unknown.index;
            let text = format!("Derivatives: the unknown {index} points at no variable");
            report.error("2.2.8", text);
        }
    }
}

fn check_kinds(list: &str, unknown: &Unknown, report: &mut Report) {
    let Some(kinds) = &unknown.dependencies_kind else {
        return;
    };
    let index = unknown.index;
    let named = unknown.dependencies.as_deref().unwrap_or_default();
    if kinds.split_whitespace().count() != named.split_whitespace().count() {
        report.error(
            "2.2.8",
            format!("{list}: dependenciesKind of {index} has another length than dependencies"),
        );
    }
    const KINDS: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];
    if let Some(kind) = kinds.split_whitespace().find(|kind| !KINDS.contains(kind)) {
        report.error("2.2.8", format!("{list}: {kind} is no dependenciesKind"));
    }
}
