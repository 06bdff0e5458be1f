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
    #[serde(rename = "@generationTool", default)]
    pub generation_tool: String,
    #[serde(rename = "DefaultExperiment", default)]
    pub experiment: Experiment,
    #[serde(rename = "TypeDefinitions", default)]
    pub types: TypeDefinitions,
    #[serde(rename = "LogCategories", default)]
    pub log: LogCategories,
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

    /// Names of the units, in their order.
    pub fn units(&self) -> impl Iterator<Item = &str> {
        self.units.units.iter().map(|unit| unit.name.as_str())
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
    #[serde(rename = "@canGetAndSetFMUstate", default)]
    pub can_save: bool,
    #[serde(rename = "@canSerializeFMUstate", default)]
    pub can_serialize: bool,
    #[serde(rename = "@canHandleVariableCommunicationStepSize", default)]
    pub variable_step: bool,
    #[serde(rename = "@canInterpolateInputs", default)]
    pub interpolates: bool,
    #[serde(rename = "@maxOutputDerivativeOrder", default)]
    pub output_derivatives: u32,
    #[serde(rename = "@providesDirectionalDerivative", default)]
    pub directional: bool,
    #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess", default)]
    pub only_once: bool,
    #[serde(rename = "@canNotUseMemoryManagementFunctions", default)]
    pub own_memory: bool,
    #[serde(rename = "@canRunAsynchronuously", default)]
    pub asynchronous: bool,
    #[serde(rename = "@needsExecutionTool", default)]
    pub needs_tool: bool,
}

/// `DefaultExperiment`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Experiment {
    #[serde(rename = "@startTime")]
    pub start: Option<f64>,
    #[serde(rename = "@stopTime")]
    pub stop: Option<f64>,
    #[serde(rename = "@stepSize")]
    pub step: Option<f64>,
    #[serde(rename = "@tolerance")]
    pub tolerance: Option<f64>,
}

/// `TypeDefinitions`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct TypeDefinitions {
    #[serde(rename = "SimpleType", default)]
    pub types: Vec<SimpleType>,
}

/// A type that variables may name.
#[derive(Debug, Deserialize)]
pub(super) struct SimpleType {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "Enumeration")]
    pub enumeration: Option<Enumeration>,
}

/// The values of an enumeration.
#[derive(Debug, Deserialize)]
pub(super) struct Enumeration {
    #[serde(rename = "Item", default)]
    pub items: Vec<Item>,
}

/// One value of an enumeration.
#[derive(Debug, Deserialize)]
pub(super) struct Item {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@value")]
    pub value: i32,
}

/// `LogCategories`.
#[derive(Debug, Default, Deserialize)]
pub(super) struct LogCategories {
    #[serde(rename = "Category", default)]
    pub categories: Vec<Category>,
}

/// A log category.
#[derive(Debug, Deserialize)]
pub(super) struct Category {
    #[serde(rename = "@name")]
    pub name: String,
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
    #[serde(rename = "@variability", default = "continuous")]
    pub variability: String,
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

fn continuous() -> String {
    "continuous".into()
}

fn local() -> String {
    "local".into()
}

/// The attributes of the type element of a variable.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "@unit")]
    pub unit: Option<String>,
    #[serde(rename = "@displayUnit")]
    pub display_unit: Option<String>,
    #[serde(rename = "@declaredType")]
    pub declared_type: Option<String>,
    #[serde(rename = "@nominal")]
    pub nominal: Option<f64>,
    #[serde(rename = "@derivative")]
    pub derivative: Option<usize>,
    #[serde(rename = "@min")]
    pub min: Option<f64>,
    #[serde(rename = "@max")]
    pub max: Option<f64>,
    #[serde(rename = "@start")]
    pub start: Option<String>,
}

/// How a variable is read through the C interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Real,
    Integer,
    Boolean,
    String,
}

impl ScalarVariable {
    /// Whether it has its start value for ever.
    pub fn is_constant(&self) -> bool {
        self.variability == "constant"
    }

    /// Whether its type is an enumeration.
    pub fn is_enumeration(&self) -> bool {
        self.enumeration.is_some()
    }

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
    #[serde(rename = "Derivatives", default)]
    pub derivatives: Unknowns,
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
    #[serde(rename = "@dependenciesKind")]
    pub dependencies_kind: Option<String>,
}

impl Unknown {
    /// Whether it names the variable at this index, or names none and so means all.
    pub fn may_depend_on(&self, index: usize) -> bool {
        self.dependencies.as_ref().is_none_or(|named| {
            let mut indices = named.split_whitespace().map(str::parse);
            indices.any(|named| named == Ok(index))
        })
    }
}

pub(super) fn parse(text: &str) -> Result<Description> {
    quick_xml::de::from_str(text).map_err(Error::Parse)
}
