//! A closed loop with everything decided: which FMUs, which values, which input reads what.
//!
//! `system` makes a plan from a system file; the Python harness sends one of its own.

use serde::Deserialize;
use std::fmt;
use std::path::PathBuf;

/// A loop, ready to be loaded.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Plan {
    /// FMUs in the order in which they step.
    pub components: Vec<Component>,
    /// When outputs reach inputs.
    #[serde(default)]
    pub coupling: Coupling,
    /// Names of the scenario's signals that are in use, without `scenario.`.
    pub script: Vec<String>,
    /// Inputs have slopes within a step, where their FMU can follow them.
    #[serde(default)]
    pub interpolate: bool,
    /// FMUs that this project did not build are asked to log what they do, too.
    #[serde(default)]
    pub log: bool,
    /// Signals that are kept of every step; all of them when none are named. Outputs that are
    /// neither kept nor read by an input are not asked for, but for a look at every 128th point and
    /// at the first and last: one that is no number then ends the run.
    #[serde(default)]
    pub record: Option<Vec<String>>,
}

/// When an output reaches the inputs that read it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coupling {
    /// Within the same step, for components further down.
    #[default]
    GaussSeidel,
    /// At the end of the step.
    Jacobi,
}

/// One FMU of a plan.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Component {
    /// Name in results and errors, e.g. `plant`.
    pub name: String,
    /// The FMU file.
    pub fmu: PathBuf,
    /// Parameters and start values by variable name.
    #[serde(default)]
    pub start: Vec<(String, Value)>,
    /// Inputs that something feeds; all others keep their start values.
    pub inputs: Vec<Input>,
    /// Equal steps of this component in a communication step.
    #[serde(default = "one")]
    pub substeps: u32,
    /// What stands between the names, units and codings of the loop and those of the FMU.
    #[serde(default)]
    pub mapped: Option<Mapped>,
}

/// A supplier's FMU under other names: "ours" are those of the loop, "theirs" those of the FMU.
///
/// `start` has their names; the component's inputs and outputs are ours.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Mapped {
    /// The mapping file, for messages.
    pub file: PathBuf,
    /// One for each input.
    pub inputs: Vec<Link>,
    /// Outputs, in the order in which they are recorded.
    pub outputs: Vec<Link>,
    /// More outputs, after those.
    #[serde(default)]
    pub sums: Vec<Sum>,
}

/// ours = gain * theirs + shift, or a table.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Link {
    /// Our name.
    pub ours: String,
    /// Their name.
    pub theirs: String,
    /// As above.
    #[serde(default = "unit")]
    pub gain: f64,
    /// As above.
    #[serde(default)]
    pub shift: f64,
    /// Pairs ours, theirs that stand instead of the line. Of several of theirs the first is sent.
    #[serde(default)]
    pub table: Vec<(f64, f64)>,
    /// Whether ours may have a slope within a step.
    #[serde(default)]
    pub moves: bool,
}

fn unit() -> f64 {
    1.0
}

/// An output that is a weighted sum of others of ours.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Sum {
    /// Our name.
    pub ours: String,
    /// Our names of the others, and their weights.
    pub terms: Vec<(String, f64)>,
    /// As in `Link`.
    #[serde(default)]
    pub moves: bool,
}

fn one() -> u32 {
    1
}

/// Where an input's value comes from and what happens to it on its way.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Input {
    /// The input's name in its FMU.
    pub name: String,
    /// `component.variable`, or `scenario.signal`.
    pub source: String,
    /// value = factor * source + offset; (1, 0) changes nothing.
    #[serde(default = "unchanged")]
    pub line: (f64, f64),
    /// Pairs source, value that stand instead of the line.
    #[serde(default)]
    pub table: Vec<(f64, f64)>,
    /// A `scenario.signal` that is added to the source's value first.
    #[serde(default)]
    pub noise: Option<String>,
    /// Its value in initialisation mode, where somebody has settled all of them.
    #[serde(default)]
    pub initial: Option<f64>,
}

fn unchanged() -> (f64, f64) {
    (1.0, 0.0)
}

/// A `connections` entry of a system file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Connection {
    /// The source.
    pub from: String,
    /// The input.
    pub to: String,
    /// to = factor * from + offset, instead of the conversion of units.
    pub factor: Option<f64>,
    /// As `factor`.
    pub offset: Option<f64>,
    /// Pairs source, value that stand instead of the line; an .ssp has them.
    #[serde(skip)]
    pub table: Vec<(f64, f64)>,
}

impl Connection {
    /// Factor and offset, when at least one is given.
    pub fn line(&self) -> Option<(f64, f64)> {
        let given = self.factor.or(self.offset);
        given.map(|_| (self.factor.unwrap_or(1.0), self.offset.unwrap_or(0.0)))
    }
}

/// A parameter or start value.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// For a Boolean variable.
    Boolean(bool),
    /// For a Real, Integer or Enumeration variable.
    Number(f64),
    /// An item of an enumeration.
    Text(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value}"),
            Self::Text(text) => write!(f, "'{text}'"),
        }
    }
}

/// Communication points k * step [s]; the last step is shorter when `stop` is no multiple.
pub fn communication_points(step: f64, stop: f64) -> Vec<f64> {
    /// Relative; a stop this close to a multiple of the step is one.
    const TOLERANCE: f64 = 1e-9;
    let count = stop / step;
    let near = count.round_ties_even();
    let whole = (count - near).abs() <= TOLERANCE * count.max(1.0);
    let last = if whole { near } else { count.ceil() };
    let mut times = vec![];
    let mut k = 0.0;
    while k < last {
        times.push(k * step);
        k += 1.0;
    }
    times.push(stop);
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_point_is_the_stop() {
        for (step, stop, points) in [(0.1, 0.3, 4), (0.1, 0.35, 5), (1e-3, 30.0, 30_001)] {
            let times = communication_points(step, stop);
            assert_eq!(times.len(), points, "{step} {stop}");
            assert_eq!(times.last(), Some(&stop));
            assert_eq!(times.first(), Some(&0.0));
        }
    }

    #[test]
    fn a_plan_is_read_from_json() {
        let text = r#"{"components": [{"name": "plant", "fmu": "P.fmu", "start": [["a", true], ["b", 2], ["c", "open"]],
            "inputs": [{"name": "u", "source": "scenario.u"}]}], "coupling": "jacobi", "script": ["u"]}"#;
        let plan: Plan = serde_json::from_str(text).unwrap();
        assert_eq!(plan.coupling, Coupling::Jacobi);
        let [plant] = plan.components.as_slice() else {
            panic!("{plan:?}")
        };
        assert_eq!(plant.inputs[0].line, (1.0, 0.0));
        assert_eq!(plant.substeps, 1);
        let values: Vec<_> = plant.start.iter().map(|(_, value)| value.clone()).collect();
        assert_eq!(
            values,
            [
                Value::Boolean(true),
                Value::Number(2.0),
                Value::Text("open".into())
            ]
        );
    }
}
