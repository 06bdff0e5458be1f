//! `VARIABLES.md`: the tables of all models for people, one section each.

use crate::description::{causality, limit, starts, variability};
use crate::models::MODELS;
use crate::{Error, Result};
use fmi2_cosim::{Access, Model, Variable};
use std::fmt::Write as _;

const HEADER: &str = "# Variables of the FMUs

Written by `cargo fmu describe` from the tables in `src/models`; do not edit.

Units are SI; in brackets the unit a tool shows. *vr* is the value reference. Start values are given
for what an importer may set; everything else is computed by the model.
";

/// The text of `VARIABLES.md`.
///
/// # Errors
/// When a start value is not finite.
pub fn text() -> Result<String> {
    let mut text = String::from(HEADER);
    for entry in MODELS {
        text.push('\n');
        text.push_str(&(entry.table)()?);
    }
    Ok(text)
}

/// The section of model `M`: a heading, its sentence and one row per variable.
pub(crate) fn table<M: Model>() -> Result<String> {
    let mut text = format!("## {}\n\n{}\n\n", M::NAME, M::DESCRIPTION);
    text.push_str("| vr | name | causality | variability | type | start | min | max | depends on | description |\n");
    text.push_str("|--:|---|---|---|---|--:|--:|--:|---|---|\n");
    for ((at, row), start) in M::VARIABLES.iter().enumerate().zip(starts::<M>()?) {
        let start = start.unwrap_or_default();
        writeln!(text, "| {at} | {} |", cells(row, start)?.join(" | ")).map_err(Error::Format)?;
    }
    Ok(text)
}

fn cells<M>(row: &Variable<M>, start: String) -> Result<[String; 9]> {
    Ok([
        format!("`{}`", row.name),
        causality(row.causality).into(),
        variability(row.variability).into(),
        kind(row),
        start,
        limit(row, "min", row.min)?.unwrap_or_default(),
        limit(row, "max", row.max)?.unwrap_or_default(),
        dependencies(row),
        row.description.replace('|', "\\|"),
    ])
}

fn kind<M>(row: &Variable<M>) -> String {
    match (row.access, row.unit.display.first()) {
        (Access::Real(_), None) => row.unit.name.into(),
        (Access::Real(_), Some(shown)) => format!("{} [{}]", row.unit.name, shown.name),
        (Access::Integer(_), _) => "Integer".into(),
        (Access::Boolean(_), _) => "Boolean".into(),
        (Access::Enumeration(_, kind), _) => {
            let items = kind
                .items
                .iter()
                .map(|item| format!("{} = {}", item.name, item.value));
            format!("{} {{{}}}", kind.name, items.collect::<Vec<_>>().join(", "))
        }
    }
}

/// What an output feeds through at a communication point.
fn dependencies<M>(row: &Variable<M>) -> String {
    match row.dependencies {
        None => String::new(),
        Some([]) => "states only".into(),
        Some(names) => names
            .iter()
            .map(|name| format!("`{name}`"))
            .collect::<Vec<_>>()
            .join(", "),
    }
}
