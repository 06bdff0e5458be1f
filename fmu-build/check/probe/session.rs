//! A loaded FMU, ready to be instantiated and run over and over.

use super::super::native::{Binary, Instance, Transition};
use super::super::parsed::{Attributes, CoSimulation, Description, Kind, ScalarVariable};
use super::super::refused::{done, refused};
use super::value::Value;
use crate::Result;
use std::cell::Cell;
use std::path::Path;

/// Steps of an experiment that says how long it is, not how fine.
const STEPS: f64 = 500.0;
/// Communication step when the description says nothing [s].
const STEP: f64 = 1e-3;

/// A loaded library with its description.
pub(super) struct Session<'a> {
    pub binary: &'a Binary,
    pub description: &'a Description,
    resources: String,
}

impl<'a> Session<'a> {
    pub(super) fn new(binary: &'a Binary, description: &'a Description, folder: &Path) -> Self {
        Self {
            binary,
            description,
            resources: resource_uri(folder),
        }
    }

    /// Whether the FMU says that it can do something.
    pub(super) fn can(&self, ability: impl Fn(&CoSimulation) -> bool) -> bool {
        self.description.co_simulation.as_ref().is_some_and(ability)
    }

    /// An instance, if the FMU makes one for this GUID.
    pub(super) fn instantiated_with(&self, guid: &str) -> Result<Option<Instance<'a>>> {
        self.binary.instantiate(guid, &self.resources, true)
    }

    /// An instance that got no functions for memory.
    pub(super) fn instantiated_without_memory(&self) -> Result<Option<Instance<'a>>> {
        let guid = &self.description.guid;
        self.binary.instantiate(guid, &self.resources, false)
    }

    /// An instance, just made.
    pub(super) fn instance(&self) -> Result<Instance<'a>> {
        let instance = self.instantiated_with(&self.description.guid)?;
        instance.ok_or_else(|| refused("fmi2Instantiate", 3))
    }

    /// An instance in initialization mode.
    pub(super) fn initializing(&self) -> Result<Instance<'a>> {
        let instance = self.instance()?;
        self.initialize(&instance)?;
        Ok(instance)
    }

    /// Brings an instance that was only made, or reset, to initialization mode.
    pub(super) fn initialize(&self, instance: &Instance<'_>) -> Result<()> {
        done(instance.setup_experiment(self.start())?)?;
        done(instance.call(Transition::EnterInitializationMode)?)
    }

    /// An instance that can be stepped.
    pub(super) fn run(&self) -> Result<Run<'a>> {
        let instance = self.initializing()?;
        done(instance.call(Transition::ExitInitializationMode)?)?;
        Ok(Run {
            instance,
            time: Cell::new(self.start()),
        })
    }

    /// An instance that was only made, for a state to be restored in.
    pub(super) fn bare(&self) -> Result<Run<'a>> {
        Ok(Run {
            instance: self.instance()?,
            time: Cell::new(self.start()),
        })
    }

    /// Where time begins [s].
    pub(super) fn start(&self) -> f64 {
        self.description.experiment.start.unwrap_or(0.0)
    }

    /// The communication step that the description proposes [s].
    pub(super) fn step(&self) -> f64 {
        let experiment = &self.description.experiment;
        let span = experiment.stop.map(|stop| (stop - self.start()) / STEPS);
        let usable = |step: &f64| *step > 0.0 && step.is_finite();
        let given = experiment.step.filter(usable);
        given.or(span.filter(usable)).unwrap_or(STEP)
    }

    /// Variables of a causality.
    pub(super) fn all(&self, causality: &str) -> Vec<Variable<'a>> {
        self.chosen(|variable| variable.causality == causality)
    }

    /// Variables that have their start value for ever.
    pub(super) fn constants(&self) -> Vec<Variable<'a>> {
        self.chosen(ScalarVariable::is_constant)
    }

    fn chosen(&self, wanted: impl Fn(&ScalarVariable) -> bool) -> Vec<Variable<'a>> {
        let variables = (1..).zip(self.description.variables());
        let chosen = variables.filter(|(_, variable)| wanted(variable));
        let typed = chosen.filter_map(|(index, variable)| {
            let (kind, attributes) = variable.kind()?;
            Some(Variable {
                index,
                kind,
                attributes,
                variable,
            })
        });
        typed.collect()
    }
}

/// A variable with its type.
#[derive(Clone, Copy)]
pub(super) struct Variable<'a> {
    /// Its place in the description, from 1.
    pub index: usize,
    pub kind: Kind,
    pub attributes: &'a Attributes,
    variable: &'a ScalarVariable,
}

impl<'a> Variable<'a> {
    pub(super) fn name(&self) -> &'a str {
        &self.variable.name
    }

    pub(super) fn reference(&self) -> u32 {
        self.variable.value_reference
    }

    /// Size of an ordinary value; 1 where the description names none, says FMI.
    pub(super) fn nominal(&self) -> f64 {
        self.attributes.nominal.map_or(1.0, f64::abs)
    }

    /// A Real that has derivatives.
    pub(super) fn is_smooth(&self) -> bool {
        self.kind == Kind::Real && self.variable.variability == "continuous"
    }

    pub(super) fn get(&self, instance: &Instance<'_>) -> Result<Value> {
        done(Value::read(instance, self.kind, self.reference())?)
    }

    pub(super) fn set(&self, instance: &Instance<'_>, value: &Value) -> Result<()> {
        done(value.set(instance, self.reference())?)
    }
}

/// Reads all of these variables.
pub(super) fn values(instance: &Instance<'_>, all: &[Variable<'_>]) -> Result<Vec<Value>> {
    all.iter().map(|variable| variable.get(instance)).collect()
}

/// An initialised instance and its time.
pub(super) struct Run<'a> {
    pub instance: Instance<'a>,
    /// The communication point it is at [s].
    pub time: Cell<f64>,
}

impl Run<'_> {
    pub(super) fn step(&self, step: f64) -> Result<()> {
        let time = self.time.get();
        done(self.instance.do_step(time, step)?)?;
        self.time.set(time + step);
        Ok(())
    }

    /// Back to the beginning by fmi2Reset.
    pub(super) fn reset(&self, session: &Session<'_>) -> Result<()> {
        done(self.instance.call(Transition::Reset)?)?;
        session.initialize(&self.instance)?;
        done(self.instance.call(Transition::ExitInitializationMode)?)?;
        self.time.set(session.start());
        Ok(())
    }
}

/// `file:///…` of the folder `resources`, blanks and other special characters encoded.
pub(in super::super) fn resource_uri(folder: &Path) -> String {
    let path = folder
        .join("resources")
        .to_string_lossy()
        .replace('\\', "/");
    let mut uri = String::from(if path.starts_with('/') {
        "file://"
    } else {
        "file:///"
    });
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resources_are_named_by_an_encoded_uri() {
        assert_eq!(
            resource_uri(Path::new("/a b/ö")),
            "file:///a%20b/%C3%B6/resources"
        );
    }
}
