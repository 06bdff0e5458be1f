//! `[noise]` of a system file: what other components read of an output, while the output stays true.
//!
//! `dct-harness` draws it by NumPy, whose normal distribution nothing in Rust repeats to the last bit. So
//! its samples come from results of `dct-harness run`, which has them as columns
//! `scenario.noise.COMPONENT.VARIABLE`.

use crate::description::{Causality, Description, Family};
use crate::error::Error;
use crate::plan::Component;
use crate::scenario::Scenario;
use indexmap::IndexMap;

/// A key of the table that names no output.
const SEED: &str = "seed";

/// Noisy outputs, and their samples.
#[derive(Debug, Default)]
pub struct Noise {
    /// `component.variable`.
    names: Vec<String>,
    drawn: Option<Scenario>,
}

impl Noise {
    /// Of a table of standard deviations.
    pub fn new(table: IndexMap<String, f64>) -> Self {
        let noisy = table
            .into_iter()
            .filter(|(name, deviation)| name != SEED && *deviation != 0.0);
        Self {
            names: noisy.map(|(name, _)| name).collect(),
            drawn: None,
        }
    }

    /// Takes samples from results of `dct-harness run`.
    pub fn take(&mut self, drawn: Scenario) {
        self.drawn = Some(drawn);
    }

    /// Lets inputs read noisy outputs with their noise; returns the signals of the noise that is read.
    pub fn wire(
        &self,
        components: &mut [Component],
        descriptions: &[&Description],
        interpolate: bool,
    ) -> Result<Vec<String>, Error> {
        let mut read = vec![];
        for name in &self.names {
            if !is_real_output(name, components, descriptions) {
                return Err(Error::variable(name, "of [noise] is no real output"));
            }
            if interpolate {
                let what = "of [noise]: white noise has no slopes; leave interpolate out";
                return Err(Error::variable(name, what));
            }
            let inputs = components.iter_mut().flat_map(|part| &mut part.inputs);
            let mut inputs: Vec<_> = inputs.filter(|input| input.source == *name).collect();
            for input in &mut inputs {
                input.noise = Some(format!("scenario.noise.{name}"));
            }
            if !inputs.is_empty() {
                read.push(format!("noise.{name}"));
            }
        }
        Ok(read)
    }

    /// Puts samples of the signals `read` behind those of the scenario, whose `width` values a row has.
    pub fn beside(
        &self,
        rows: Vec<f64>,
        width: usize,
        read: &[String],
        times: &[f64],
    ) -> Result<Vec<f64>, Error> {
        if read.is_empty() {
            return Ok(rows);
        }
        let Some(drawn) = &self.drawn else {
            let what = "noise: none is drawn here; take it from results of `dct-harness run`: --noise results.csv";
            return Err(Error::Usage(what.into()));
        };
        let wrong = |what: String| Error::Content {
            path: drawn.path().to_owned(),
            line: 0,
            what,
        };
        if drawn.times() != times {
            let what =
                "is of other communication points: run dct-harness with the same step and stop";
            return Err(wrong(what.into()));
        }
        let mut columns = vec![];
        for name in read {
            let column = drawn.find(&format!("scenario.{name}"));
            let missing = || wrong(format!("has no column 'scenario.{name}'"));
            columns.push(column.ok_or_else(missing)?);
        }
        let row = |k: usize| {
            let scripted = rows.get(k * width..(k + 1) * width).unwrap_or_default();
            let noise = columns.iter().map(move |column| drawn.at(*column, k));
            scripted.iter().copied().chain(noise)
        };
        Ok((0..times.len()).flat_map(row).collect())
    }
}

fn is_real_output(name: &str, components: &[Component], descriptions: &[&Description]) -> bool {
    let found = name.split_once('.').and_then(|(component, variable)| {
        let place = components.iter().position(|part| part.name == component)?;
        descriptions.get(place)?.find(variable)
    });
    found.is_some_and(|known| known.causality == Causality::Output && known.family == Family::Real)
}
