//! A supplier's FMU under the names, units and codings of the loop.

use crate::description::{Causality, Description, Variable};
use crate::error::{Error, Seconds};
use crate::plan::{Component, Link, Mapped, Sum};

/// Carries values between the loop, "ours", and the FMU, "theirs".
#[derive(Debug)]
pub struct Translator {
    send: Translation,
    receive: Translation,
    sums: Vec<Terms>,
    /// Their inputs.
    pub inputs: Vec<f64>,
    /// Time derivatives of their inputs.
    pub slopes: Vec<f64>,
    /// Their outputs.
    pub outputs: Vec<f64>,
    component: String,
    file: String,
}

/// Place of an output, places and weights of those that it is a sum of.
#[derive(Debug)]
struct Terms {
    place: usize,
    terms: Vec<(usize, f64)>,
}

impl Translator {
    /// For their inputs and outputs in use; the order of ours is that of the component.
    pub fn new(
        component: &Component,
        mapped: &Mapped,
        inputs: &[&Variable],
        outputs: &[&Variable],
    ) -> Result<Self, Error> {
        let name = |variable: &&Variable| variable.name.clone();
        let theirs = [inputs, outputs].map(|side| side.iter().map(name).collect::<Vec<_>>());
        let [their_inputs, their_outputs] = &theirs;
        let fed: Vec<String> = component.inputs.iter().map(|i| i.name.clone()).collect();
        let links = mapped.inputs.iter().filter(|link| fed.contains(&link.ours));
        let ours = names(mapped);
        let sums = mapped.sums.iter().map(|sum| Terms::new(sum, &ours));
        Ok(Self {
            send: Translation::outward(links, &fed, their_inputs)?,
            receive: Translation::inward(mapped.outputs.iter(), their_outputs, &ours)?,
            sums: sums.collect::<Result<_, _>>()?,
            inputs: vec![0.0; inputs.len()],
            slopes: vec![0.0; inputs.len()],
            outputs: vec![0.0; outputs.len()],
            component: component.name.clone(),
            file: mapped.file.display().to_string(),
        })
    }

    /// Makes their inputs of ours at `time` [s].
    pub fn send(&mut self, ours: &[f64], time: f64) -> Result<(), Error> {
        let done = self.send.carry(ours, &mut self.inputs);
        done.map_err(|what| self.lost(&what, time))
    }

    /// Makes time derivatives of their inputs of ours.
    pub fn steer(&mut self, ours: &[f64]) {
        self.send.slopes(ours, &mut self.slopes);
    }

    /// Makes our outputs of theirs at `time` [s].
    pub fn receive(&self, ours: &mut [f64], time: f64) -> Result<(), Error> {
        let done = self.receive.carry(&self.outputs, ours);
        done.map_err(|what| self.lost(&what, time))?;
        self.add_up(ours);
        Ok(())
    }

    /// Makes time derivatives of our outputs of those that stand in `outputs`.
    pub fn told(&self, ours: &mut [f64]) {
        ours.fill(0.0);
        self.receive.slopes(&self.outputs, ours);
        self.add_up(ours);
    }

    fn add_up(&self, ours: &mut [f64]) {
        for Terms { place, terms } in &self.sums {
            let values = terms
                .iter()
                .filter_map(|(k, weight)| Some(weight * ours.get(*k)?));
            let sum = values.fold(0.0, |sum, value| sum + value);
            if let Some(place) = ours.get_mut(*place) {
                *place = sum;
            }
        }
    }

    fn lost(&self, what: &str, time: f64) -> Error {
        let Self {
            component, file, ..
        } = self;
        let time = Seconds(time);
        Error::Coding(format!(
            "{component}: {what} at t = {time} s; add it to {file}"
        ))
    }
}

/// Our names of the outputs of a mapped FMU.
pub fn names(mapped: &Mapped) -> Vec<String> {
    let links = mapped.outputs.iter().map(|link| link.ours.clone());
    let sums = mapped.sums.iter().map(|sum| sum.ours.clone());
    links.chain(sums).collect()
}

