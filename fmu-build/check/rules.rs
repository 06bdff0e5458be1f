//! Rules on the model description alone that the XML schema cannot express.

use super::Report;
use super::parsed::{Attributes, Description, Kind, ScalarVariable, Unknown};
use std::collections::HashSet;

pub(super) fn check(description: &Description, report: &mut Report) {
    if description.fmi_version != "2.0" {
        report.error(
            "2.2.1",
            format!("fmiVersion is {:?}, not \"2.0\"", description.fmi_version),
        );
    }
    if description.co_simulation.is_none() {
        report.error("2.2.1", "there is no CoSimulation element");
    }
    let mut names = HashSet::new();
    for variable in description.variables() {
        if !names.insert(&variable.name) {
            report.error(
                "2.2.7",
                format!("two variables are named {}", variable.name),
            );
        }
        check_variable(description, variable, report);
    }
    check_structure(description, report);
}

fn check_variable(description: &Description, variable: &ScalarVariable, report: &mut Report) {
    let name = &variable.name;
    let Some((kind, attributes)) = variable.kind() else {
        return report.error("2.2.7", format!("{name} has no type"));
    };
    if let Some(unit) = attributes
        .unit
        .as_ref()
        .filter(|unit| !description.has_unit(unit))
    {
        report.error("2.2.2", format!("the unit {unit} of {name} is not defined"));
    }
    check_presence(variable, attributes, report);
    check_range(name, kind, attributes, report);
}

fn check_presence(variable: &ScalarVariable, attributes: &Attributes, report: &mut Report) {
    let name = &variable.name;
    let initial = variable.initial.as_deref();
    let needs_start = matches!(variable.causality.as_str(), "input" | "parameter")
        || variable.is_constant()
        || matches!(initial, Some("exact" | "approx"));
    match &attributes.start {
        None if needs_start => report.error("2.2.7", format!("{name} needs a start value")),
        Some(_) if initial == Some("calculated") => {
            report.error(
                "2.2.7",
                format!("{name} is calculated, so it may have no start value"),
            );
        }
        _ => {}
    }
}

fn check_range(name: &str, kind: Kind, attributes: &Attributes, report: &mut Report) {
    let min = attributes.min.unwrap_or(f64::NEG_INFINITY);
    let max = attributes.max.unwrap_or(f64::INFINITY);
    if min > max {
        report.error("2.2.7", format!("{name}: min = {min} is above max = {max}"));
    }
    let Some(start) = attributes.start.as_ref().filter(|_| is_number(kind)) else {
        return;
    };
    match start.parse::<f64>() {
        Err(_) => report.error(
            "2.2.7",
            format!("{name}: start = {start:?} is not a number"),
        ),
        Ok(start) if !(min..=max).contains(&start) => {
            report.error(
                "2.2.7",
                format!("{name}: start = {start} is outside {min} … {max}"),
            );
        }
        Ok(_) => {}
    }
}

fn is_number(kind: Kind) -> bool {
    matches!(kind, Kind::Real | Kind::Integer)
}

fn check_structure(description: &Description, report: &mut Report) {
    let structure = &description.structure;
    let listed: HashSet<usize> = structure.outputs.unknowns.iter().map(|u| u.index).collect();
    for (index, variable) in (1..).zip(description.variables()) {
        if (variable.causality == "output") != listed.contains(&index) {
            let name = &variable.name;
            report.error(
                "2.2.8",
                format!("Outputs must list all outputs and no others: {name}"),
            );
        }
    }
    let count = description.variables().len();
    check_unknowns("Outputs", &structure.outputs.unknowns, count, report);
    let initial = &structure.initial_unknowns.unknowns;
    check_unknowns("InitialUnknowns", initial, count, report);
    if !initial.is_sorted_by(|a, b| a.index < b.index) {
        report.error("2.2.8", "InitialUnknowns are not in ascending order");
    }
}

fn check_unknowns(list: &str, unknowns: &[Unknown], count: usize, report: &mut Report) {
    for unknown in unknowns {
        let dependencies = unknown.dependencies.as_deref().unwrap_or_default();
        let indices: Option<Vec<usize>> = dependencies
            .split_whitespace()
            .map(|index| index.parse().ok())
            .collect();
        let legal = |index: &usize| (1..=count).contains(index);
        let index = unknown.index;
        if !legal(&index) || !indices.is_some_and(|indices| indices.iter().all(legal)) {
            report.error(
                "2.2.8",
                format!("{list}: the unknown {index} points at no variable"),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parsed::parse;
    use super::*;

    const GOOD: &str = r#"<?xml version="1.0"?>
<fmiModelDescription fmiVersion="2.0" modelName="A" guid="g">
  <CoSimulation modelIdentifier="A"/>
  <UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input">
      <Real unit="m" min="0" max="1" start="0.5"/>
    </ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output" initial="calculated">
      <Real unit="m"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="1"/></Outputs>
    <InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>"#;

    fn findings(text: &str) -> Vec<String> {
        let mut report = Report::default();
        check(&parse(text).unwrap(), &mut report);
        report.findings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_sound_description_has_no_findings() {
        assert_eq!(findings(GOOD), Vec::<String>::new());
    }

    #[test]
    fn every_broken_rule_is_found_and_named() {
        let cases = [
            (
                "fmiVersion=\"2.0\"",
                "fmiVersion=\"3.0\"",
                "fmiVersion is \"3.0\"",
            ),
            (
                "<CoSimulation modelIdentifier=\"A\"/>",
                "",
                "no CoSimulation element",
            ),
            ("name=\"y\"", "name=\"u\"", "two variables are named u"),
            (
                "<Unit name=\"m\">",
                "<Unit name=\"mm\">",
                "the unit m of u is not defined",
            ),
            (" start=\"0.5\"", "", "u needs a start value"),
            ("start=\"0.5\"", "start=\"2\"", "start = 2 is outside 0 … 1"),
            (
                "start=\"0.5\"",
                "start=\"a\"",
                "start = \"a\" is not a number",
            ),
            (
                "<Real unit=\"m\"/>",
                "<Real unit=\"m\" start=\"1\"/>",
                "y is calculated",
            ),
            (
                "dependencies=\"1\"",
                "dependencies=\"3\"",
                "the unknown 2 points at no variable",
            ),
            (
                "<Outputs><Unknown index=\"2\"",
                "<Outputs><Unknown index=\"1\"",
                "and no others: u",
            ),
        ];
        for (sound, broken, expected) in cases {
            let text = GOOD.replacen(sound, broken, 1);
            assert_ne!(text, GOOD, "{sound} is not in the description");
            let found = findings(&text);
            assert!(
                found.iter().any(|finding| finding.contains(expected)),
                "{expected}: {found:?}"
            );
        }
    }

    #[test]
    fn limits_that_exclude_each_other_are_found() {
        let found = findings(&GOOD.replace("min=\"0\"", "min=\"3\""));
        assert!(
            found[0].contains("u: min = 3 is above max = 1"),
            "{found:?}"
        );
    }
}
