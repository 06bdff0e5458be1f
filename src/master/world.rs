//! All values of a loop in one vector: what stands where.

use crate::description::{Description, Variable};
use crate::error::Error;
use crate::plan::{Component, Plan};
use crate::suggest::did_you_mean;
use crate::{fmu, mapped};
use std::collections::{HashMap, HashSet};

/// What is read of a component, and where it stands in the world.
pub struct Read<'a> {
    /// Variables of the FMU.
    pub variables: Vec<&'a Variable>,
    /// Its other outputs.
    pub rest: Vec<&'a Variable>,
    /// Names that the loop has for its outputs, with the component's before a dot.
    pub names: Vec<String>,
    /// Which of those may have slopes.
    pub moving: Vec<bool>,
}

impl<'a> Read<'a> {
    fn new(component: &Component, description: &'a Description) -> Self {
        let full = |name: &str| format!("{}.{name}", component.name);
        let Some(mapped) = &component.mapped else {
            let variables = fmu::outputs(description);
            return Self {
                names: variables.iter().map(|v| full(&v.name)).collect(),
                moving: variables.iter().map(|v| v.continuous).collect(),
                variables,
                rest: vec![],
            };
        };
        let moving = mapped.outputs.iter().map(|link| link.moves);
        Self {
            variables: mapped::outputs(mapped, description),
            rest: vec![],
            names: mapped::names(mapped).iter().map(|n| full(n)).collect(),
            moving: moving.chain(mapped.sums.iter().map(|s| s.moves)).collect(),
        }
    }

    /// Leaves out what nobody wants; a mapped FMU is asked for everything.
    fn retain(&mut self, component: &Component, wanted: &HashSet<&String>) {
        if component.mapped.is_some() {
            return;
        }
        let keep: Vec<bool> = self.names.iter().map(|n| wanted.contains(n)).collect();
        let left: Vec<bool> = keep.iter().map(|keep| !keep).collect();
        self.rest = kept(self.variables.clone(), &left);
        self.variables = kept(std::mem::take(&mut self.variables), &keep);
        self.names = kept(std::mem::take(&mut self.names), &keep);
        self.moving = kept(std::mem::take(&mut self.moving), &keep);
    }
}

fn kept<T>(all: Vec<T>, keep: &[bool]) -> Vec<T> {
    let all = all.into_iter().zip(keep);
    all.filter(|(_, keep)| **keep).map(|(one, _)| one).collect()
}

/// Outputs of each component that are read or recorded, in the plan's order.
///
/// # Errors
///
/// A recorded signal that does not exist.
pub fn outputs<'a>(plan: &Plan, descriptions: &[&'a Description]) -> Result<Vec<Read<'a>>, Error> {
    let components = plan.components.iter().zip(descriptions);
    let mut all: Vec<Read<'a>> = components
        .map(|(component, description)| Read::new(component, description))
        .collect();
    let Some(record) = &plan.record else {
        return Ok(all);
    };
    let every = all.iter().flat_map(|read| read.names.iter().cloned());
    let known: HashSet<String> = scripted(plan).chain(every).collect();
    if let Some(missing) = record.iter().find(|name| !known.contains(*name)) {
        let hint = did_you_mean(missing, known.iter().map(String::as_str));
        return Err(Error::variable(
            missing,
            format!("of the recorded signals does not exist{hint}"),
        ));
    }
    let inputs = plan
        .components
        .iter()
        .flat_map(|component| &component.inputs);
    let read = inputs.flat_map(|input| [Some(&input.source), input.noise.as_ref()]);
    let wanted: HashSet<&String> = read.flatten().chain(record).collect();
    for (read, component) in all.iter_mut().zip(&plan.components) {
        read.retain(component, &wanted);
    }
    Ok(all)
}

/// Names of all values, as `component.variable`: the scenario's first, then those of `outputs`.
pub fn names(plan: &Plan, outputs: &[Read<'_>]) -> Vec<String> {
    let outputs = outputs.iter().flat_map(|read| read.names.iter().cloned());
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
