//! `modelDescription.xml` of a model, written from its table and its start values.
//!
//! The serde structs are the elements of the FMI 2.0 schema in its order; a field whose name starts
//! with `@` is an attribute. Numbers are text that reads back as the same bits.

pub(crate) mod names;
mod number;
mod structure;
#[cfg(test)]
mod tests;
mod types;
mod units;
mod variables;

use crate::{Error, Result};
use fmi2_cosim::{Category, Model, provides_directional_derivatives};
use quick_xml::se::Serializer;
use serde::Serialize;

pub(crate) use number::finite;
pub(crate) use units::used;
pub(crate) use variables::{causality, limit, started, variability};

const HEADER: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
pub(crate) const GENERATION_TOOL: &str = concat!("fmu-build ", env!("CARGO_PKG_VERSION"));

/// The text of `modelDescription.xml` for model `M`.
///
/// # Errors
/// When a number is not finite or a dependency is not a variable of the model.
pub fn describe<M: Model>() -> Result<String> {
    let mut text = String::from(HEADER);
    let mut serializer = Serializer::new(&mut text);
    serializer.indent(' ', 2);
    document::<M>()?
        .serialize(serializer)
        .map_err(Error::Write)?;
    text.push('\n');
    Ok(text)
}

#[derive(Serialize)]
#[serde(rename = "fmiModelDescription")]
struct Document {
    #[serde(rename = "@fmiVersion")]
    fmi_version: &'static str,
    #[serde(rename = "@modelName")]
    model_name: &'static str,
    #[serde(rename = "@guid")]
    guid: String,
    #[serde(rename = "@description")]
    description: &'static str,
    #[serde(rename = "@version", skip_serializing_if = "str::is_empty")]
    version: &'static str,
    #[serde(rename = "@license", skip_serializing_if = "str::is_empty")]
    license: &'static str,
    #[serde(rename = "@generationTool")]
    generation_tool: &'static str,
    #[serde(rename = "@variableNamingConvention")]
    naming: &'static str,
    #[serde(rename = "CoSimulation")]
    co_simulation: CoSimulation,
    #[serde(rename = "UnitDefinitions", skip_serializing_if = "Option::is_none")]
    units: Option<units::UnitDefinitions>,
    #[serde(rename = "TypeDefinitions", skip_serializing_if = "Option::is_none")]
    types: Option<types::TypeDefinitions>,
    #[serde(rename = "LogCategories")]
    log_categories: LogCategories,
    #[serde(rename = "DefaultExperiment")]
    experiment: DefaultExperiment,
    #[serde(rename = "ModelVariables")]
    variables: variables::ModelVariables,
    #[serde(rename = "ModelStructure")]
    structure: structure::ModelStructure,
}

fn document<M: Model>() -> Result<Document> {
    Ok(Document {
        fmi_version: "2.0",
        model_name: M::NAME,
        guid: fmi2_cosim::guid::<M>(),
        description: M::DESCRIPTION,
        version: M::VERSION,
        license: M::LICENSE,
        generation_tool: GENERATION_TOOL,
        naming: "structured",
        co_simulation: CoSimulation::of::<M>(),
        units: units::definitions(M::VARIABLES)?,
        types: types::definitions(M::VARIABLES)?,
        log_categories: log_categories(),
        experiment: DefaultExperiment::of::<M>()?,
        variables: variables::model_variables::<M>()?,
        structure: structure::model_structure(M::VARIABLES)?,
    })
}

/// What the shell can do; the same for every model except for input and output derivatives.
#[derive(Serialize)]
struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    identifier: &'static str,
    #[serde(rename = "@canHandleVariableCommunicationStepSize")]
    variable_step: bool,
    #[serde(
        rename = "@canInterpolateInputs",
        skip_serializing_if = "std::ops::Not::not"
    )]
    interpolates_inputs: bool,
    #[serde(
        rename = "@maxOutputDerivativeOrder",
        skip_serializing_if = "Option::is_none"
    )]
    output_derivatives: Option<u8>,
    #[serde(
        rename = "@providesDirectionalDerivative",
        skip_serializing_if = "std::ops::Not::not"
    )]
    directional_derivatives: bool,
    #[serde(rename = "@canBeInstantiatedOnlyOncePerProcess")]
    only_once_per_process: bool,
    #[serde(rename = "@canNotUseMemoryManagementFunctions")]
    own_memory: bool,
    #[serde(rename = "@canGetAndSetFMUstate")]
    saves_state: bool,
    #[serde(rename = "@canSerializeFMUstate")]
    serialises_state: bool,
}

impl CoSimulation {
    fn of<M: Model>() -> Self {
        Self {
            identifier: M::NAME,
            variable_step: true,
            interpolates_inputs: M::VARIABLES.iter().any(|row| row.rate.is_some()),
            output_derivatives: M::VARIABLES
                .iter()
                .any(|row| row.slope.is_some())
                .then_some(1),
            directional_derivatives: provides_directional_derivatives::<M>(),
            only_once_per_process: false,
            own_memory: true,
            saves_state: true,
            serialises_state: true,
        }
    }
}

/// The capabilities of model `M` in words.
pub(crate) fn capabilities<M: Model>() -> Vec<&'static str> {
    let can = CoSimulation::of::<M>();
    let all = [
        (can.variable_step, "communication steps of any length"),
        (can.interpolates_inputs, "inputs with derivatives"),
        (can.output_derivatives.is_some(), "output derivatives"),
        (can.directional_derivatives, "directional derivatives"),
        (can.saves_state, "saved states"),
        (can.serialises_state, "serialised states"),
        (!can.only_once_per_process, "any number of instances"),
        (M::RESOURCES, "files of its own under resources"),
    ];
    let offered = all.into_iter().filter(|(offered, _)| *offered);
    offered.map(|(_, words)| words).collect()
}

#[derive(Serialize)]
struct LogCategories {
    #[serde(rename = "Category")]
    categories: Vec<LogCategory>,
}

#[derive(Serialize)]
struct LogCategory {
    #[serde(rename = "@name")]
    name: &'static str,
    #[serde(rename = "@description")]
    description: &'static str,
}

fn log_categories() -> LogCategories {
    let all = [
        (Category::Event, "Something that happened in the model"),
        (
            Category::Warning,
            "Something to look at though the run goes on",
        ),
        (
            Category::Discard,
            "A call that may be repeated with other arguments",
        ),
        (
            Category::Error,
            "A call that was refused or a model that cannot go on",
        ),
        (Category::Fatal, "An instance that can only be freed"),
    ];
    let categories = all.map(|(category, description)| LogCategory {
        name: category_name(category),
        description,
    });
    LogCategories {
        categories: categories.into(),
    }
}

/// The names of FMI 2.0.4, 2.2.4.
fn category_name(category: Category) -> &'static str {
    match category {
        Category::Event => "logEvents",
        Category::Warning => "logStatusWarning",
        Category::Discard => "logStatusDiscard",
        Category::Error => "logStatusError",
        Category::Fatal => "logStatusFatal",
    }
}

#[derive(Serialize)]
struct DefaultExperiment {
    #[serde(rename = "@startTime")]
    start: String,
    #[serde(rename = "@stopTime")]
    stop: String,
    #[serde(rename = "@stepSize")]
    step: String,
}

impl DefaultExperiment {
    fn of<M: Model>() -> Result<Self> {
        let number = |what, value| finite("DefaultExperiment", what, value);
        Ok(Self {
            start: number("startTime", M::EXPERIMENT.start)?,
            stop: number("stopTime", M::EXPERIMENT.stop)?,
            step: number("stepSize", M::EXPERIMENT.step)?,
        })
    }
}
