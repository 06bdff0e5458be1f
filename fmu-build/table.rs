//! The table of a model as text for people, whatever it is written into.

use crate::Result;
use crate::description::names::Named;
use crate::description::{capabilities, causality, finite, limit, started, variability};
use fmi2_cosim::{Access, Enumeration, Model, Variable};

/// Headings of the columns.
pub(crate) const COLUMNS: [&str; 10] = [
    "vr",
    "name",
    "causality",
    "variability",
    "type",
    "start",
    "min",
    "max",
    "depends on",
    "description",
];

/// What the columns mean, for the top of a page.
pub(crate) const LEGEND: &str = "Units are SI; in brackets the unit a tool shows. vr is the value \
     reference. Start values are given for what an importer may set, and for constants; the model computes the rest.";

/// What a model's page shows of it.
pub(crate) struct Sheet {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    pub(crate) version: &'static str,
    pub(crate) license: &'static str,
    pub(crate) guid: String,
    /// Start, stop and step [s].
    pub(crate) experiment: [String; 3],
    /// What importers may do beyond the least of the standard.
    pub(crate) capabilities: Vec<&'static str>,
    pub(crate) rows: Vec<[String; 10]>,
    /// Those that some variable has.
    pub(crate) enumerations: Vec<&'static Enumeration>,
}

impl Sheet {
    /// The sheet of model `M`.
    pub(crate) fn of_model<M: Model>() -> Result<Self> {
        let seconds = |what, value| finite("DefaultExperiment", what, value);
        let mut enumerations: Vec<&'static Enumeration> = Vec::new();
        for row in M::VARIABLES {
            match row.access {
                Access::Enumeration(_, kind) if !enumerations.contains(&kind) => {
                    enumerations.push(kind);
                }
                _ => {}
            }
        }
        Ok(Self {
            name: M::NAME,
            description: M::DESCRIPTION,
            version: M::VERSION,
            license: M::LICENSE,
            guid: fmi2_cosim::guid::<M>(),
            experiment: [
                seconds("startTime", M::EXPERIMENT.start)?,
                seconds("stopTime", M::EXPERIMENT.stop)?,
                seconds("stepSize", M::EXPERIMENT.step)?,
            ],
            capabilities: capabilities::<M>(),
            rows: rows::<M>()?,
            enumerations,
        })
    }

    /// Rows of a causality.
    pub(crate) fn of(&self, causality: &str) -> impl Iterator<Item = &[String; 10]> {
        self.rows.iter().filter(move |row| row[2] == causality)
    }
}

/// One row per variable, cells as in [`COLUMNS`].
pub(crate) fn rows<M: Model>() -> Result<Vec<[String; 10]>> {
    let rows = started::<M>()?.into_iter();
    rows.map(|(named, start)| cells(&named, start.unwrap_or_default()))
        .collect()
}

fn cells<M>(named: &Named<'_, M>, start: String) -> Result<[String; 10]> {
    let row = named.row;
    Ok([
        named.reference.to_string(),
        named.name().into(),
        causality(named.causality()).into(),
        variability(row.variability).into(),
        kind(row),
        shown(row, start),
        limit(row, "min", row.min)?.unwrap_or_default(),
        limit(row, "max", row.max)?.unwrap_or_default(),
        dependencies(row),
        named.description().into(),
    ])
}

fn kind<M>(row: &Variable<M>) -> String {
    match (row.access, row.unit.display.first()) {
        (Access::Real(_), None) => row.unit.name.into(),
        (Access::Real(_), Some(shown)) if row.relative => {
            format!("{} [{}], difference", row.unit.name, shown.name)
        }
        (Access::Real(_), Some(shown)) => format!("{} [{}]", row.unit.name, shown.name),
        (Access::Integer(_), _) => "Integer".into(),
        (Access::Boolean(_), _) => "Boolean".into(),
        (Access::String(_), _) => "String".into(),
        (Access::Enumeration(_, kind), _) => {
            let items = kind
                .items
                .iter()
                .map(|item| format!("{} = {}", item.name, item.value));
            format!("{} {{{}}}", kind.name, items.collect::<Vec<_>>().join(", "))
        }
    }
}

/// A start value as people read it: an enumeration's by its name.
fn shown<M>(row: &Variable<M>, start: String) -> String {
    let Access::Enumeration(_, kind) = row.access else {
        return start;
    };
    let item = kind
        .items
        .iter()
        .find(|item| item.value.to_string() == start);
    item.map_or(start, |item| item.name.into())
}

/// What an output feeds through at a communication point.
fn dependencies<M>(row: &Variable<M>) -> String {
    match row.dependencies {
        None => String::new(),
        Some([]) => "states only".into(),
        Some(names) => names.join(", "),
    }
}