/// Their inputs that a component feeds, sorted by family.
pub fn inputs<'a>(
    component: &Component,
    mapped: &Mapped,
    description: &'a Description,
) -> Result<Vec<&'a Variable>, Error> {
    for input in &component.inputs {
        let link = mapped.inputs.iter().find(|link| link.ours == input.name);
        let full = || format!("{}.{}", component.name, input.name);
        let link = link.ok_or_else(|| Error::variable(full(), "is not in the mapping"))?;
        if !description
            .find(&link.theirs)
            .is_some_and(Variable::can_be_set)
        {
            let what = format!("is '{}', which is no input of the FMU", link.theirs);
            return Err(Error::variable(full(), what));
        }
    }
    let fed = |link: &&Link| component.inputs.iter().any(|input| input.name == link.ours);
    let wanted: Vec<&str> = mapped
        .inputs
        .iter()
        .filter(fed)
        .map(|link| link.theirs.as_str())
        .collect();
    Ok(description.chosen(|variable| wanted.contains(&variable.name.as_str())))
}

/// Their outputs that ours are made of, sorted by family.
pub fn outputs<'a>(mapped: &Mapped, description: &'a Description) -> Vec<&'a Variable> {
    let named = |name: &str| mapped.outputs.iter().any(|link| link.theirs == name);
    description.chosen(|v| v.causality == Causality::Output && named(&v.name))
}

impl Terms {
    fn new(sum: &Sum, ours: &[String]) -> Result<Self, Error> {
        let terms = sum
            .terms
            .iter()
            .map(|(name, weight)| Ok((place(ours, name)?, *weight)));
        Ok(Self {
            place: place(ours, &sum.ours)?,
            terms: terms.collect::<Result<_, Error>>()?,
        })
    }
}

fn place(names: &[String], name: &str) -> Result<usize, Error> {
    let place = names.iter().position(|known| known == name);
    place.ok_or_else(|| Error::variable(name, "of the mapping does not exist"))
}

/// Carries a vector of values from one side of some links to the other.
#[derive(Debug, Default)]
struct Translation(Vec<Way>);

/// target = gain * source + shift, or the code of the source.
#[derive(Debug)]
struct Way {
    from: usize,
    to: usize,
    gain: f64,
    shift: f64,
    codes: Vec<(f64, f64)>,
    names: (String, String),
}

impl Translation {
    fn outward<'a>(
        links: impl Iterator<Item = &'a Link>,
        ours: &[String],
        theirs: &[String],
    ) -> Result<Self, Error> {
        let ways = links.map(|link| {
            Ok(Way {
                from: place(ours, &link.ours)?,
                to: place(theirs, &link.theirs)?,
                gain: 1.0 / link.gain,
                shift: -link.shift / link.gain,
                codes: link.table.clone(),
                names: (link.ours.clone(), link.theirs.clone()),
            })
        });
        Ok(Self(ways.collect::<Result<_, Error>>()?))
    }

    fn inward<'a>(
        links: impl Iterator<Item = &'a Link>,
        theirs: &[String],
        ours: &[String],
    ) -> Result<Self, Error> {
        let ways = links.map(|link| {
            Ok(Way {
                from: place(theirs, &link.theirs)?,
                to: place(ours, &link.ours)?,
                gain: link.gain,
                shift: link.shift,
                codes: link
                    .table
                    .iter()
                    .map(|(ours, theirs)| (*theirs, *ours))
                    .collect(),
                names: (link.theirs.clone(), link.ours.clone()),
            })
        });
        Ok(Self(ways.collect::<Result<_, Error>>()?))
    }

    fn carry(&self, source: &[f64], target: &mut [f64]) -> Result<(), String> {
        for way in &self.0 {
            let value = source.get(way.from).copied().unwrap_or(f64::NAN);
            if let Some(target) = target.get_mut(way.to) {
                *target = way.carry(value)?;
            }
        }
        Ok(())
    }

    /// Time derivatives: what a table codes has none.
    fn slopes(&self, source: &[f64], target: &mut [f64]) {
        for way in &self.0 {
            let slope = source.get(way.from).copied().unwrap_or(f64::NAN);
            if let Some(target) = target.get_mut(way.to) {
                *target = if way.codes.is_empty() {
                    slope * way.gain
                } else {
                    0.0
                };
            }
        }
    }
}

impl Way {
    fn carry(&self, value: f64) -> Result<f64, String> {
        if self.codes.is_empty() {
            return Ok(value * self.gain + self.shift);
        }
        let row = self.codes.iter().find(|(source, _)| *source == value);
        row.map(|(_, target)| *target).ok_or_else(|| {
            let (name, other) = &self.names;
            format!("{name} = {value} is in no row of the table for '{other}'")
        })
    }
}
