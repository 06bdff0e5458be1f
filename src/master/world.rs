//! All values of a loop in one vector, and what happens to a value on its way into an input.

use crate::description::{Causality, Description, Variable};
use crate::error::Error;
use crate::fmu;
use crate::plan::{Component, Input, Plan};
use std::collections::{HashMap, HashSet};

/// Outputs of each component that are read or recorded, in the plan's order.
///
/// # Errors
///
/// A recorded signal that does not exist.
pub fn outputs<'a>(
    plan: &Plan,
    descriptions: &[&'a Description],
) -> Result<Vec<Vec<&'a Variable>>, Error> {
    let components = plan.components.iter().zip(descriptions);
    let all: Vec<_> = components
        .map(|(component, description)| (&component.name, fmu::outputs(description)))
        .collect();
    let Some(record) = &plan.record else {
        return Ok(all.into_iter().map(|(_, outputs)| outputs).collect());
    };
    let full = |name: &str, variable: &Variable| format!("{name}.{}", variable.name);
    let every = all.iter().flat_map(|(name, outputs)| {
        let names = outputs.iter().map(|variable| full(name, variable));
        names.collect::<Vec<_>>()
    });
    let known: HashSet<String> = scripted(plan).chain(every).collect();
    if let Some(missing) = record.iter().find(|name| !known.contains(*name)) {
        return Err(Error::variable(
            missing,
            "of the recorded signals does not exist",
        ));
    }
    let inputs = plan
        .components
        .iter()
        .flat_map(|component| &component.inputs);
    let read = inputs.flat_map(|input| [Some(&input.source), input.noise.as_ref()]);
    let wanted: HashSet<&String> = read.flatten().chain(record).collect();
    let chosen = all.into_iter().map(|(name, mut outputs)| {
        outputs.retain(|variable| wanted.contains(&full(name, variable)));
        outputs
    });
    Ok(chosen.collect())
}

/// Names of all values, as `component.variable`: the scenario's first, then those of `outputs`.
pub fn names(plan: &Plan, outputs: &[Vec<&Variable>]) -> Vec<String> {
    let outputs = plan.components.iter().zip(outputs);
    let outputs = outputs.flat_map(|(component, outputs)| {
        let all = outputs.iter();
        all.map(|variable| format!("{}.{}", component.name, variable.name))
    });
    scripted(plan).chain(outputs).collect()
}

/// Where each name stands.
pub fn index(names: &[String]) -> HashMap<&str, usize> {
    let places = names.iter().enumerate();
    places.map(|(k, name)| (name.as_str(), k)).collect()
}

/// Where recorded signals lie among `names`; `None` for all.
pub fn places(names: &[String], record: Option<&[String]>) -> Option<Vec<usize>> {
    record.map(|record| {
        let places = index(names);
        let place = |name: &String| places.get(name.as_str()).copied();
        record.iter().filter_map(place).collect()
    })
}

fn scripted(plan: &Plan) -> impl Iterator<Item = String> {
    plan.script.iter().map(|name| format!("scenario.{name}"))
}

/// Gathers the inputs of one component from the world.
#[derive(Debug, Default)]
pub struct Gather {
    sources: Vec<usize>,
    /// Only where noise is added: place, source of the noise.
    noises: Vec<(usize, usize)>,
    /// Only where something is changed: place, factor, offset.
    lines: Vec<(usize, f64, f64)>,
    tables: Vec<Table>,
    /// The gathered values.
    pub values: Vec<f64>,
}

#[derive(Debug)]
struct Table {
    name: String,
    place: usize,
    rows: Vec<(f64, f64)>,
}

