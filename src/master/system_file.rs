//! A system file (.toml) of `dct-harness` as it is written.

use crate::error::Error;
use crate::names::Name;
use crate::plan::{Connection, Coupling, Value};
use indexmap::IndexMap;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// Reads a system file; of a file that cannot be one the error says what it should be.
pub fn text(path: &Path) -> Result<String, Error> {
    std::fs::read_to_string(path).map_err(|error| {
        let what = match error.kind() {
            ErrorKind::IsADirectory => "is a folder: name the system file itself, a .toml or .ssp",
            ErrorKind::InvalidData => "is no text in UTF-8: a system file is a .toml or .ssp",
            _ => {
                let path = path.to_owned();
                return Error::File { path, error };
            }
        };
        Error::Content {
            path: path.to_owned(),
            line: 0,
            what: what.into(),
        }
    })
}

/// A system file as it is written. Limits on KPIs are judged by `dct-harness`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct File {
    pub system: Head,
    /// Judged by `dct-harness`.
    #[serde(default, rename = "kpis")]
    pub _kpis: Option<toml::Value>,
    pub components: IndexMap<Name, Part>,
    #[serde(default)]
    pub connections: Vec<Connection>,
    #[serde(default)]
    pub noise: IndexMap<String, f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    pub name: String,
    #[serde(default, rename = "title")]
    pub _title: Option<String>,
    pub step: f64,
    pub stop: f64,
    pub scenario: PathBuf,
    #[serde(default)]
    pub coupling: Coupling,
    #[serde(default)]
    pub interpolate: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    pub fmu: PathBuf,
    #[serde(default)]
    pub parameters: Parameters,
    #[serde(default = "one")]
    pub substeps: NonZeroU32,
}

fn one() -> NonZeroU32 {
    NonZeroU32::MIN
}

/// A table of values, the name of a parameter file, or a list of both.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Parameters {
    One(Set),
    Several(Vec<Set>),
}

impl Default for Parameters {
    fn default() -> Self {
        Self::Several(vec![])
    }
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Set {
    File(PathBuf),
    Values(BTreeMap<String, Value>),
}
