//! Parameter sets of the SSP standard (`.ssv`), written from the tables of the models and read back into them.

use crate::description::{finite, used};
use crate::drive::{is_whole, whole};
use crate::xml::Element;
use crate::{Error, Result};
use fmi2_cosim::{Access, Model, Unit, Variable};
use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};

const VALUES: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";

/// A parameter set: a file that tools apply to an FMU as it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterSet {
    /// Name, and that of its file.
    pub name: String,
    /// What it is, in a few words.
    pub title: String,
    /// The text of the file.
    pub text: String,
}

/// The values that `model` has in the rows that `wanted` tells, as a parameter set.
///
/// # Errors
/// When a number is not finite.
pub fn set<M: Model>(
    name: &str,
    title: &str,
    model: &mut M,
    wanted: impl Fn(&Variable<M>) -> bool,
) -> Result<String> {
    let rows: Vec<_> = M::VARIABLES.iter().filter(|row| wanted(row)).collect();
    let values = rows.iter().map(|row| parameter(row, model));
    let set = Element::new("ssv:ParameterSet")
        .with("xmlns:ssv", VALUES)
        .with("xmlns:ssc", COMMON)
        .with("version", "1.0")
        .with("name", name)
        .with("description", title)
        .holding([Element::new("ssv:Parameters").holding(values.collect::<Result<Vec<_>>>()?)])
        .holding([Element::new("ssv:Units").holding(units(&rows))]);
    Ok(set.document())
}

/// Names with values.
pub(crate) type Values<'a> = &'a [(&'a str, f64)];

/// A set of these parameters of `M` with these values.
pub(crate) fn given<M: Model>(name: &str, values: Values<'_>) -> Result<String> {
    let mut model = M::default();
    for (name, value) in values {
        let row = M::VARIABLES.iter().find(|row| row.name == *name);
        let row = row.ok_or_else(|| refused(format!("{name} is no variable of {}", M::NAME)))?;
        match row.access {
            Access::Real(field) => *field(&mut model) = *value,
            Access::Boolean(field) => *field(&mut model) = *value != 0.0,
            Access::Integer(field) | Access::Enumeration(field, _) => {
                if !is_whole(*value) {
                    return Err(refused(format!("{name} = {value} is no Integer")));
                }
                *field(&mut model) = whole(*value);
            }
            Access::String(_) => return Err(refused(format!("{name} is a String"))),
        }
    }
    let named = |row: &Variable<M>| values.iter().any(|(name, _)| *name == row.name);
    set(name, "", &mut model, named)
}

fn parameter<M>(row: &Variable<M>, model: &mut M) -> Result<Element> {
    let value = match row.access {
        Access::Real(field) => Element::new("ssv:Real")
            .with("value", finite(row.name, "value", *field(model))?)
            .with("unit", row.unit.name),
        Access::Integer(field) => Element::new("ssv:Integer").with("value", field(model)),
        Access::Enumeration(field, _) => Element::new("ssv:Integer").with("value", field(model)),
        Access::Boolean(field) => Element::new("ssv:Boolean").with("value", field(model)),
        Access::String(field) => Element::new("ssv:String").with("value", field(model)),
    };
    Ok(Element::new("ssv:Parameter")
        .with("name", row.name)
        .with("description", row.description)
        .holding([value]))
}

fn units<M>(rows: &[&Variable<M>]) -> Vec<Element> {
    let element = |unit: &Unit| {
        let base = Unit::BASE
            .iter()
            .zip(unit.exponents)
            .filter(|(_, exponent)| *exponent != 0)
            .fold(Element::new("ssc:BaseUnit"), |base, (name, exponent)| {
                base.with(name, exponent)
            });
        Element::new("ssc:Unit")
            .with("name", unit.name)
            .holding([base])
    };
    used(rows).iter().map(element).collect()
}

/// Model `M` with the values of a parameter set that [`set`] wrote.
///
/// # Errors
/// [`Error::ParameterSet`] when it is no XML, or a parameter is not one of `M` or has no value of its type.
pub fn read<M: Model>(text: &str) -> Result<M> {
    let mut model = M::default();
    let mut reader = Reader::from_str(text);
    let mut name = String::new();
    loop {
        let event = reader
            .read_event()
            .map_err(|error| refused(error.to_string()))?;
        match event {
            Event::Eof => return Ok(model),
            Event::Start(tag) if tag.local_name().as_ref() == "Parameter" => {
                name = attribute(&tag, "name")?;
            }
            Event::Empty(tag) if is_value(&tag) => {
                assign(&mut model, &name, &attribute(&tag, "value")?)?
            }
            _ => {}
        }
    }
}

fn is_value(tag: &BytesStart<'_>) -> bool {
    matches!(
        tag.local_name().as_ref(),
        "Real" | "Integer" | "Boolean" | "String"
    )
}

fn attribute(tag: &BytesStart<'_>, name: &str) -> Result<String> {
    let found = tag.try_get_attribute(name).ok().flatten();
    let found = found.ok_or_else(|| refused(format!("an element has no attribute {name}")))?;
    let value = unescape(&found.value).map_err(|error| refused(error.to_string()))?;
    Ok(value.into_owned())
}

fn assign<M: Model>(model: &mut M, name: &str, value: &str) -> Result<()> {
    let row = M::VARIABLES.iter().find(|row| row.name == name);
    let row = row.ok_or_else(|| refused(format!("{name} is no variable of {}", M::NAME)))?;
    let read = match row.access {
        Access::Real(field) => value.parse().map(|value| *field(model) = value).is_ok(),
        Access::Boolean(field) => value.parse().map(|value| *field(model) = value).is_ok(),
        Access::Integer(field) | Access::Enumeration(field, _) => {
            value.parse().map(|value| *field(model) = value).is_ok()
        }
        Access::String(field) => {
            value.clone_into(field(model));
            true
        }
    };
    if read {
        Ok(())
    } else {
        let kind = row.access.type_name();
        Err(refused(format!("{name} = {value} is no {kind}")))
    }
}

const fn refused(fault: String) -> Error {
    Error::ParameterSet { fault }
}
