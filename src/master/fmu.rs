//! One FMU of the loop: an instance with the inputs and outputs in use.

use crate::derivatives::Derivatives;
use crate::description::{Causality, Description, Variable};
use crate::error::{Error, Seconds, asks_end};
use crate::library::Library;
use crate::plan::Value;
use crate::signals::{Failure, Signals};
use crate::start::number;
use cosim_raw::{Instance, Log, Status};
use std::sync::Arc;

/// So many of its last messages stand under the error of an FMU.
const LAST_MESSAGES: usize = 5;

/// Under the error of one that said nothing, as nobody had asked it to.
const UNASKED: &str = "; its log is off: --fmu-log lets it say why";

/// An instance.
pub struct Fmu {
    name: String,
    /// Dropped before `library`, which owns the unpacked files.
    instance: Instance,
    library: Arc<Library>,
    log: Arc<Log>,
    inputs: Signals,
    outputs: Signals,
    /// Inputs that have slopes, when there is interpolation.
    steered: Derivatives,
    /// Outputs whose slopes others want.
    told: Derivatives,
    time: f64,
    running: bool,
    divided: bool,
}

impl Fmu {
    /// Makes an instance; `inputs` will be set and `outputs` read, in that order; what it says goes to `log`.
    pub fn new(
        name: &str,
        log: Arc<Log>,
        library: Arc<Library>,
        inputs: &[&Variable],
        outputs: &[&Variable],
    ) -> Result<Self, Error> {
        let instance = Instance::new(&library.import, name, log.clone());
        let instance = instance.map_err(|error| match error {
            fmi::Error::Instantiation => Error::Call {
                component: name.to_owned(),
                function: "fmi2Instantiate",
                time: 0.0,
                what: format!("made no instance{}", said(&log)),
            },
            error => Error::Load {
                path: library.path.clone(),
                error: Box::new(error),
            },
        })?;
        library.keep_loaded();
        Ok(Self {
            inputs: Signals::new(inputs.iter().copied()),
            outputs: Signals::new(outputs.iter().copied()),
            name: name.to_owned(),
            instance,
            library,
            log,
            steered: Derivatives::default(),
            told: Derivatives::default(),
            time: 0.0,
            running: false,
            divided: false,
        })
    }

    /// Sets from now on only those inputs of `new` that `keep` says.
    pub fn retain_inputs(&mut self, keep: &[bool]) {
        self.inputs.retain(keep);
    }

    /// Lets steps set the derivatives of inputs, which are those of `new`.
    pub fn steer(&mut self, inputs: &[&Variable]) {
        self.steered = Derivatives::new(inputs, Variable::follows);
    }

    /// Lets `get_slopes` ask for the derivatives of outputs, which are those of `new`.
    pub fn tell(&mut self, outputs: &[&Variable]) {
        self.told = Derivatives::new(outputs, |variable| variable.continuous);
    }

    /// Sets parameters and start values and enters initialisation mode; `stop` in [s].
    pub fn initialize(&mut self, values: &[(String, Value)], stop: f64) -> Result<(), Error> {
        values
            .iter()
            .try_for_each(|(name, value)| self.set_start(name, value))?;
        let done = self.instance.setup_experiment(stop);
        self.checked("fmi2SetupExperiment", done)?;
        let done = self.instance.enter_initialization_mode();
        self.checked("fmi2EnterInitializationMode", done)
    }

    fn set_start(&mut self, name: &str, value: &Value) -> Result<(), Error> {
        let full = format!("{}.{name}", self.name);
        let description = self.library.description();
        let variable = description.find(name);
        let variable = variable.ok_or_else(|| Error::variable(&full, description.lacks(name)))?;
        let number = number(variable, value).map_err(|what| Error::variable(&full, what))?;
        let mut one = Signals::new([variable]);
        let done = one.set(&mut self.instance, &[number]);
        done.map_err(|(function, status)| {
            let said = said(&self.log);
            Error::variable(
                &full,
                format!("= {number} is refused: {function} returned {status}{said}"),
            )
        })
    }

    /// Leaves initialisation mode.
    pub fn start(&mut self) -> Result<(), Error> {
        let done = self.instance.exit_initialization_mode();
        self.checked("fmi2ExitInitializationMode", done)?;
        self.running = true;
        Ok(())
    }

