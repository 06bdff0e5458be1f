//! Runs an FMU over a table of inputs and writes its outputs, bit for bit: the same file on two
//! platforms means that both computed the same.

use super::native::{Binary, Instance, Transition, take_messages};
use super::parsed::{Description, Kind, ScalarVariable};
use super::run::{read, resource_uri};
use super::stimuli::Stimuli;
use super::{Library, opened};
use crate::{Error, Result};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Steps the FMU from the first to the last time of `stimuli`, a CSV file whose columns are `time`
/// and names of inputs, and writes all outputs at every communication point to `out`.
///
/// `step`: communication step [s]. Between the rows Reals are interpolated, others kept. A
/// column of a parameter is set once, before the start; one of no variable is passed over.
///
/// # Errors
/// When a file cannot be read or written, and when the FMU refuses a call.
pub fn replay(fmu: &Path, stimuli: &Path, step: f64, out: &Path) -> Result<()> {
    let (unpacked, description) = opened(fmu)?;
    let library = Library::of_this_machine(&description, unpacked.folder())?;
    let binary = Binary::load(&library.path)?;
    let stimuli = Stimuli::read(stimuli)?;
    let resources = resource_uri(unpacked.folder());
    let instance = binary.instantiate(&description.guid, &resources)?;
    let instance = instance.ok_or_else(|| refused("fmi2Instantiate", 3))?;
    let table = Run {
        instance: &instance,
        description: &description,
        stimuli: &stimuli,
    }
    .table(step)?;
    fs::write(out, table).map_err(|source| Error::Io {
        path: out.into(),
        source,
    })
}

fn refused(function: &'static str, status: i32) -> Error {
    Error::Refused {
        function,
        status,
        messages: take_messages().join("; "),
    }
}

struct Run<'a> {
    instance: &'a Instance<'a>,
    description: &'a Description,
    stimuli: &'a Stimuli,
}

impl Run<'_> {
    fn table(&self, step: f64) -> Result<String> {
        let (start, stop) = self.stimuli.times();
        let mut text = String::from("time");
        for output in self.outputs() {
            let _ = write!(text, ",{}", output.name);
        }
        self.set(start, &["input", "parameter"])?;
        done(self.instance.setup_experiment(start)?)?;
        done(self.instance.call(Transition::EnterInitializationMode)?)?;
        done(self.instance.call(Transition::ExitInitializationMode)?)?;
        self.row(start, &mut text)?;
        for time in (0_u32..).map(|index| start + f64::from(index) * step) {
            if time + 0.5 * step > stop {
                break;
            }
            self.set(time, &["input"])?;
            done(self.instance.do_step(time, step)?)?;
            self.row(time + step, &mut text)?;
        }
        done(self.instance.call(Transition::Terminate)?)?;
        Ok(text + "\n")
    }

    fn outputs(&self) -> impl Iterator<Item = &ScalarVariable> {
        let variables = self.description.variables().iter();
        variables.filter(|variable| variable.causality == "output")
    }

    fn row(&self, time: f64, text: &mut String) -> Result<()> {
        let _ = write!(text, "\n{time:?}");
        for output in self.outputs() {
            if let Some((kind, _)) = output.kind() {
                let value = done(read(self.instance, kind, output.value_reference)?)?;
                let _ = write!(text, ",{value}");
            }
        }
        Ok(())
    }

    fn set(&self, time: f64, causalities: &[&str]) -> Result<()> {
        for variable in self.description.variables() {
            let (Some((kind, _)), Some(column)) =
                (variable.kind(), self.stimuli.column(&variable.name))
            else {
                continue;
            };
            if !causalities.contains(&variable.causality.as_str()) {
                continue;
            }
            let reference = variable.value_reference;
            done(match kind {
                Kind::Real => self.instance.set_real(reference, column.at(time))?,
                Kind::Integer => self.instance.set_integer(reference, column.kept(time))?,
                Kind::Boolean => self
                    .instance
                    .set_boolean(reference, column.kept(time) != 0)?,
                Kind::String => continue,
            })?;
        }
        Ok(())
    }
}

fn done<T>(called: std::result::Result<T, super::native::Refused>) -> Result<T> {
    called.map_err(|call| refused(call.function, call.status))
}
