//! `ModelVariables`: one `ScalarVariable` per name; the start values are read from the model.

use super::names::{self, Named};
use super::number::{finite, integer, optional};
use crate::Result;
use fmi2_cosim::{Access, Causality, Initial, Model, Variability, Variable};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct ModelVariables {
    #[serde(rename = "ScalarVariable")]
    variables: Vec<ScalarVariable>,
}

#[derive(Serialize)]
struct ScalarVariable {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@valueReference")]
    value_reference: usize,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "@causality")]
    causality: &'static str,
    #[serde(rename = "@variability")]
    variability: &'static str,
    #[serde(rename = "@initial", skip_serializing_if = "Option::is_none")]
    initial: Option<&'static str>,
    #[serde(rename = "$value")]
    kind: Kind,
}

#[derive(Serialize)]
enum Kind {
    Real(RealType),
    Integer(IntegerType),
    Boolean(StartType),
    Enumeration(IntegerType),
    String(StartType),
}

#[derive(Serialize)]
struct RealType {
    #[serde(rename = "@unit")]
    unit: &'static str,
    #[serde(rename = "@displayUnit", skip_serializing_if = "Option::is_none")]
    display_unit: Option<&'static str>,
    #[serde(
        rename = "@relativeQuantity",
        skip_serializing_if = "std::ops::Not::not"
    )]
    relative: bool,
    #[serde(rename = "@min", skip_serializing_if = "Option::is_none")]
    min: Option<String>,
    #[serde(rename = "@max", skip_serializing_if = "Option::is_none")]
    max: Option<String>,
    #[serde(rename = "@nominal", skip_serializing_if = "Option::is_none")]
    nominal: Option<String>,
    #[serde(rename = "@start", skip_serializing_if = "Option::is_none")]
    start: Option<String>,
}

#[derive(Serialize)]
struct IntegerType {
    #[serde(rename = "@declaredType", skip_serializing_if = "Option::is_none")]
    declared_type: Option<&'static str>,
    #[serde(rename = "@min", skip_serializing_if = "Option::is_none")]
    min: Option<String>,
    #[serde(rename = "@max", skip_serializing_if = "Option::is_none")]
    max: Option<String>,
    #[serde(rename = "@start", skip_serializing_if = "Option::is_none")]
    start: Option<String>,
}

#[derive(Serialize)]
struct StartType {
    #[serde(rename = "@start", skip_serializing_if = "Option::is_none")]
    start: Option<String>,
}

/// Start value of a row as the description shows it; `None` where the model computes it.
pub(crate) type Start = Option<String>;

/// All variables with their start values, read from the model through its accessors.
pub(crate) fn started<M: Model>() -> Result<Vec<(Named<'static, M>, Start)>> {
    let mut model = M::default();
    let started = |named: Named<'static, M>| {
        let start = start(&named, &mut model)?;
        Ok((named, start))
    };
    names::all(M::VARIABLES).map(started).collect()
}

fn start<M>(named: &Named<'_, M>, model: &mut M) -> Result<Start> {
    if named.initial() == Some(Initial::Calculated) {
        return Ok(None);
    }
    let row = named.row;
    let text = match row.access {
        Access::Real(field) => finite(row.name, "start", *field(model))?,
        Access::Integer(field) | Access::Enumeration(field, _) => field(model).to_string(),
        Access::Boolean(field) => field(model).to_string(),
        Access::String(field) => field(model).clone(),
    };
    Ok(Some(text))
}

pub(super) fn model_variables<M: Model>() -> Result<ModelVariables> {
    let variables = started::<M>()?.into_iter();
    let variables = variables.map(|(named, start)| scalar_variable(&named, start));
    Ok(ModelVariables {
        variables: variables.collect::<Result<_>>()?,
    })
}

fn scalar_variable<M>(named: &Named<'_, M>, start: Start) -> Result<ScalarVariable> {
    Ok(ScalarVariable {
        name: named.name(),
        value_reference: named.reference,
        description: named.description(),
        causality: causality(named.causality()),
        variability: variability(named.row.variability),
        initial: named.initial().map(initial),
        kind: kind(named.row, start)?,
    })
}

fn kind<M>(row: &Variable<M>, start: Start) -> Result<Kind> {
    Ok(match row.access {
        Access::Real(_) => Kind::Real(real(row, start)?),
        Access::Integer(_) => Kind::Integer(whole(row, None, start)?),
        Access::Boolean(_) => Kind::Boolean(StartType { start }),
        Access::Enumeration(_, kind) => Kind::Enumeration(whole(row, Some(kind.name), start)?),
        Access::String(_) => Kind::String(StartType { start }),
    })
}

fn real<M>(row: &Variable<M>, start: Start) -> Result<RealType> {
    Ok(RealType {
        unit: row.unit.name,
        display_unit: row.unit.display.first().map(|shown| shown.name),
        relative: row.relative,
        min: limit(row, "min", row.min)?,
        max: limit(row, "max", row.max)?,
        nominal: optional(row.name, "nominal", row.nominal)?,
        start,
    })
}

fn whole<M>(
    row: &Variable<M>,
    declared_type: Option<&'static str>,
    start: Start,
) -> Result<IntegerType> {
    Ok(IntegerType {
        declared_type,
        min: limit(row, "min", row.min)?,
        max: limit(row, "max", row.max)?,
        start,
    })
}

/// A limit of a row as text of its type.
pub(crate) fn limit<M>(
    row: &Variable<M>,
    what: &'static str,
    value: Option<f64>,
) -> Result<Option<String>> {
    match row.access {
        Access::Real(_) => optional(row.name, what, value),
        _ => integer(row.name, what, value),
    }
}

pub(crate) fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

pub(crate) fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
        Variability::Constant => "constant",
    }
}

fn initial(initial: Initial) -> &'static str {
    match initial {
        Initial::Exact => "exact",
        Initial::Calculated => "calculated",
    }
}
