//! Variables of one type and value reference are one value under several names (FMI 2.0.4, 2.2.7).

use super::Report;
use super::parsed::{Attributes, Description, Kind, ScalarVariable};
use std::collections::HashMap;

/// A name with the attributes of its type.
type Name<'a> = (&'a ScalarVariable, &'a Attributes);

pub(super) fn check(description: &Description, report: &mut Report) {
    let mut sets: HashMap<(Kind, u32), Vec<Name<'_>>> = HashMap::new();
    for variable in description.variables() {
        let Some((kind, attributes)) = variable.kind() else {
            continue;
        };
        let known = sets.entry((kind, variable.value_reference)).or_default();
        let name = (variable, attributes);
        for &other in known.iter() {
            check_pair(other, name, report);
        }
        if adds(known, name) {
            known.push(name);
        }
    }
}

/// Whether a name has something to contradict that none of the `known` ones has.
///
/// There are three of them at most: all pairs of the names of one value would take the square of their number, and some
/// tools give all variables that are 0 one value.
fn adds(known: &[Name<'_>], name: Name<'_>) -> bool {
    let first = |has: fn(Name<'_>) -> bool| has(name) && !known.iter().any(|&other| has(other));
    known.is_empty() || first(is_settable) || first(|(_, attributes)| attributes.start.is_some())
}

fn check_pair(one: Name<'_>, other: Name<'_>, report: &mut Report) {
    let told = |text| format!("the aliases {} and {} {text}", one.0.name, other.0.name);
    let [start, another] = [one, other].map(|(_, attributes)| attributes.start.as_ref());
    let given = start.is_some() && another.is_some();
    let constants = [one, other].map(|(variable, _)| variable.is_constant());
    let errors = [
        (given && start != another, "start differently"),
        (is_settable(one) && is_settable(other), "can both be set"),
        (
            constants[0] != constants[1],
            "do not go together: one is a constant",
        ),
    ];
    for (_, text) in errors.iter().filter(|(wrong, _)| *wrong) {
        report.error("2.2.7", told(text));
    }
    let warnings = [
        (
            given && start == another && constants == [false; 2],
            "both have a start value",
        ),
        (one.1.unit != other.1.unit, "are one number in two units"),
    ];
    for (_, text) in warnings.iter().filter(|(wrong, _)| *wrong) {
        report.warn("2.2.7", told(text));
    }
}

fn is_settable((variable, _): Name<'_>) -> bool {
    matches!(variable.causality.as_str(), "input" | "parameter")
}

#[cfg(test)]
mod tests {
    use super::super::parsed::parse;
    use super::*;

    /// What is said of Reals a, b, c of one value reference, whose description is completed by these.
    fn findings(said: &[&str]) -> Vec<String> {
        let variable = |(name, said): (&str, &&str)| {
            format!("<ScalarVariable name=\"{name}\" valueReference=\"7\" {said}</ScalarVariable>")
        };
        let integer = ("n", &"causality=\"input\"><Integer start=\"1\"/>");
        let all = ["a", "b", "c"].into_iter().zip(said).chain([integer]);
        let text = format!(
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"A\" guid=\"g\"><ModelVariables>{}\
             </ModelVariables></fmiModelDescription>",
            all.map(variable).collect::<String>(),
        );
        let mut report = Report::default();
        check(&parse(&text).unwrap(), &mut report);
        let texts = report.findings.into_iter().map(|finding| finding.text);
        texts.collect()
    }

    #[test]
    fn names_of_one_value_that_agree_are_accepted() {
        let output = "causality=\"output\"><Real unit=\"m\"/>";
        let input = "causality=\"input\"><Real unit=\"m\" start=\"1\"/>";
        let constant = "variability=\"constant\"><Real start=\"1\"/>";
        for (one, other) in [(output, output), (input, output), (constant, constant)] {
            assert_eq!(findings(&[one, other]), Vec::<String>::new());
        }
    }

    #[test]
    fn names_of_one_value_that_contradict_each_other_are_told() {
        let input = "causality=\"input\"><Real start=\"1\"/>";
        let started = "initial=\"exact\"><Real start=\"1\"/>";
        let constant = "variability=\"constant\"><Real start=\"1\"/>";
        let another = "variability=\"constant\"><Real start=\"2\"/>";
        let metres = "><Real unit=\"m\"/>";
        let cases = [
            (constant, another, &["start differently"][..]),
            (input, started, &["both have a start value"]),
            (
                input,
                input,
                &["can both be set", "both have a start value"],
            ),
            (
                constant,
                "><Real/>",
                &["do not go together: one is a constant"],
            ),
            (metres, "><Real/>", &["are one number in two units"]),
        ];
        for (one, other, said) in cases {
            let said = said
                .iter()
                .map(|said| format!("the aliases a and b {said}"));
            assert_eq!(findings(&[one, other]), said.collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_name_is_compared_with_the_first_that_it_can_contradict() {
        let (plain, input) = ("><Real/>", "causality=\"input\"><Real start=\"1\"/>");
        let another = "initial=\"exact\"><Real start=\"2\"/>";
        let cases = [
            ([plain, input, another], &["b and c start differently"][..]),
            ([plain, another, input], &["b and c start differently"]),
            // Not b and c as well, nor more of them with every name.
            (
                [input; 3],
                &[
                    "a and b can both be set",
                    "a and b both have a start value",
                    "a and c can both be set",
                    "a and c both have a start value",
                ],
            ),
        ];
        for (names, said) in cases {
            let said = said.iter().map(|said| format!("the aliases {said}"));
            assert_eq!(findings(&names), said.collect::<Vec<_>>());
        }
    }
}
