//! Mapping file: which of a supplier's variables stands for which of the contract's, and how.
//!
//! ```text
//! ours = factor * theirs + offset      both in SI; units are converted
//! table: our value or item = the supplier's value or item
//! ```

use crate::error::Error;
use crate::plan::Value;
use indexmap::IndexMap;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Output, the one it follows from, and the exponent of the wheel radius in V = r_w omega_w.
const DERIVED: [(&str, &str, f64); 2] = [
    ("wheel.speed", "vehicle.speed", -1.0),
    ("vehicle.speed", "wheel.speed", 1.0),
];

/// A mapping file that has been read.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Mapping {
    #[serde(skip)]
    path: PathBuf,
    #[serde(rename = "supplier")]
    _supplier: String,
    /// Components that take the supplier's values of equal-named parameters.
    pub share: Vec<String>,
    /// Plant parameters of a system file that this plant does not have.
    pub ignore: Vec<String>,
    pub(crate) inputs: Entries,
    pub(crate) outputs: Entries,
    /// Outputs under names of one's own.
    pub(crate) extra: Entries,
    pub(crate) parameters: Entries,
    /// More values for the components in `share`, by our names, SI.
    pub known: IndexMap<String, Value>,
    /// Component, its variables, their values.
    pub values: IndexMap<String, IndexMap<String, Value>>,
}

/// Our names, and what stands for them.
pub type Entries = IndexMap<String, Entry>;

/// What stands for a variable of ours.
#[derive(Debug, Deserialize)]
#[serde(from = "Written")]
pub enum Entry {
    /// A variable of the FMU.
    Variable(Told),
    /// An output that follows from another one of ours.
    Derived(Derived),
    /// The first output of ours minus the second.
    Difference(Difference),
}

/// How it is written.
#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "needs a variable's name, { variable = … }, { derive = …, radius = … } or { difference = [a, b] }"
)]
enum Written {
    Name(String),
    Variable(Told),
    Derived(Derived),
    Difference(Difference),
}

impl From<Written> for Entry {
    fn from(written: Written) -> Self {
        match written {
            Written::Name(variable) => Self::Variable(Told {
                variable,
                ..Told::default()
            }),
            Written::Variable(told) => Self::Variable(told),
            Written::Derived(derived) => Self::Derived(derived),
            Written::Difference(difference) => Self::Difference(difference),
        }
    }
}

/// A variable of the FMU, and how its value passes.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Told {
    /// Its name.
    pub variable: String,
    /// Its unit where the FMU states none, or a wrong one.
    #[serde(default)]
    pub unit: String,
    /// As above.
    #[serde(default)]
    pub factor: Option<f64>,
    /// As above [SI].
    #[serde(default)]
    pub offset: f64,
    /// Our value or item, theirs.
    #[serde(default)]
    pub table: IndexMap<String, Codes>,
}

/// One value of theirs, or several.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Codes {
    /// One.
    One(Value),
    /// The first is the one that is sent.
    Several(Vec<Value>),
}

/// An output that follows from another one.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Derived {
    derive: String,
    /// Of the wheel [m].
    radius: f64,
}

/// A difference of two outputs.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    difference: [String; 2],
}

impl Mapping {
    /// Reads a mapping file.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(|error| Error::File {
            path: path.to_owned(),
            error,
        })?;
        let read: Result<Self, _> = toml::from_str(&text);
        let mut mapping = read.map_err(|error| Error::Content {
            path: path.to_owned(),
            line: error.span().map_or(0, |span| line(&text, span.start)),
            what: error.message().to_owned(),
        })?;
        path.clone_into(&mut mapping.path);
        Ok(mapping)
    }

    /// Where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error of this file.
    pub fn error(&self, what: impl Into<String>) -> Error {
        Error::Content {
            path: self.path.clone(),
            line: 0,
            what: what.into(),
        }
    }

    /// The outputs that are sums of others of ours, with their weights.
    pub fn sums(&self) -> Result<Vec<(&String, Terms)>, Error> {
        let sums = self.outputs.iter().filter_map(|(name, entry)| {
            let terms = self.terms(name, entry).transpose()?;
            Some(terms.map(|terms| (name, terms)))
        });
        sums.collect()
    }

    fn terms(&self, name: &str, entry: &Entry) -> Result<Option<Terms>, Error> {
        let terms = match entry {
            Entry::Variable(_) => return Ok(None),
            Entry::Difference(Difference {
                difference: [first, second],
            }) => {
                vec![(first.clone(), 1.0), (second.clone(), -1.0)]
            }
            Entry::Derived(Derived { derive, radius }) => {
                let known = DERIVED
                    .iter()
                    .find(|(of, from, _)| *of == name && from == derive);
                let (_, _, power) = known.ok_or_else(|| self.underived(name))?;
                if !(radius.is_normal() && *radius > 0.0) {
                    let what = format!("outputs.{name}: radius = {radius} m must be above 0");
                    return Err(self.error(what));
                }
                vec![(derive.clone(), radius.powf(*power))]
            }
        };
        for (source, _) in &terms {
            let mapped = self.outputs.get(source).and_then(Entry::told);
            if mapped.is_none() {
                let what = format!("outputs.{name}: '{source}' must be mapped to a variable");
                return Err(self.error(what));
            }
        }
        Ok(Some(terms))
    }

    fn underived(&self, name: &str) -> Error {
        let ways = DERIVED.map(|(of, from, _)| format!("\"{of}\" from \"{from}\" with radius"));
        self.error(format!(
            "outputs.{name}: can be derived: {}",
            ways.join("; ")
        ))
    }
}

/// Outputs of ours and their weights.
pub type Terms = Vec<(String, f64)>;

impl Entry {
    /// A variable of the FMU; none for an output that follows from others.
    pub fn told(&self) -> Option<&Told> {
        match self {
            Self::Variable(told) => Some(told),
            Self::Derived(_) | Self::Difference(_) => None,
        }
    }
}

fn line(text: &str, offset: usize) -> usize {
    text.get(..offset).unwrap_or(text).matches('\n').count() + 1
}
