//! `ModelStructure`: which outputs depend on which variables.

use super::names::{self, Named};
use crate::{Error, Result};
use fmi2_cosim::{Causality, Initial, Variable};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct ModelStructure {
    #[serde(rename = "Outputs", skip_serializing_if = "Option::is_none")]
    outputs: Option<Unknowns>,
    #[serde(rename = "InitialUnknowns", skip_serializing_if = "Option::is_none")]
    initial_unknowns: Option<Unknowns>,
}

#[derive(Serialize)]
struct Unknowns {
    #[serde(rename = "Unknown")]
    unknowns: Vec<Unknown>,
}

#[derive(Serialize)]
struct Unknown {
    #[serde(rename = "@index")]
    index: usize,
    /// Absent: depends on everything. Empty: on nothing.
    #[serde(rename = "@dependencies", skip_serializing_if = "Option::is_none")]
    dependencies: Option<String>,
}

/// Outputs with what they depend on during the run, and at initialisation.
///
/// All outputs that are `calculated`, and so all but constants, are the initial unknowns too; locals are not, because
/// none of them is a continuous-time state (FMI 2.0.4, 2.2.8).
pub(super) fn model_structure<M>(rows: &[Variable<M>]) -> Result<ModelStructure> {
    let calculated = |named: &Named<'_, M>| named.initial() == Some(Initial::Calculated);
    Ok(ModelStructure {
        outputs: unknowns(rows, |_| true, |row| row.dependencies)?,
        initial_unknowns: unknowns(rows, calculated, |row| row.initial_dependencies)?,
    })
}

type Names = Option<&'static [&'static str]>;

fn unknowns<M>(
    rows: &[Variable<M>],
    wanted: impl Fn(&Named<'_, M>) -> bool,
    dependencies: impl Fn(&Variable<M>) -> Names,
) -> Result<Option<Unknowns>> {
    let unknowns = (1..)
        .zip(names::all(rows))
        .filter(|(_, named)| named.causality() == Causality::Output && wanted(named))
        .map(|(index, named)| {
            let dependencies = dependencies(named.row)
                .map(|names| indices(rows, named.name(), names))
                .transpose()?;
            Ok(Unknown {
                index,
                dependencies,
            })
        })
        .collect::<Result<Vec<_>>>()?;
    Ok((!unknowns.is_empty()).then_some(Unknowns { unknowns }))
}

/// Indices of the named rows, counted from 1, ascending, separated by blanks.
fn indices<M>(rows: &[Variable<M>], variable: &str, names: &[&str]) -> Result<String> {
    let index = |name: &&str| {
        rows.iter()
            .position(|row| row.name == *name)
            .map(|at| at + 1)
            .ok_or_else(|| Error::UnknownDependency {
                variable: variable.to_owned(),
                dependency: (*name).into(),
            })
    };
    let mut found = names.iter().map(index).collect::<Result<Vec<_>>>()?;
    found.sort_unstable();
    found.dedup();
    Ok(found
        .iter()
        .map(usize::to_string)
        .collect::<Vec<_>>()
        .join(" "))
}
