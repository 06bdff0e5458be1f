//! One FMU, what feeds it, and where its outputs live in the world.

use crate::derivatives::advance;
use crate::description::{Description, Variable};
use crate::discard;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::gather::Gather;
use crate::library::Library;
use crate::mapped::{self, Translator};
use crate::plan::{Component, Value};
use crate::rest::Rest;
use crate::world::Read;
use cosim_raw::Log;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// A component of a run.
pub struct Part {
    fmu: Fmu,
    /// Its inputs, under our names.
    pub gather: Gather,
    /// Its outputs in the world.
    pub outputs: Range<usize>,
    translator: Option<Translator>,
    rest: Rest,
    substeps: u32,
    library: Arc<Library>,
    /// Names of its FMU's variables that are set and read, and which inputs may have slopes.
    ends: [Vec<String>; 2],
    follows: Vec<bool>,
    time: f64,
}

impl Part {
    /// `read` says what is read of it, `first` where its outputs begin in the world.
    pub fn new(
        component: &Component,
        log: &Arc<Log>,
        library: &Arc<Library>,
        read: &Read<'_>,
        places: &HashMap<&str, usize>,
        first: usize,
    ) -> Result<Self, Error> {
        let description = library.description();
        let (component, inputs) = sorted(component, description)?;
        let translator = component
            .mapped
            .as_ref()
            .map(|mapped| Translator::new(&component, mapped, &inputs, &read.variables));
        let name = |variable: &&Variable| variable.name.clone();
        Ok(Self {
            fmu: Fmu::new(
                &component.name,
                log.clone(),
                library.clone(),
                &inputs,
                &read.variables,
            )?,
            gather: Gather::new(&component.name, &component.inputs, places)?,
            outputs: first..first + read.names.len(),
            translator: translator.transpose()?,
            rest: Rest::new(&component.name, &read.rest),
            substeps: component.substeps.max(1),
            library: library.clone(),
            follows: follows(&component, &inputs),
            ends: [&inputs, &read.variables].map(|side| side.iter().map(name).collect()),
            time: 0.0,
        })
    }

    /// Sets parameters and start values and enters initialisation mode; `stop` in [s].
    pub fn initialize(&mut self, values: &[(String, Value)], stop: f64) -> Result<(), Error> {
        self.fmu.initialize(values, stop)
    }

    /// Leaves initialisation mode.
    pub fn start(&mut self) -> Result<(), Error> {
        self.fmu.start()
    }

    /// Sets the gathered inputs.
    pub fn set_inputs(&mut self) -> Result<(), Error> {
        match &mut self.translator {
            None => self.fmu.set_inputs(&self.gather.values),
            Some(translator) => {
                translator.send(&self.gather.values, self.time)?;
                self.fmu.set_inputs(&translator.inputs)
            }
        }
    }

    /// Reads the outputs into their places.
    #[inline(always)]
    pub fn get_outputs(&mut self, world: &mut [f64]) -> Result<(), Error> {
        let places = world.get_mut(self.outputs.clone()).unwrap_or_default();
        match &mut self.translator {
            None => self.fmu.get_outputs(places),
            Some(translator) => {
                self.fmu.get_outputs(&mut translator.outputs)?;
                translator.receive(places, self.time)
            }
        }
    }

    /// Looks at the outputs that nobody reads, at `time` [s].
    pub fn look(&mut self, time: f64) -> Result<(), Error> {
        self.rest.look(&mut self.fmu, time)
    }

    /// Advances with the gathered inputs, in equal parts.
    #[inline(always)]
    pub fn step(&mut self, world: &mut [f64], time: f64, step: f64) -> Result<(), Error> {
        let done = if self.substeps == 1 {
            self.time = time;
            self.step_once(step)
        } else {
            self.step_in_parts(time, step)
        };
        if let Err(error) = done {
            return self.after(error, world, (time, step));
        }
        self.get_outputs(world)
    }

    /// Reads the outputs of an FMU that asked to end the simulation where the step ends; then, and only
    /// then, they are good although it discarded the step (FMI 2.0.4, 4.2.4, "stepFailed").
    #[cold]
    fn after(&mut self, error: Error, world: &mut [f64], step: (f64, f64)) -> Result<(), Error> {
        if discard::is_over_after(&error, step) {
            self.get_outputs(world)?;
        }
        Err(error)
    }