    /// Sets the inputs in use.
    #[inline(always)]
    pub fn set_inputs(&mut self, values: &[f64]) -> Result<(), Error> {
        let done = self.inputs.set(&mut self.instance, values);
        done.map_err(|failure| self.failed(failure))
    }

    /// Reads the outputs in use.
    #[inline(always)]
    pub fn get_outputs(&mut self, values: &mut [f64]) -> Result<(), Error> {
        let done = self.outputs.get(&mut self.instance, values);
        done.map_err(|failure| self.failed(failure))
    }

    /// Reads other variables of it.
    pub fn get(&mut self, signals: &mut Signals, values: &mut [f64]) -> Result<(), Error> {
        let done = signals.get(&mut self.instance, values);
        done.map_err(|failure| self.failed(failure))
    }

    /// Reads the time derivatives of the outputs in use; 0 of those that have none.
    pub fn get_slopes(&mut self, slopes: &mut [f64]) -> Result<(), Error> {
        let done = self.told.get(&mut self.instance, slopes);
        done.map_err(|failure| self.failed(failure))
    }

    /// Tells it and its log where a step begins [s].
    #[inline(always)]
    pub fn at(&mut self, time: f64) {
        self.time = time;
        self.log.at(time);
    }

    /// Sets the inputs in use and tries a step; false when the FMU discards it. `slopes` are none, or one for
    /// each input.
    #[inline(always)]
    pub fn attempt(
        &mut self,
        inputs: &[f64],
        slopes: &[f64],
        time: f64,
        step: f64,
    ) -> Result<bool, Error> {
        self.set_inputs(inputs)?;
        if !slopes.is_empty() {
            let done = self.steered.set(&mut self.instance, slopes);
            done.map_err(|failure| self.failed(failure))?;
        }
        match self.instance.do_step(time, step) {
            Ok(()) => Ok(true),
            Err(Status::Discard) => Ok(false),
            Err(status) => Err(self.failed(("fmi2DoStep", status))),
        }
    }

    /// Where it is after a discarded step [s]; none when it does not tell.
    pub fn reached(&mut self) -> Option<f64> {
        self.instance.last_successful_time()
    }

    /// Whether it wants the simulation to end, after a discarded step.
    pub fn is_terminated(&mut self) -> bool {
        self.instance.is_terminated()
    }

    /// Notes that it wants the simulation to end at `time` [s]; the error of a run that goes on.
    pub fn end(&mut self, time: f64) -> Error {
        self.log.warn(asks_end(time));
        Error::Over {
            component: self.name.clone(),
            time,
        }
    }

    /// Whether its steps may differ in length.
    pub fn varies_step(&self) -> bool {
        self.library.description().abilities.varies_step
    }

    /// Tells in the log, once, that steps had to be divided.
    pub fn note_discard(&mut self, time: f64) {
        if !self.divided {
            let time = Seconds(time);
            let call = format!("fmi2DoStep at t = {time} s returned fmi2Discard");
            self.log.warn(format!("{call}; this step was divided"));
        }
        self.divided = true;
    }

    /// The error of a discarded step.
    pub fn give_up(&mut self, why: &str) -> Error {
        self.error("fmi2DoStep", &format!("returned fmi2Discard: {why}"))
    }

    fn checked(&mut self, function: &'static str, done: cosim_raw::Called) -> Result<(), Error> {
        done.map_err(|status| self.failed((function, status)))
    }

    fn failed(&mut self, (function, status): Failure) -> Error {
        self.error(function, &format!("returned {status}"))
    }

    /// After a failure the instance may only be freed.
    #[cold]
    fn error(&mut self, function: &'static str, what: &str) -> Error {
        self.running = false;
        Error::Call {
            component: self.name.clone(),
            function,
            time: self.time,
            what: format!("{what}{}", said(&self.log)),
        }
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        if self.running {
            // Nothing can be done about a failure here; the instance is freed next.
            let _ = self.instance.terminate();
        }
    }
}

/// The last messages of an FMU, a line each.
pub fn said(log: &Log) -> String {
    let messages = log.messages();
    if messages.is_empty() && log.is_off() {
        return UNASKED.to_owned();
    }
    let last = messages.iter().rev().take(LAST_MESSAGES).rev();
    last.map(|message| format!("\n  {}: {}", message.category, message.text))
        .collect()
}

/// The outputs of an FMU in the order in which they are read and recorded.
pub fn outputs(description: &Description) -> Vec<&Variable> {
    description.chosen(|variable| variable.causality == Causality::Output)
}
