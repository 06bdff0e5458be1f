//! Parameter files: a preset as a parameter set of the SSP standard (`.ssv`), written from the tables of
//! the models and read back into them.

use crate::description::{finite, used};
use crate::drive::{is_whole, whole};
use crate::library;
use crate::xml::Element;
use crate::{Error, Result};
use dct_models::presets::{PRESETS, Parametrised, Preset};
use dct_models::{ClutchControl, Observer, Plant};
use fmi2_cosim::{Access, Model, Unit, Variable};
use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};
use std::path::PathBuf;

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

/// Every parameter file of `examples/closed_loop/parameters` with its text.
///
/// # Errors
/// When a number is not finite.
pub fn files() -> Result<Vec<(PathBuf, String)>> {
    let folder = library::workspace().join("examples/closed_loop/parameters");
    let components = [
        ("plant", presets::<Plant>()?),
        ("observer", shared::<Observer>()?),
        ("control", positions::<ClutchControl>()?),
    ];
    let files = components.into_iter().flat_map(|(component, sets)| {
        let folder = folder.clone();
        let path = move |name| folder.join(format!("{name}_{component}.ssv"));
        sets.into_iter().map(move |set| (path(set.name), set.text))
    });
    Ok(files.collect())
}

/// All presets for model `M`.
pub(crate) fn presets<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    PRESETS.iter().map(of_preset::<M>).collect()
}

/// The presets that differ in more than what the plant alone knows.
pub(crate) fn shared<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    let presets = PRESETS.iter().filter(|preset| !preset.of_plant);
    presets.map(of_preset::<M>).collect()
}

/// The presets whose clutches a position moves: a control that moves positions has no other.
pub(crate) fn positions<M: Parametrised>() -> Result<Vec<ParameterSet>> {
    let by_position = |preset: &&Preset| {
        let clutches = preset.params.clutch.iter();
        !preset.of_plant && clutches.clone().all(|one| one.piston_area == 0.0)
    };
    let presets = PRESETS.iter().filter(by_position);
    presets.map(of_preset::<M>).collect()
}

fn of_preset<M: Parametrised>(preset: &Preset) -> Result<ParameterSet> {
    Ok(ParameterSet {
        name: preset.name.into(),
        title: preset.title.into(),
        text: text::<M>(preset)?,
    })
}

/// The parameter set of a preset for model `M`.
///
/// # Errors
/// When a number is not finite.
pub fn text<M: Parametrised>(preset: &Preset) -> Result<String> {
    let mut model = M::of_preset(preset);
    set(preset.name, preset.title, &mut model, M::describes_vehicle)
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

/// Model `M` with the values of a parameter set that [`text`] wrote.
///
/// # Errors
/// [`Error::ParameterSet`] when it is no XML, or a parameter is not one of `M` or has no value of its type.
pub fn read<M: Parametrised>(text: &str) -> Result<M> {
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

fn assign<M: Parametrised>(model: &mut M, name: &str, value: &str) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn check<M: Parametrised>(preset: &Preset) -> M {
        let written = text::<M>(preset).unwrap();
        let mut back: M = read(&written).unwrap();
        let mut meant = M::of_preset(preset);
        let rows = M::VARIABLES.iter().filter(|row| M::describes_vehicle(row));
        let mut count = 0;
        for row in rows {
            let same = match row.access {
                Access::Real(field) => field(&mut back).to_bits() == field(&mut meant).to_bits(),
                Access::Boolean(field) => field(&mut back) == field(&mut meant),
                Access::Integer(field) | Access::Enumeration(field, _) => {
                    field(&mut back) == field(&mut meant)
                }
                Access::String(field) => field(&mut back) == field(&mut meant),
            };
            assert!(same, "{}", row.name);
            count += 1;
        }
        assert!(count > 40, "{count} parameters");
        back
    }

    #[test]
    fn every_preset_reads_back_bit_for_bit() {
        for preset in &PRESETS {
            let mut plant: Plant = check(preset);
            assert_eq!(plant.vehicle(), preset.params, "no parameter is missing");
            check::<Observer>(preset);
            check::<ClutchControl>(preset);
        }
    }

    #[test]
    fn a_set_that_does_not_fit_says_why() {
        let set =
            |inner: &str| format!("<ParameterSet><Parameters>{inner}</Parameters></ParameterSet>");
        let cases = [
            (
                "<Parameter name=\"no.such\"><Real value=\"1\"/></Parameter>",
                "no.such",
            ),
            (
                "<Parameter name=\"engine.inertia\"><Real value=\"x\"/></Parameter>",
                "engine.inertia = x",
            ),
            (
                "<Parameter name=\"engine.inertia\"><Real/></Parameter>",
                "attribute value",
            ),
            ("<Parameter", ""),
        ];
        for (inner, expected) in cases {
            let error = read::<Plant>(&set(inner)).err().expect(inner).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
