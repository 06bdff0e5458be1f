//! The loop: wiring by equal names, initialisation, Gauss-Seidel steps on integer time.

use crate::signals::Kind;
use crate::{Component, Error, Fmu, Scenario};

/// FMUs wired together, ready to step.
///
/// Every signal has one place in one vector, the world: the scenario's signals first, then the
/// outputs of each FMU.
pub struct Master {
    parts: Vec<Part>,
    scenario: Scenario,
    /// Per scenario signal in use: its name, column, and whether it is held between rows.
    script: Vec<(String, usize, bool)>,
    world: Vec<f64>,
    step: f64,
    steps: u32,
}

/// One FMU and where its signals live in the world.
struct Part {
    fmu: Fmu,
    /// World index of each input.
    sources: Vec<usize>,
    /// World index of the first output.
    first: usize,
}

impl Part {
    fn set_inputs(&mut self, world: &[f64]) -> Result<(), Error> {
        let values = self
            .sources
            .iter()
            .map(|source| world.get(*source).copied());
        self.fmu
            .set_inputs(values.map(|value| value.unwrap_or(f64::NAN)))
    }

    fn get_outputs(&mut self, world: &mut [f64]) -> Result<(), Error> {
        let count = self.fmu.outputs.names().len();
        let slots = world
            .get_mut(self.first..self.first + count)
            .unwrap_or_default();
        self.fmu.get_outputs(slots)
    }
}

impl Master {
    /// Loads, wires and initialises; afterwards [`Self::row`] holds the values at t = 0.
    ///
    /// The components run in the given order; `step` [s] is the communication step and `steps` how
    /// many of them there are.
    pub fn new(
        components: &[Component],
        scenario: Scenario,
        step: f64,
        steps: u32,
    ) -> Result<Self, Error> {
        let fmus: Vec<Fmu> = components.iter().map(Fmu::load).collect::<Result<_, _>>()?;
        let mut master = Self::wire(fmus, scenario)?;
        (master.step, master.steps) = (step, steps);
        master.initialize(components)?;
        Ok(master)
    }

    fn wire(fmus: Vec<Fmu>, scenario: Scenario) -> Result<Self, Error> {
        let script = script(&fmus, &scenario)?;
        let mut end = script.len();
        let mut firsts = vec![];
        for fmu in &fmus {
            firsts.push(end);
            end += fmu.outputs.names().len();
        }
        let sources: Vec<Vec<usize>> = fmus
            .iter()
            .map(|fmu| {
                inputs(fmu)
                    .map(|name| source(&fmus, &firsts, &script, fmu, name))
                    .collect()
            })
            .collect::<Result<_, _>>()?;
        let parts = fmus.into_iter().zip(sources).zip(firsts);
        let parts = parts
            .map(|((fmu, sources), first)| Part {
                fmu,
                sources,
                first,
            })
            .collect();
        Ok(Self {
            parts,
            scenario,
            script,
            world: vec![0.0; end],
            step: 0.0,
            steps: 0,
        })
    }

    /// Propagates initial values until every chain of FMUs has been followed.
    fn initialize(&mut self, components: &[Component]) -> Result<(), Error> {
        let stop = self.time(self.steps);
        for (part, component) in self.parts.iter_mut().zip(components) {
            part.fmu.initialize(&component.values, stop)?;
        }
        self.play(0);
        let Self { parts, world, .. } = self;
        parts
            .iter_mut()
            .try_for_each(|part| part.get_outputs(world))?;
        for _ in 0..parts.len() {
            for part in parts.iter_mut() {
                part.set_inputs(world)?;
                part.get_outputs(world)?;
            }
        }
        parts.iter_mut().try_for_each(|part| {
            part.fmu.start()?;
            part.get_outputs(world)
        })
    }

