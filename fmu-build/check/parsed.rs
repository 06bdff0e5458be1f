//! A model description as read from a file: what the check needs of it.

use crate::{Error, Result};
use serde::Deserialize;

/// `fmiModelDescription`.
#[derive(Debug, Deserialize)]
pub(super) struct Description {
    #[serde(rename = "@fmiVersion")]
    pub fmi_version: String,
    #[serde(rename = "@modelName")]
    pub model_name: String,
    #[serde(rename = "@guid")]
    pub guid: String,
    #[serde(rename = "CoSimulation")]
    pub co_simulation: Option<CoSimulation>,
    #[serde(rename = "UnitDefinitions", default)]
    units: UnitDefinitions,
    #[serde(rename = "ModelVariables", default)]
    variables: ModelVariables,
    #[serde(rename = "ModelStructure", default)]
    pub structure: ModelStructure,
}

impl Description {
    /// All variables; the place counts from 1 in `ModelStructure`.
    pub fn variables(&self) -> &[ScalarVariable] {
        &self.variables.variables
    }

    /// Whether a unit of this name is defined.
    pub fn has_unit(&self, name: &str) -> bool {
        self.units.units.iter().any(|unit| unit.name == name)
    }
}

#[derive(Debug, Deserialize)]
pub(super) struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    pub model_identifier: String,
}

#[derive(Debug, Default, Deserialize)]
struct UnitDefinitions {
    #[serde(rename = "Unit", default)]
    units: Vec<UnitElement>,
}

#[derive(Debug, Deserialize)]
struct UnitElement {
    #[serde(rename = "@name")]
    name: String,
}

#[derive(Debug, Default, Deserialize)]
struct ModelVariables {
    #[serde(rename = "ScalarVariable", default)]
    variables: Vec<ScalarVariable>,
}

#[derive(Debug, Deserialize)]
pub(super) struct ScalarVariable {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@valueReference")]
    pub value_reference: u32,
    #[serde(rename = "@causality", default = "local")]
    pub causality: String,
    #[serde(rename = "@initial")]
    pub initial: Option<String>,
    #[serde(rename = "Real")]
    real: Option<Attributes>,
    #[serde(rename = "Integer")]
    integer: Option<Attributes>,
    #[serde(rename = "Boolean")]
    boolean: Option<Attributes>,
    #[serde(rename = "String")]
    string: Option<Attributes>,
    #[serde(rename = "Enumeration")]
    enumeration: Option<Attributes>,
}

fn local() -> String {
    "local".into()
}

/// The attributes of the type element of a variable.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "@unit")]
    pub unit: Option<String>,
    #[serde(rename = "@min")]
    pub min: Option<f64>,
    #[serde(rename = "@max")]
    pub max: Option<f64>,
    #[serde(rename = "@start")]
    pub start: Option<String>,
}

/// How a variable is read through the C interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

impl ScalarVariable {
    /// Type at the C interface and attributes; `None` without a type element.
    pub fn kind(&self) -> Option<(Kind, &Attributes)> {
        let typed = [
            (Kind::Real, &self.real),
            (Kind::Integer, &self.integer),
            (Kind::Integer, &self.enumeration),
            (Kind::Boolean, &self.boolean),
            (Kind::String, &self.string),
        ];
        typed
            .into_iter()
            .find_map(|(kind, attributes)| Some((kind, attributes.as_ref()?)))
    }
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct ModelStructure {
    #[serde(rename = "Outputs", default)]
    pub outputs: Unknowns,
    #[serde(rename = "InitialUnknowns", default)]
    pub initial_unknowns: Unknowns,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct Unknowns {
    #[serde(rename = "Unknown", default)]
    pub unknowns: Vec<Unknown>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Unknown {
    #[serde(rename = "@index")]
    pub index: usize,
    #[serde(rename = "@dependencies")]
    pub dependencies: Option<String>,
}

pub(super) fn parse(text: &str) -> Result<Description> {
    quick_xml::de::from_str(text).map_err(Error::Parse)
}
