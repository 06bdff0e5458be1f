//! `ModelStructure`: which outputs depend on which variables.

use crate::{Error, Result};
use fmi2_cosim::{Causality, Variable};
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
/// All outputs are `calculated`, so they are the initial unknowns too; locals are not, because
/// none of them is a continuous-time state (FMI 2.0.4, 2.2.8).
pub(super) fn model_structure<M>(rows: &[Variable<M>]) -> Result<ModelStructure> {
    Ok(ModelStructure {
        outputs: unknowns(rows, |row| row.dependencies)?,
        initial_unknowns: unknowns(rows, |row| row.initial_dependencies)?,
    })
}

type Names = Option<&'static [&'static str]>;

fn unknowns<M>(
    rows: &[Variable<M>],
    names: impl Fn(&Variable<M>) -> Names,
) -> Result<Option<Unknowns>> {
    let unknowns = (1..)
        .zip(rows)
        .filter(|(_, row)| row.causality == Causality::Output)
        .map(|(index, row)| {
            let dependencies = names(row)
                .map(|names| indices(rows, row.name, names))
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