    fn step_in_parts(&mut self, time: f64, step: f64) -> Result<(), Error> {
        let parts = f64::from(self.substeps);
        for k in 0..self.substeps {
            self.time = time + f64::from(k) * step / parts;
            self.step_once(step / parts)?;
            let Gather { values, slopes, .. } = &mut self.gather;
            advance(values, slopes, step / parts);
        }
        Ok(())
    }

    #[inline(always)]
    fn step_once(&mut self, step: f64) -> Result<(), Error> {
        let Gather { values, slopes, .. } = &mut self.gather;
        let Some(translator) = &mut self.translator else {
            return discard::step(&mut self.fmu, values, slopes, (self.time, step));
        };
        translator.send(values, self.time)?;
        let their_slopes = if slopes.is_empty() {
            &[][..]
        } else {
            translator.steer(slopes);
            &translator.slopes
        };
        let span = (self.time, step);
        discard::step(&mut self.fmu, &mut translator.inputs, their_slopes, span)
    }

    /// Sets all inputs but those whose signals of the scenario are `still`: they keep what they have been set to.
    pub fn hold(&mut self, still: &[bool]) {
        if self.translator.is_none()
            && let Some(keep) = self.gather.hold(still)
        {
            self.fmu.retain_inputs(&keep);
        }
    }

    /// Prepares for interpolation.
    pub fn steer(&mut self) {
        let library = self.library.clone();
        let find = |name: &String| library.description().find(name);
        let [inputs, outputs] = &self.ends;
        self.fmu
            .tell(&outputs.iter().filter_map(find).collect::<Vec<_>>());
        if self.follows() {
            self.fmu
                .steer(&inputs.iter().filter_map(find).collect::<Vec<_>>());
            self.gather.steer(&self.follows);
        }
    }

    /// Whether its FMU takes input derivatives.
    pub fn follows(&self) -> bool {
        self.library.description().abilities.interpolates
    }

    /// Whether its FMU tells output derivatives.
    pub fn tells_slopes(&self) -> bool {
        self.library.description().abilities.tells_slopes
    }

    /// Reads the time derivatives of the outputs.
    pub fn get_slopes(&mut self, places: &mut [f64]) -> Result<(), Error> {
        match &mut self.translator {
            None => self.fmu.get_slopes(places),
            Some(translator) => {
                self.fmu.get_slopes(&mut translator.outputs)?;
                translator.told(places);
                Ok(())
            }
        }
    }
}

/// A component with its inputs in the order in which they are gathered, and the variables of its FMU
/// that are set, sorted by family.
fn sorted<'a>(
    component: &Component,
    description: &'a Description,
) -> Result<(Component, Vec<&'a Variable>), Error> {
    let mut component = component.clone();
    if let Some(mapped) = &component.mapped {
        let inputs = mapped::inputs(&component, mapped, description)?;
        return Ok((component, inputs));
    }
    let mut found = vec![];
    for input in std::mem::take(&mut component.inputs) {
        let name = || format!("{}.{}", component.name, input.name);
        let variable = description.find(&input.name);
        let variable = variable.ok_or_else(|| Error::variable(name(), "does not exist"))?;
        if !variable.can_be_set() {
            let what = "is no input and no tunable parameter";
            return Err(Error::variable(name(), what));
        }
        found.push((input, variable));
    }
    found.sort_by_key(|(_, variable)| variable.family);
    let variables;
    (component.inputs, variables) = found.into_iter().unzip();
    Ok((component, variables))
}

/// Which inputs of a component may have slopes; `inputs` are those of an FMU that is not mapped.
fn follows(component: &Component, inputs: &[&Variable]) -> Vec<bool> {
    let Some(mapped) = &component.mapped else {
        return inputs.iter().map(|variable| variable.follows()).collect();
    };
    let moves = |name: &str| mapped.inputs.iter().any(|l| l.ours == name && l.moves);
    component.inputs.iter().map(|i| moves(&i.name)).collect()
}
