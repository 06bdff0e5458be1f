//! SSP parameter files (.ssv): values by variable name, in SI.

use crate::description::Description;
use crate::error::Error;
use crate::plan::Value;
use roxmltree::{Document, Node};
use std::path::Path;

/// Values of a parameter file; those with a unit are converted by the FMU's definition of it.
pub fn read(path: &Path, description: &Description) -> Result<Vec<(String, Value)>, Error> {
    let text = std::fs::read_to_string(path).map_err(|error| Error::File {
        path: path.to_owned(),
        error,
    })?;
    parse(&text, description).map_err(|what| Error::Content {
        path: path.to_owned(),
        line: 0,
        what,
    })
}

fn parse(text: &str, description: &Description) -> Result<Vec<(String, Value)>, String> {
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
        let value = value(node, description).map_err(|what| format!("parameter '{name}': {what}"));
        Ok((name.to_owned(), value?))
    })
    .collect()
}

fn value(parameter: Node<'_, '_>, description: &Description) -> Result<Value, String> {
    let element = parameter
        .children()
        .find(Node::is_element)
        .ok_or("needs a value")?;
    let text = element.attribute("value").unwrap_or_default();
    let kind = element.tag_name().name();
    let number = || {
        text.parse::<f64>()
            .map_err(|_| format!("'{text}' is no {kind}"))
    };
    match (kind, text) {
        ("Real", _) => Ok(Value::Number(in_si(
            number()?,
            element.attribute("unit"),
            description,
        )?)),
        ("Integer", _) => Ok(Value::Number(number()?)),
        ("Boolean", "true" | "1") => Ok(Value::Boolean(true)),
        ("Boolean", "false" | "0") => Ok(Value::Boolean(false)),
        ("String" | "Enumeration", _) => Ok(Value::Text(text.to_owned())),
        _ => Err(format!("'{text}' is no {kind}")),
    }
}

fn in_si(value: f64, unit: Option<&str>, description: &Description) -> Result<f64, String> {
    let Some(name) = unit else { return Ok(value) };
    let unit = description.units.get(name);
    let unit = unit.ok_or_else(|| format!("the FMU does not define the unit '{name}'; give SI"))?;
    Ok(unit.factor * value + unit.offset)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Unit;

    fn told(element: &str) -> String {
        let mut description = Description::default();
        let rpm = Unit {
            name: "rpm".into(),
            exponents: [0; 8],
            factor: 0.5,
            offset: 1.0,
        };
        description.units.insert("rpm".into(), rpm);
        let text = format!(
            r#"<s:ParameterSet xmlns:s="x"><s:Parameters><s:Parameter name="p"><s:{element}/></s:Parameter></s:Parameters></s:ParameterSet>"#
        );
        match parse(&text, &description) {
            Ok(values) => format!("{values:?}"),
            Err(what) => what,
        }
    }

    #[test]
    fn values_have_their_type_and_are_si() {
        for (element, expected) in [
            (r#"Real value="3""#, "Number(3.0)"),
            (r#"Real value="3" unit="rpm""#, "Number(2.5)"),
            (
                r#"Real value="3" unit="mph""#,
                "does not define the unit 'mph'",
            ),
            (r#"Boolean value="true""#, "Boolean(true)"),
            (r#"Enumeration value="open""#, "Text(\"open\")"),
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