impl Gather {
    /// Returns it with the variables whose values it gathers, sorted by family.
    pub fn new<'a>(
        component: &Component,
        description: &'a Description,
        places: &HashMap<&str, usize>,
    ) -> Result<(Self, Vec<&'a Variable>), Error> {
        let mut found = Vec::with_capacity(component.inputs.len());
        for input in &component.inputs {
            let name = format!("{}.{}", component.name, input.name);
            let variable = description.find(&input.name);
            let variable = variable.ok_or_else(|| Error::variable(&name, "does not exist"))?;
            if !can_be_set(variable) {
                return Err(Error::variable(
                    name,
                    "is no input and no tunable parameter",
                ));
            }
            let source = places.get(input.source.as_str()).copied();
            let missing = || format!("reads '{}', which does not exist", input.source);
            found.push((
                variable,
                input,
                source.ok_or_else(|| Error::variable(name, missing()))?,
            ));
        }
        found.sort_by_key(|(variable, ..)| variable.family);
        let mut gather = Self::default();
        for (place, (_, input, source)) in found.iter().enumerate() {
            gather.push(component, place, input, *source);
            gather.add_noise(component, place, input, places)?;
        }
        Ok((
            gather,
            found.into_iter().map(|(variable, ..)| variable).collect(),
        ))
    }

    fn push(&mut self, component: &Component, place: usize, input: &Input, source: usize) {
        self.sources.push(source);
        self.values.push(0.0);
        if !input.table.is_empty() {
            self.tables.push(Table {
                name: format!("{}.{}", component.name, input.name),
                place,
                rows: input.table.clone(),
            });
        } else if input.line != (1.0, 0.0) {
            self.lines.push((place, input.line.0, input.line.1));
        }
    }

    fn add_noise(
        &mut self,
        component: &Component,
        place: usize,
        input: &Input,
        places: &HashMap<&str, usize>,
    ) -> Result<(), Error> {
        let Some(noise) = &input.noise else {
            return Ok(());
        };
        let source = places.get(noise.as_str()).copied().ok_or_else(|| {
            let name = format!("{}.{}", component.name, input.name);
            Error::variable(name, format!("reads '{noise}', which does not exist"))
        })?;
        self.noises.push((place, source));
        Ok(())
    }

    /// Reads the world at communication point `time` [s].
    pub fn gather(&mut self, world: &[f64], time: f64) -> Result<(), Error> {
        for (value, source) in self.values.iter_mut().zip(&self.sources) {
            *value = world.get(*source).copied().unwrap_or(f64::NAN);
        }
        for (place, source) in &self.noises {
            if let Some(value) = self.values.get_mut(*place) {
                *value += world.get(*source).copied().unwrap_or(f64::NAN);
            }
        }
        for (place, factor, offset) in &self.lines {
            if let Some(value) = self.values.get_mut(*place) {
                *value = *value * factor + offset;
            }
        }
        for table in &self.tables {
            if let Some(value) = self.values.get_mut(table.place) {
                *value = table.look_up(*value, time)?;
            }
        }
        Ok(())
    }
}

impl Table {
    fn look_up(&self, value: f64, time: f64) -> Result<f64, Error> {
        let row = self.rows.iter().find(|(source, _)| *source == value);
        row.map(|(_, target)| *target).ok_or_else(|| Error::Value {
            name: self.name.clone(),
            value,
            time,
            what: "it is in no row of its table",
        })
    }
}

fn can_be_set(variable: &Variable) -> bool {
    matches!(
        variable.causality,
        Causality::Input | Causality::Parameter { tunable: true }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gather(line: (f64, f64), table: Vec<(f64, f64)>) -> Gather {
        let component = Component {
            name: "plant".into(),
            ..Component::default()
        };
        let input = Input {
            name: "u".into(),
            source: "scenario.u".into(),
            line,
            table,
            noise: Some("scenario.noise.u".into()),
        };
        let mut gather = Gather::default();
        gather.push(&component, 0, &input, 1);
        let places = HashMap::from([("scenario.noise.u", 2)]);
        gather.add_noise(&component, 0, &input, &places).unwrap();
        gather
    }

    #[test]
    fn noise_comes_before_the_line() {
        let mut gather = gather((2.0, 1.0), vec![]);
        gather.gather(&[0.0, 3.0, 0.5], 0.0).unwrap();
        assert_eq!(gather.values, [8.0]);
    }

    #[test]
    fn a_value_passes_its_line_or_its_table() {
        for (line, table, expected) in [
            ((1.0, 0.0), vec![], 3.0),
            ((2.0, 1.0), vec![], 7.0),
            ((2.0, 1.0), vec![(3.0, -1.0)], -1.0),
        ] {
            let mut gather = gather(line, table);
            gather.gather(&[0.0, 3.0, 0.0], 0.0).unwrap();
            assert_eq!(gather.values, [expected], "{line:?}");
        }
    }

    #[test]
    fn a_value_without_a_row_is_named_with_its_time() {
        let error = gather((1.0, 0.0), vec![(1.0, 2.0)]).gather(&[0.0, 3.0, 0.0], 0.5);
        let text = error.unwrap_err().to_string();
        assert_eq!(
            text,
            "plant.u is 3 at t = 0.5 s: it is in no row of its table"
        );
    }
}
