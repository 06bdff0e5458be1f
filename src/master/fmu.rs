//! One FMU of the loop: the unpacked file, and an instance with the inputs and outputs in use.

use crate::description::{Causality, Description, Family, Variable};
use crate::error::Error;
use crate::package;
use crate::plan::Value;
use crate::signals::{Failure, Signals};
use fmi::fmi2::Fmi2Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An unpacked FMU; any number of instances may be made of it, also by several threads.
pub struct Library {
    import: Fmi2Import,
    description: Description,
    path: PathBuf,
}

impl Library {
    /// Unpacks and reads an FMU file.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let (import, xml) = package::open(path)?;
        let description = Description::parse(&xml).map_err(|what| Error::Content {
            path: path.to_owned(),
            line: 0,
            what: format!("modelDescription.xml: {what}"),
        })?;
        Ok(Self {
            import,
            description,
            path: path.to_owned(),
        })
    }

    /// What it says of its variables.
    pub fn description(&self) -> &Description {
        &self.description
    }
}

/// FMU files that are open, each once however many components and runs use it.
#[derive(Default, Clone)]
pub struct Libraries(HashMap<PathBuf, Arc<Library>>);

impl Libraries {
    /// The library of a file, opened when it is not yet.
    pub fn open(&mut self, path: &Path) -> Result<Arc<Library>, Error> {
        if let Some(known) = self.0.get(path) {
            return Ok(known.clone());
        }
        let library = Arc::new(Library::open(path)?);
        self.0.insert(path.to_owned(), library.clone());
        Ok(library)
    }
}

/// An instance.
pub struct Fmu {
    name: String,
    /// Dropped before `library`, which owns the unpacked files.
    instance: InstanceCS,
    library: Arc<Library>,
    inputs: Signals,
    outputs: Signals,
    time: f64,
    running: bool,
}

impl Fmu {
    /// Makes an instance; `inputs` will be set and `outputs` read, in that order.
    pub fn new(
        name: &str,
        library: Arc<Library>,
        inputs: &[&Variable],
        outputs: &[&Variable],
    ) -> Result<Self, Error> {
        let instance = library.import.instantiate_cs(name, false, false);
        let instance = instance.map_err(|error| match error {
            fmi::Error::Instantiation => Error::Call {
                component: name.to_owned(),
                function: "fmi2Instantiate",
                time: 0.0,
                status: Fmi2Error::Error,
            },
            error => Error::Load {
                path: library.path.clone(),
                error: Box::new(error),
            },
        })?;
        Ok(Self {
            inputs: Signals::new(inputs.iter().copied()),
            outputs: Signals::new(outputs.iter().copied()),
            name: name.to_owned(),
            instance,
            library,
            time: 0.0,
            running: false,
        })
    }

    /// How many outputs it reads.
    pub fn outputs(&self) -> usize {
        self.outputs.len()
    }

    /// Sets parameters and start values and enters initialisation mode; `stop` in [s].
    pub fn initialize(&mut self, values: &[(String, Value)], stop: f64) -> Result<(), Error> {
        values
            .iter()
            .try_for_each(|(name, value)| self.set_start(name, value))?;
        let done = self.instance.setup_experiment(None, 0.0, Some(stop));
        self.checked("fmi2SetupExperiment", done)?;
        let done = Common::enter_initialization_mode(&mut self.instance);
        self.checked("fmi2EnterInitializationMode", done)
    }

    fn set_start(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let full = format!("{}.{name}", self.name);
        let variable = self.library.description.find(name);
        let variable = variable.ok_or_else(|| Error::variable(&full, "does not exist"))?;
        let number = number(variable, value).map_err(|what| Error::variable(&full, what))?;
        let mut one = Signals::new([variable]);
        let done = one.set(&mut self.instance, &[number]);
        done.map_err(|failure| self.failed(failure))
    }

