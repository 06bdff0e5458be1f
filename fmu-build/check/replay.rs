//! Runs FMUs over a table of inputs and writes their outputs, bit for bit: the same file on two
//! platforms means that both computed the same.

use super::native::{Binary, Instance, Transition};
use super::parsed::{Description, Kind as Type, ScalarVariable};
use super::probe::resource_uri;
use super::refused::{done, refused};
use super::unpack::Unpacked;
use super::{Library, opened};
use crate::drive::{self, Calls, Kind, Loop, Part, Place, Recorded, Role, Signal, Stimuli};
use crate::{Error, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// How FMUs are run over a table of inputs.
#[derive(Debug, Clone, Copy)]
pub struct Replay<'a> {
    /// CSV file whose columns are `time` and names of inputs and parameters. Between its rows Reals are
    /// interpolated, others kept. A parameter is set once, before the start; a column of no variable
    /// is passed over.
    pub inputs: &'a Path,
    /// Communication step [s].
    pub step: f64,
    /// Every `every`th communication point is written.
    pub every: u32,
    /// CSV file for the outputs.
    pub out: &'a Path,
    /// File for all calls with their values, for `xtask/platforms/calls.c`.
    pub calls: Option<&'a Path>,
}

/// Steps the FMUs from the first to the last time of the inputs and writes all outputs.
///
/// Several FMUs are coupled: an input takes the output of its name from the FMU nearest before its own
/// in the list, going round.
///
/// Returns why columns were passed over, one sentence each.
///
/// # Errors
/// When a file cannot be read or written, and when an FMU refuses a call.
pub fn replay(fmus: &[PathBuf], options: &Replay<'_>) -> Result<Vec<String>> {
    let stimuli = Stimuli::read(options.inputs)?;
    let opened: Vec<_> = fmus
        .iter()
        .map(|fmu| Opened::read(fmu))
        .collect::<Result<_>>()?;
    let calls = Calls::default();
    let mut parts: Vec<Box<dyn Part + '_>> = Vec::new();
    for (at, fmu) in opened.iter().enumerate() {
        let part = Box::new(fmu.instance()?);
        parts.push(match options.calls {
            None => part,
            Some(_) => Recorded::boxed(part, at, &fmu.description.guid, &calls),
        });
    }
    let mut all = Loop::new(parts, &stimuli);
    let passed_over = all.passed_over(&stimuli);
    let table = drive::table(&mut all, options.step, options.every)?;
    write(options.out, &table)?;
    if let Some(path) = options.calls {
        write(path, &calls.borrow())?;
    }
    Ok(passed_over)
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).map_err(Error::io(path))
}

/// An FMU, unpacked, with its library loaded.
struct Opened {
    binary: Binary,
    description: Description,
    unpacked: Unpacked,
}

impl Opened {
    fn read(fmu: &Path) -> Result<Self> {
        let (unpacked, description) = opened(fmu)?;
        let library = Library::of_this_machine(&description, unpacked.folder())?;
        Ok(Self {
            binary: Binary::load(&library.path)?,
            description,
            unpacked,
        })
    }

    fn instance(&self) -> Result<Running<'_>> {
        let resources = resource_uri(self.unpacked.folder());
        let instance = self
            .binary
            .instantiate(&self.description.guid, &resources, true)?;
        let variables = self.description.variables().iter();
        Ok(Running {
            name: &self.description.model_name,
            instance: instance.ok_or_else(|| refused("fmi2Instantiate", 3))?,
            signals: variables.filter_map(signal).collect(),
        })
    }
}

/// `None` for texts, and for variables that others neither set nor read.
fn signal(variable: &ScalarVariable) -> Option<Signal> {
    let kind = match variable.kind()?.0 {
        Type::Real => Kind::Real,
        Type::Integer => Kind::Integer,
        Type::Boolean => Kind::Boolean,
        Type::String => return None,
    };
    let role = match variable.causality.as_str() {
        "input" => Role::Input,
        "output" => Role::Output,
        "parameter" => Role::Parameter,
        _ => return None,
    };
    Some(Signal {
        name: variable.name.clone(),
        role,
        place: Place {
            kind,
            reference: variable.value_reference,
        },
    })
}

struct Running<'a> {
    name: &'a str,
    instance: Instance<'a>,
    signals: Vec<Signal>,
}

impl Part for Running<'_> {
    fn name(&self) -> &str {
        self.name
    }

    fn signals(&self) -> &[Signal] {
        &self.signals
    }

    fn set(&mut self, Place { kind, reference }: Place, value: f64) -> Result<()> {
        done(match kind {
            Kind::Real => self.instance.set_real(reference, value)?,
            Kind::Integer => self.instance.set_integer(reference, drive::whole(value))?,
            Kind::Boolean => self.instance.set_boolean(reference, value != 0.0)?,
        })
    }

    fn get(&mut self, Place { kind, reference }: Place) -> Result<f64> {
        done(match kind {
            Kind::Real => self.instance.real(reference)?,
            Kind::Integer => self.instance.integer(reference)?.map(f64::from),
            Kind::Boolean => self.instance.boolean(reference)?.map(f64::from),
        })
    }

    fn initialize(&mut self, time: f64) -> Result<()> {
        done(self.instance.setup_experiment(time)?)?;
        done(self.instance.call(Transition::EnterInitializationMode)?)
    }

    fn start(&mut self) -> Result<()> {
        done(self.instance.call(Transition::ExitInitializationMode)?)
    }

    fn step(&mut self, time: f64, step: f64) -> Result<()> {
        done(self.instance.do_step(time, step)?)
    }

    fn terminate(&mut self) -> Result<()> {
        done(self.instance.call(Transition::Terminate)?)
    }
}
