//! SSP 1.0 and 2.0 system files (.ssp) of FMI 2.0 components, as `dct-harness` reads them.
//!
//! Nested systems, connections, linear and table transformations, units, parameter sets (.ssv, inline or in
//! files) with parameter mappings (.ssm). Inputs of the system are columns of the scenario.
//!
//! ```text
//! X.ssp ──> Package ──> Structure ──> Values ──> Told: components, connections, values
//!            (files)     (flat)        (.ssv)
//! ```

mod change;
mod package;
mod structure;
mod values;
mod xml;

pub use package::Package;

use crate::error::Error;
use crate::library::Libraries;
use crate::plan::{Connection, Coupling, Value};
use change::Change;
use package::STRUCTURE;
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use structure::{End, Structure};
use values::Values;
use xml::{Node, at, elements, every, number, one, parsed, tag, text};

/// What `export-ssp` notes beside SSP.
const ANNOTATION: &str = "dct-harness";

/// Communication step where nobody says another one [s].
const STEP: f64 = 1e-3;

/// A component of the flat system.
pub struct Member {
    /// `outer/inner/component`.
    pub name: String,
    /// Its FMU, unpacked.
    pub fmu: PathBuf,
    /// Parameters and start values.
    pub values: BTreeMap<String, Value>,
    /// Equal steps in a communication step.
    pub substeps: NonZeroU32,
}

/// What a system file says.
pub struct Told {
    /// Name of the system.
    pub name: String,
    /// Communication step [s].
    pub step: f64,
    /// End of the run [s]; none where the file tells none.
    pub stop: Option<f64>,
    /// The scenario inside, if there is one.
    pub scenario: Option<PathBuf>,
    /// When outputs reach inputs.
    pub coupling: Coupling,
    /// Whether inputs have slopes within a step.
    pub interpolate: bool,
    /// In the order of the file.
    pub members: Vec<Member>,
    /// All of them: other inputs keep their start values.
    pub connections: Vec<Connection>,
}

/// Whether a file is named as an .ssp is.
pub fn is_one(path: &Path) -> bool {
    let suffix = path.extension().unwrap_or_default();
    suffix.eq_ignore_ascii_case("ssp")
}

/// Reads a system; its FMUs are opened, and lie in the package.
pub fn read(package: &Package, libraries: &mut Libraries) -> Result<Told, Error> {
    let (file, text_inside) = (package.named(STRUCTURE), package.text(STRUCTURE)?);
    let document = parsed(&file, &text_inside)?;
    let root = document.root_element();
    let version = text(root, "version");
    if !version.starts_with("1.") && !version.starts_with("2.") {
        let what = format!("is of SSP version '{version}'; known are 1.0 and 2.0");
        return Err(at(&file, root, what));
    }
    let mut structure = Structure::new(file, root)?;
    let fmus = opened(package, &mut structure, libraries)?;
    structure.connect()?;
    let mut values = Values::new(package, &structure)?;
    let connections = connections(&structure, &mut values)?;
    let notes = notes(root);
    let members = members(&structure, fmus, values, notes)?;
    told(package, &structure, root, notes, (members, connections))
}

fn told(
    package: &Package,
    structure: &Structure<'_>,
    root: Node<'_>,
    notes: Option<Node<'_>>,
    (members, connections): (Vec<Member>, Vec<Connection>),
) -> Result<Told, Error> {
    let file = &structure.file;
    let note = |name| notes.and_then(|node| node.attribute(name));
    let stem = || {
        package
            .path()
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let coupling = coupling(note("coupling")).map_err(|what| at(file, notes.unwrap_or(root), what));
    let scenario = note("scenario").map(|name| {
        let found = package.file(name);
        found.ok_or_else(|| at(file, notes.unwrap_or(root), format!("has no '{name}'")))
    });
    let experiment = one(root, "DefaultExperiment").filter(|node| node.has_attribute("stopTime"));
    let stop = experiment.map(|node| number(file, node, "stopTime", f64::NAN));
    let name = structure
        .root
        .attribute("name")
        .filter(|name| !name.is_empty());
    Ok(Told {
        name: name.map_or_else(stem, str::to_owned),
        step: notes.map_or(Ok(STEP), |node| number(file, node, "step", STEP))?,
        stop: stop.transpose()?,
        scenario: scenario.transpose()?,
        coupling: coupling?,
        interpolate: note("interpolate") == Some("true"),
        members,
        connections,
    })
}

fn coupling(noted: Option<&str>) -> Result<Coupling, String> {
    match noted {
        None | Some("gauss-seidel") => Ok(Coupling::GaussSeidel),
        Some("jacobi") => Ok(Coupling::Jacobi),
        Some(other) => Err(format!(
            "coupling = '{other}' is neither gauss-seidel nor jacobi"
        )),
    }
}

/// What `export-ssp` has noted.
fn notes<'d>(root: Node<'d>) -> Option<Node<'d>> {
    let all = every(root, "Annotations", "Annotation").into_iter();
    let mut ours = all.filter(|node| text(*node, "type") == ANNOTATION);
    ours.find_map(|node| elements(node).next())
}

/// Opens the FMUs of all components.
fn opened(
    package: &Package,
    structure: &mut Structure<'_>,
    libraries: &mut Libraries,
) -> Result<Vec<PathBuf>, Error> {
    let mut files = vec![];
    for (name, element) in &structure.components {
        let source = text(*element, "source");
        let missing = || format!("component '{name}' has no file '{source}' inside");
        let fmu = package.file(source);
        let fmu = fmu.ok_or_else(|| at(&structure.file, *element, missing()))?;
        structure.fmus.insert(name.clone(), libraries.open(&fmu)?);
        files.push(fmu);
    }
    Ok(files)
}

/// All connections of inputs; what is bound to connectors becomes a value.
fn connections(
    structure: &Structure<'_>,
    values: &mut Values<'_, '_>,
) -> Result<Vec<Connection>, Error> {
    let mut found = vec![];
    for (taker, source, change) in structure.feeds()? {
        let known = source.element.is_empty() || structure.components.contains_key(&source.element);
        if !values.pass_on(&source, &taker, &change)? && known {
            found.push(connection(&taker, &source, change));
        }
    }
    Ok(found)
}

fn connection(taker: &End, source: &End, change: Change) -> Connection {
    let giver = match source.element.as_str() {
        "" => "scenario",
        element => element,
    };
    Connection {
        from: format!("{giver}.{}", source.name),
        to: taker.to_string(),
        factor: Some(change.factor),
        offset: Some(change.offset),
        table: change.table,
    }
}

fn members(
    structure: &Structure<'_>,
    fmus: Vec<PathBuf>,
    mut values: Values<'_, '_>,
    notes: Option<Node<'_>>,
) -> Result<Vec<Member>, Error> {
    let all = structure.components.keys().zip(fmus);
    let mut members: Vec<Member> = all
        .map(|(name, fmu)| Member {
            values: values.of.remove(name).unwrap_or_default(),
            name: name.clone(),
            fmu,
            substeps: NonZeroU32::MIN,
        })
        .collect();
    let notes = notes.into_iter().flat_map(elements);
    for note in notes.filter(|note| tag(*note) == "Substeps") {
        let (name, count) = (text(note, "component"), text(note, "count"));
        let member = members.iter_mut().find(|member| member.name == name);
        let what = || format!("Substeps: component '{name}', count '{count}'");
        let (Some(member), Ok(count)) = (member, count.parse()) else {
            return Err(at(&structure.file, note, what()));
        };
        member.substeps = count;
    }
    Ok(members)
}