    /// Runs all steps; `record` is called at t = 0 and after each step with the time [s] and the
    /// values, in the order of [`Self::names`].
    pub fn run(&mut self, mut record: impl FnMut(f64, &[f64])) -> Result<(), Error> {
        record(0.0, &self.world);
        for k in 0..self.steps {
            let (time, next) = (self.time(k), self.time(k + 1));
            self.play(k);
            let Self { parts, world, .. } = self;
            for part in parts.iter_mut() {
                part.set_inputs(world)?;
                part.fmu.step(time, next - time)?;
                part.get_outputs(world)?;
            }
            self.play(k + 1);
            record(next, &self.world);
        }
        Ok(())
    }

    /// Communication point k [s].
    fn time(&self, k: u32) -> f64 {
        f64::from(k) * self.step
    }

    /// Writes the scenario's signals at communication point k into the world.
    fn play(&mut self, k: u32) {
        let time = self.time(k);
        for (slot, (_, column, hold)) in self.world.iter_mut().zip(&self.script) {
            *slot = self.scenario.sample(*column, time, *hold);
        }
    }

    /// The signals as `component.variable`, the scenario's first.
    pub fn names(&self) -> Vec<String> {
        let script = self
            .script
            .iter()
            .map(|(name, ..)| format!("scenario.{name}"));
        let outputs = self.parts.iter().flat_map(|part| {
            let names = part.fmu.outputs.names().iter();
            names.map(|(name, _)| format!("{}.{name}", part.fmu.name()))
        });
        script.chain(outputs).collect()
    }

    /// The newest values, in the order of [`Self::names`].
    pub fn row(&self) -> &[f64] {
        &self.world
    }
}

fn inputs(fmu: &Fmu) -> impl Iterator<Item = &str> {
    fmu.inputs.names().iter().map(|(name, _)| name.as_str())
}

fn output(fmu: &Fmu, name: &str) -> Option<usize> {
    fmu.outputs
        .names()
        .iter()
        .position(|(known, _)| known == name)
}

/// The scenario signals that inputs need because no FMU gives them; integers and booleans held.
fn script(fmus: &[Fmu], scenario: &Scenario) -> Result<Vec<(String, usize, bool)>, Error> {
    let mut script: Vec<(String, usize, bool)> = vec![];
    for fmu in fmus {
        for (name, kind) in fmu.inputs.names() {
            let given = others(fmus, fmu).any(|(_, other)| output(other, name).is_some());
            if given || script.iter().any(|(known, ..)| known == name) {
                continue;
            }
            let column = scenario.find(name).ok_or_else(|| Error::Variable {
                name: format!("{}.{name}", fmu.name()),
                what: "has no source: no other FMU and no scenario signal has its name",
            })?;
            script.push((name.clone(), column, *kind != Kind::Real));
        }
    }
    Ok(script)
}

fn others<'a>(fmus: &'a [Fmu], one: &'a Fmu) -> impl Iterator<Item = (usize, &'a Fmu)> {
    fmus.iter()
        .enumerate()
        .filter(|(_, other)| other.name() != one.name())
}

/// World index of an input's one source.
///
/// An estimate carries the name of the truth: where both are there, `control` reads `observer`'s.
fn source(
    fmus: &[Fmu],
    firsts: &[usize],
    script: &[(String, usize, bool)],
    fmu: &Fmu,
    name: &str,
) -> Result<usize, Error> {
    let mut equal = others(fmus, fmu)
        .filter(|(_, other)| output(other, name).is_some())
        .collect::<Vec<_>>();
    if let ("control", [(_, plant), (_, observer)]) = (fmu.name(), equal.as_slice())
        && [plant.name(), observer.name()] == ["plant", "observer"]
    {
        equal.remove(0);
    }
    if equal.len() > 1 {
        let name = format!("{}.{name}", fmu.name());
        return Err(Error::Variable {
            name,
            what: "has several sources",
        });
    }
    let found = equal
        .first()
        .and_then(|(index, other)| Some(firsts.get(*index)? + output(other, name)?));
    let signal = || script.iter().position(|(known, ..)| known == name);
    found.or_else(signal).ok_or_else(|| Error::Variable {
        name: format!("{}.{name}", fmu.name()),
        what: "has no source",
    })
}
