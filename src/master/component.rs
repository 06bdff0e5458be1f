//! One FMU of the loop: file, instance, inputs and outputs.

use crate::Error;
use crate::signals::{Kind, Signals, kind};
use fmi::fmi2::Fmi2Error;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::Causality;
use fmi::traits::FmiImport;
use std::path::PathBuf;

/// What a user says of one FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Name in results and errors, e.g. `plant`.
    pub name: String,
    /// The FMU file.
    pub path: PathBuf,
    /// Parameters and start values by variable name.
    pub values: Vec<(String, Value)>,
}

/// A parameter or start value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// For a Real, Integer or Enumeration variable.
    Number(f64),
    /// For a Boolean variable.
    Boolean(bool),
}

/// A loaded and instantiated FMU.
pub struct Fmu {
    name: String,
    /// Dropped before `import`, which owns the unpacked files.
    instance: InstanceCS,
    import: Fmi2Import,
    pub(crate) inputs: Signals,
    pub(crate) outputs: Signals,
    time: f64,
    running: bool,
}

impl Fmu {
    /// Loads an FMU and makes one instance of it; inputs with a start value stay unconnected.
    pub fn load(component: &Component) -> Result<Self, Error> {
        let load = |error| Error::Load {
            path: component.path.clone(),
            error: Box::new(error),
        };
        let import: Fmi2Import = fmi::import::from_path(&component.path).map_err(load)?;
        let instance = import
            .instantiate_cs(&component.name, false, false)
            .map_err(load)?;
        let all = &import.model_description().model_variables.variables;
        let given = |name: &str| component.values.iter().any(|(known, _)| known == name);
        let inputs = all
            .iter()
            .filter(|v| v.causality == Causality::Input && !given(&v.name));
        let outputs = all.iter().filter(|v| v.causality == Causality::Output);
        Ok(Self {
            inputs: Signals::new(inputs),
            outputs: Signals::new(outputs),
            name: component.name.clone(),
            instance,
            import,
            time: 0.0,
            running: false,
        })
    }

    /// The component's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sets parameters and start values and enters initialisation mode; times in [s].
    pub fn initialize(&mut self, values: &[(String, Value)], stop: f64) -> Result<(), Error> {
        values
            .iter()
            .try_for_each(|(name, value)| self.set_start(name, *value))?;
        let done = self.instance.setup_experiment(None, 0.0, Some(stop));
        self.checked("fmi2SetupExperiment", done)?;
        let done = Common::enter_initialization_mode(&mut self.instance);
        self.checked("fmi2EnterInitializationMode", done)
    }

    fn set_start(&mut self, name: &str, value: Value) -> Result<(), Error> {
        let full = || format!("{}.{name}", self.name);
        let all = &self.import.model_description().model_variables.variables;
        let variable = all.iter().find(|variable| variable.name == name);
        let variable = variable.ok_or_else(|| Error::Variable {
            name: full(),
            what: "does not exist",
        })?;
        let mut one = Signals::new(std::iter::once(variable));
        let number = match (kind(variable), value) {
            (Some(Kind::Boolean), Value::Boolean(value)) => f64::from(u8::from(value)),
            (Some(Kind::Real), Value::Number(value)) => value,
            (Some(Kind::Integer), Value::Number(value)) if value.fract() == 0.0 => value,
            _ => {
                return Err(Error::Variable {
                    name: full(),
                    what: "has another type",
                });
            }
        };
        let done = one.set(&mut self.instance, std::iter::once(number));
        done.map_err(|(function, status)| self.failed(function, status))
    }

    /// Leaves initialisation mode.
    pub fn start(&mut self) -> Result<(), Error> {
        let done = Common::exit_initialization_mode(&mut self.instance);
        self.checked("fmi2ExitInitializationMode", done)?;
        self.running = true;
        Ok(())
    }

    /// Sets the connected inputs.
    pub fn set_inputs(&mut self, values: impl Iterator<Item = f64>) -> Result<(), Error> {
        let done = self.inputs.set(&mut self.instance, values);
        done.map_err(|(function, status)| self.failed(function, status))
    }

    /// Reads all outputs.
    pub fn get_outputs(&mut self, values: &mut [f64]) -> Result<(), Error> {
        let done = self.outputs.get(&mut self.instance, values);
        done.map_err(|(function, status)| self.failed(function, status))
    }

    /// Advances from `time` by `step` [s].
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        self.time = time;
        let done = self.instance.do_step(time, step, true);
        self.checked("fmi2DoStep", done)
    }

    fn checked<T>(
        &mut self,
        function: &'static str,
        done: Result<T, Fmi2Error>,
    ) -> Result<(), Error> {
        done.map(|_| ())
            .map_err(|status| self.failed(function, status))
    }

    /// After a failure the instance may only be freed.
    fn failed(&mut self, function: &'static str, status: Fmi2Error) -> Error {
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