    /// Leaves initialisation mode.
    pub fn start(&mut self) -> Result<(), Error> {
        let done = Common::exit_initialization_mode(&mut self.instance);
        self.checked("fmi2ExitInitializationMode", done)?;
        self.running = true;
        Ok(())
    }

    /// Sets the inputs in use.
    pub fn set_inputs(&mut self, values: &[f64]) -> Result<(), Error> {
        let done = self.inputs.set(&mut self.instance, values);
        done.map_err(|failure| self.failed(failure))
    }

    /// Reads the outputs in use.
    pub fn get_outputs(&mut self, values: &mut [f64]) -> Result<(), Error> {
        let done = self.outputs.get(&mut self.instance, values);
        done.map_err(|failure| self.failed(failure))
    }

    /// Sets the inputs in use and advances from `time` by `step` [s].
    pub fn step(&mut self, inputs: &[f64], time: f64, step: f64) -> Result<(), Error> {
        self.time = time;
        self.set_inputs(inputs)?;
        let done = self.instance.do_step(time, step, true);
        self.checked("fmi2DoStep", done)
    }

    fn checked<T>(
        &mut self,
        function: &'static str,
        done: Result<T, Fmi2Error>,
    ) -> Result<(), Error> {
        done.map(|_| ())
            .map_err(|status| self.failed((function, status)))
    }

    /// After a failure the instance may only be freed.
    fn failed(&mut self, (function, status): Failure) -> Error {
        self.running = false;
        Error::Call {
            component: self.name.clone(),
            function,
            time: self.time,
            status,
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        if self.running {
            // Nothing can be done about a failure here; the instance is freed next.
            let _ = Common::terminate(&mut self.instance);
        }
    }
}

/// The outputs of an FMU in the order in which they are read and recorded.
pub fn outputs(description: &Description) -> Vec<&Variable> {
    description.chosen(|variable| variable.causality == Causality::Output)
}

/// A start value as the number that travels; the error says what is wrong with it.
fn number(variable: &Variable, value: &Value) -> Result<f64, String> {
    match (variable.family, value) {
        (Family::Boolean, Value::Boolean(value)) => Ok(f64::from(u8::from(*value))),
        (Family::Real, Value::Number(value)) => Ok(*value),
        (Family::Integer, Value::Number(value)) if value.fract() == 0.0 => Ok(*value),
        (Family::Integer, Value::Text(item)) => {
            let known = variable.items.iter().find(|(name, _)| name == item);
            let names: Vec<&str> = variable
                .items
                .iter()
                .map(|(name, _)| name.as_str())
                .collect();
            let number = known.map(|(_, number)| f64::from(*number));
            number.ok_or_else(|| format!("has no item '{item}' ({})", names.join(", ")))
        }
        (family, value) => Err(format!("is {family:?}, got {value:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(family: Family) -> Variable {
        Variable {
            name: "x".into(),
            reference: 0,
            family,
            causality: Causality::Other,
            items: vec![("open".into(), 1), ("shut".into(), 2)],
            unit: None,
        }
    }

    #[test]
    fn a_start_value_has_the_type_of_its_variable() {
        for (family, value, expected) in [
            (Family::Real, Value::Number(1.5), Some(1.5)),
            (Family::Integer, Value::Number(2.0), Some(2.0)),
            (Family::Integer, Value::Number(1.5), None),
            (Family::Integer, Value::Text("shut".into()), Some(2.0)),
            (Family::Integer, Value::Text("ajar".into()), None),
            (Family::Boolean, Value::Boolean(true), Some(1.0)),
            (Family::Boolean, Value::Number(1.0), None),
            (Family::Real, Value::Text("1".into()), None),
        ] {
            assert_eq!(
                number(&variable(family), &value).ok(),
                expected,
                "{family:?} {value:?}"
            );
        }
    }

    #[test]
    fn an_unknown_item_is_answered_with_the_known_ones() {
        let told = number(&variable(Family::Integer), &Value::Text("ajar".into()));
        assert_eq!(told.unwrap_err(), "has no item 'ajar' (open, shut)");
    }
}
