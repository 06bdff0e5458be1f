//! What a car or a rig measured of its plant, beside what the FMUs are given.
//!
//! In a system without the component `plant`, columns `plant.<variable>` of the scenario are recorded as they are, so
//! that an observer can be judged against them; as `dct-harness` does in `master/beside.py`.

use crate::contract;
use crate::description::{Causality, Family};
use crate::error::Error;
use crate::names::PLANT;
use crate::plan::Plan;
use crate::scenario::Scenario;
use crate::suggest::did_you_mean;

/// Columns of a scenario that go to no FMU; none where a plant runs.
#[derive(Debug)]
pub struct Measured<'a> {
    scenario: &'a Scenario,
    columns: Vec<Column>,
    /// A sentence for each that no plant shows.
    pub doubts: Vec<String>,
}

#[derive(Debug)]
struct Column {
    name: String,
    place: usize,
    held: bool,
}

impl<'a> Measured<'a> {
    /// The columns beside a plan; what a plant tells of them says which are held between rows.
    pub fn new(scenario: &'a Scenario, plan: &Plan) -> Result<Self, Error> {
        let mut found = Self {
            scenario,
            columns: vec![],
            doubts: vec![],
        };
        if plan.components.iter().any(|part| part.name == PLANT) {
            return Ok(found);
        }
        let contract = contract::plant()?;
        let is_shown = |causality| causality == Causality::Output;
        let shown = contract.chosen(|variable| is_shown(variable.causality));
        let full = |name: &str| format!("{PLANT}.{name}");
        let names: Vec<String> = shown.iter().map(|known| full(&known.name)).collect();
        let all = scenario.names().iter().enumerate();
        for (place, name) in all.filter(|(_, name)| name.starts_with(&full(""))) {
            let known = shown.iter().zip(&names).find(|(_, known)| *known == name);
            if known.is_none() {
                let hint = did_you_mean(name, names.iter().map(String::as_str));
                found.doubt(name, &hint);
            }
            found.columns.push(Column {
                name: name.clone(),
                place,
                held: known.is_some_and(|(known, _)| known.family != Family::Real),
            });
        }
        Ok(found)
    }

    fn doubt(&mut self, name: &str, hint: &str) {
        let file = self.scenario.path().file_name().unwrap_or_default();
        let file = file.display();
        let said = format!("scenario {file}: no plant shows '{name}'{hint}");
        self.doubts.push(said);
    }

    /// Takes from a list of signals to record, empty for all, those that are of these columns, and keeps these only.
    ///
    /// # Errors
    ///
    /// No signal of the loop is left.
    pub fn take(&mut self, record: &mut Vec<String>) -> Result<(), Error> {
        if record.is_empty() {
            return Ok(());
        }
        self.columns.retain(|column| record.contains(&column.name));
        record.retain(|name| !self.names().any(|column| column == name));
        if record.is_empty() {
            let file = self.scenario.path().display();
            return Err(Error::Usage(format!(
                "--record: {file} has all of these signals already; name one of an FMU, too"
            )));
        }
        Ok(())
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.columns.iter().map(|column| column.name.as_str())
    }

    /// Values of the columns at `time` [s].
    pub fn at(&self, time: f64) -> impl Iterator<Item = f64> {
        let all = self.columns.iter();
        all.map(move |column| self.scenario.sample(column.place, time, column.held))
    }
}
