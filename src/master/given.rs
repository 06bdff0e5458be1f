//! What the command line gives components: parameter files, what was learnt, single values.

use crate::description::Description;
use crate::error::Error;
use crate::plan::Value;
use crate::ssv;
use crate::suggest::did_you_mean;
use crate::supplier::{Values, put};
use std::path::Path;

/// The component that learns, and the one that takes of that what it has, too.
const OBSERVER: &str = "observer";
const CONTROL: &str = "control";

/// What the folder of a run calls what its observer has learnt.
const LEARNT: &str = "calibration.ssv";

/// Values above those of the system file and of a mapping: of two for one variable the later kind counts.
#[derive(Default)]
pub struct Given {
    /// Components, and the values of their parameter files.
    presets: Vec<(String, Values)>,
    /// What an observer had learnt.
    learnt: Values,
    /// Components, variables, values.
    set: Vec<(String, String, Value)>,
}

impl Given {
    /// Takes the values of a parameter file (.ssv) for a component, which is in a system file.
    pub fn preset(
        &mut self,
        component: &str,
        file: &Path,
        system: (&Path, &[&str]),
    ) -> Result<(), Error> {
        refuse_unknown("--parameters", component, system)?;
        self.presets.push((component.to_owned(), ssv::read(file)?));
        Ok(())
    }

    /// Takes what an observer had learnt at the end of an earlier run, an .ssv or the folder of that run; of that the
    /// control takes what it has.
    pub fn learnt(&mut self, file: &Path, system: (&Path, &[&str])) -> Result<(), Error> {
        refuse_unknown("--calibration", OBSERVER, system)?;
        let whole = file.join(LEARNT);
        if file.is_dir() && !whole.is_file() {
            let folder = file.display();
            return Err(Error::Usage(format!(
                "--calibration {folder}: no {LEARNT} in this folder; `dct-harness run` writes it to --out at the end \
                 of a run whose observer learns: --set observer.observer.method=calibrating"
            )));
        }
        self.learnt = ssv::read(if file.is_dir() { &whole } else { file })?;
        Ok(())
    }

    /// Takes one value.
    pub fn set(
        &mut self,
        (component, variable, value): (&str, &str, Value),
        system: (&Path, &[&str]),
    ) -> Result<(), Error> {
        refuse_unknown(&format!("--set {component}.{variable}"), component, system)?;
        self.set.push((component.into(), variable.into(), value));
        Ok(())
    }

    /// Puts the values of a component of this description above those that it has.
    pub fn put(&self, component: &str, description: &Description, found: &mut Values) {
        let preset = self.presets.iter().filter(|(name, _)| name == component);
        let preset = preset.flat_map(|(_, values)| values);
        let learnt = self.learnt.iter().filter(|(name, _)| match component {
            OBSERVER => true,
            CONTROL => description.find(name).is_some(),
            _ => false,
        });
        for (name, value) in preset.chain(learnt) {
            put(found, name.clone(), value.clone());
        }
        for (_, name, value) in self.set.iter().filter(|(known, ..)| known == component) {
            put(found, name.clone(), value.clone());
        }
    }
}

/// `system`: the file and its components.
fn refuse_unknown(
    option: &str,
    component: &str,
    (file, known): (&Path, &[&str]),
) -> Result<(), Error> {
    if known.contains(&component) {
        return Ok(());
    }
    let hint = did_you_mean(component, known.iter().copied());
    let (file, known) = (file.display(), known.join(", "));
    let what = format!("{option}: {file} has no component '{component}' ({known}){hint}");
    Err(Error::Usage(what))
}
