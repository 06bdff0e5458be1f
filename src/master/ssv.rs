//! SSP parameter files (.ssv): values by variable name, in SI.

use crate::error::Error;
use crate::known_units;
use crate::plan::Value;
use crate::suggest::did_you_mean;
use roxmltree::{Document, Node};
use std::path::Path;

/// Values of a parameter file; those with a unit, which must be known by name, are converted.
pub fn read(path: &Path) -> Result<Vec<(String, Value)>, Error> {
    let text = std::fs::read_to_string(path).map_err(|error| Error::File {
        path: path.to_owned(),
        error,
    })?;
    parse(&text).map_err(|what| Error::Content {
        path: path.to_owned(),
        line: 0,
        what,
    })
}

fn parse(text: &str) -> Result<Vec<(String, Value)>, String> {
    let document = Document::parse(text).map_err(|error| format!("is not valid XML: {error}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "ParameterSet" {
        return Err(format!(
            "is no parameter set: its root is <{}>",
            root.tag_name().name()
        ));
    }
    let all = root
        .descendants()
        .filter(|node| node.tag_name().name() == "Parameter");
    all.map(|node| {
        let name = node.attribute("name").unwrap_or_default();
        let value = value(node).map_err(|what| format!("parameter '{name}': {what}"));
        Ok((name.to_owned(), value?))
    })
    .collect()
}

fn value(parameter: Node<'_, '_>) -> Result<Value, String> {
    let mut elements = parameter.children().filter(Node::is_element);
    let (Some(element), None) = (elements.next(), elements.next()) else {
        return Err("needs exactly one value".to_owned());
    };
    let text = element.attribute("value").unwrap_or_default();
    let kind = element.tag_name().name();
    let wrong = || format!("'{text}' is no {kind}");
    match (kind, text) {
        ("Real", _) => Ok(Value::Number(in_si(
            text.parse().map_err(|_| wrong())?,
            element.attribute("unit"),
        )?)),
        ("Integer", _) => Ok(Value::Number(
            text.parse::<i32>().map_err(|_| wrong())?.into(),
        )),
        ("Boolean", "true" | "1") => Ok(Value::Boolean(true)),
        ("Boolean", "false" | "0") => Ok(Value::Boolean(false)),
        ("String" | "Enumeration", _) => Ok(Value::Text(text.to_owned())),
        _ => Err(wrong()),
    }
}

fn in_si(value: f64, unit: Option<&str>) -> Result<f64, String> {
    let Some(name) = unit else { return Ok(value) };
    let unit = known_units::find(name).ok_or_else(|| {
        let known: Vec<_> = known_units::names().filter(|n| !n.is_empty()).collect();
        let hint = did_you_mean(name, known.iter().copied());
        format!(
            "the unit '{name}' is not known ({}){hint}",
            known.join(", ")
        )
    })?;
    Ok(unit.factor * value + unit.offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(element: &str) -> String {
        let text = format!(
            r#"<s:ParameterSet xmlns:s="x"><s:Parameters><s:Parameter name="p"><s:{element}/></s:Parameter></s:Parameters></s:ParameterSet>"#
        );
        match parse(&text) {
            Ok(values) => format!("{values:?}"),
            Err(what) => what,
        }
    }

    #[test]
    fn values_have_their_type_and_are_si() {
        for (element, expected) in [
            (r#"Real value="3""#, "Number(3.0)"),
            (
                r#"Real value="3" unit="mph""#,
                "the unit 'mph' is not known (1, -",
            ),
            (r#"Real value="5" unit="mm""#, "Number(0.005)"),
            (r#"Boolean value="true""#, "Boolean(true)"),
            (r#"Enumeration value="open""#, "Text(\"open\")"),
            (r#"Integer value="7""#, "Number(7.0)"),
            (
                r#"Integer value="1.5""#,
                "parameter 'p': '1.5' is no Integer",
            ),
            (
                r#"Real value="1"/><s:Real value="2""#,
                "needs exactly one value",
            ),
            (r#"Integer value="x""#, "parameter 'p': 'x' is no Integer"),
            (r#"Boolean value="2""#, "parameter 'p': '2' is no Boolean"),
        ] {
            assert!(
                told(element).contains(expected),
                "{element}: {}",
                told(element)
            );
        }
    }
}
