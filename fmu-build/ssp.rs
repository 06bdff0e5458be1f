//! The closed loop as one file: an SSP 1.0 archive of FMUs with their connections.
//!
//! An input takes the output of the same name, the control's that of the observer; what no FMU gives
//! becomes an input of the system.

use crate::port::{Kind, Port};
use crate::xml::Element;
use crate::{Entry, Error, Result, package};
use fmi2_cosim::{Enumeration, Unit};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructure";

// A control reads what the observer estimates, not what only the plant knows.
const PLANT: &str = "plant";
const OBSERVER: &str = "observer";
const CONTROL: &str = "control";

/// A component of the system.
pub struct Component {
    /// Its name in the system.
    pub name: &'static str,
    /// Its model.
    pub entry: &'static Entry,
}

/// Writes the system `name` of `components` to `path`; the FMUs are taken from folder `fmus`.
///
/// # Errors
/// When an FMU cannot be read, the archive not be written, or an input has two sources.
pub fn write(path: &Path, name: &str, components: &[Component], fmus: &Path) -> Result<()> {
    let mut members = vec![(
        "SystemStructure.ssd".to_owned(),
        description(name, components)?.into_bytes(),
    )];
    for component in components {
        let file = format!("{}.fmu", component.entry.name);
        let source = fmus.join(&file);
        let bytes = fs::read(&source).map_err(|error| match error.kind() {
            ErrorKind::NotFound => Error::NotBuilt { path: source },
            _ => Error::Io {
                path: source,
                source: error,
            },
        })?;
        members.push((format!("resources/{file}"), bytes));
    }
    package(path, members)
}

fn description(name: &str, components: &[Component]) -> Result<String> {
    let ports: Vec<_> = components.iter().map(|one| (one.entry.ports)()).collect();
    let inputs = open_inputs(&ports);
    let elements = components
        .iter()
        .zip(&ports)
        .map(|(one, ports)| element(one, ports));
    let system = Element::new("ssd:System")
        .with("name", name)
        .holding(connectors(&inputs))
        .holding([Element::new("ssd:Elements").holding(elements)])
        .holding([Element::new("ssd:Connections").holding(connections(components, &ports)?)]);
    let last = components.last().map(|one| one.entry.experiment);
    let experiment = last.map(|experiment| {
        Element::new("ssd:DefaultExperiment")
            .with("startTime", experiment.start)
            .with("stopTime", experiment.stop)
    });
    let all: Vec<Port> = ports.concat();
    let root = Element::new("ssd:SystemStructureDescription")
        .with("xmlns:ssd", format!("{NAMESPACE}Description"))
        .with("xmlns:ssc", format!("{NAMESPACE}Common"))
        .with("version", "1.0")
        .with("name", name)
        .with(
            "generationTool",
            concat!("fmu-build ", env!("CARGO_PKG_VERSION")),
        );
    let root = root
        .holding([system])
        .holding(enumerations(&all))
        .holding([units(&all)]);
    Ok(root.holding(experiment).document())
}

fn has_output(ports: &[Port], name: &str) -> bool {
    ports
        .iter()
        .any(|port| !port.is_input() && port.name == name)
}

/// Inputs that no component gives, each once.
fn open_inputs(components: &[Vec<Port>]) -> Vec<Port> {
    let given = |name: &str| components.iter().any(|ports| has_output(ports, name));
    let mut open: Vec<Port> = Vec::new();
    for port in components.iter().flatten().filter(|port| port.is_input()) {
        if !given(port.name) && open.iter().all(|other| other.name != port.name) {
            open.push(*port);
        }
    }
    open
}

fn element(component: &Component, ports: &[Port]) -> Element {
    Element::new("ssd:Component")
        .with("name", component.name)
        .with("type", "application/x-fmu-sharedlibrary")
        .with("source", format!("resources/{}.fmu", component.entry.name))
        .with("implementation", "CoSimulation")
        .holding(connectors(ports))
}

fn connectors(ports: &[Port]) -> Option<Element> {
    let connector = |port: &Port| {
        Element::new("ssd:Connector")
            .with("name", port.name)
            .with("kind", port.role())
            .holding([kind(port)])
    };
    let connectors = ports.iter().map(connector);
    (!ports.is_empty()).then(|| Element::new("ssd:Connectors").holding(connectors))
}

fn kind(port: &Port) -> Element {
    match port.kind {
        Kind::Real(unit) => Element::new("ssc:Real").with("unit", unit.name),
        Kind::Integer => Element::new("ssc:Integer"),
        Kind::Boolean => Element::new("ssc:Boolean"),
        Kind::String => Element::new("ssc:String"),
        Kind::Enumeration(kind) => Element::new("ssc:Enumeration").with("name", kind.name),
    }
}

/// Every input with its one source: a component, or the system.
fn connections(components: &[Component], ports: &[Vec<Port>]) -> Result<Vec<Element>> {
    let mut all = Vec::new();
    for (to, inputs) in components.iter().zip(ports) {
        for port in inputs.iter().filter(|port| port.is_input()) {
            let given = components.iter().zip(ports);
            let given = given.filter(|(_, ports)| has_output(ports, port.name));
            let sources: Vec<_> = given.map(|(one, _)| one.name).collect();
            let first = match (to.name, sources.as_slice()) {
                (CONTROL, [PLANT, OBSERVER]) => Some(OBSERVER),
                (_, [one, other, ..]) => {
                    return Err(Error::TwoSources {
                        variable: format!("{}.{}", to.name, port.name),
                        components: [*one, *other],
                    });
                }
                (_, rest) => rest.first().copied(),
            };
            let mut connection = Element::new("ssd:Connection");
            if let Some(from) = first {
                connection = connection.with("startElement", from);
            }
            let connection = connection.with("startConnector", port.name);
            all.push(
                connection
                    .with("endElement", to.name)
                    .with("endConnector", port.name),
            );
        }
    }
    Ok(all)
}

fn enumerations(ports: &[Port]) -> Option<Element> {
    let mut used: Vec<&Enumeration> = Vec::new();
    for port in ports {
        match port.kind {
            Kind::Enumeration(kind) if !used.contains(&kind) => used.push(kind),
            _ => {}
        }
    }
    let element = |kind: &&Enumeration| {
        let item = |item: &fmi2_cosim::Item| {
            Element::new("ssc:Item")
                .with("name", item.name)
                .with("value", item.value)
        };
        Element::new("ssc:Enumeration")
            .with("name", kind.name)
            .holding(kind.items.iter().map(item))
    };
    let elements = used.iter().map(element);
    (!used.is_empty()).then(|| Element::new("ssd:Enumerations").holding(elements))
}

fn units(ports: &[Port]) -> Element {
    let mut used: Vec<Unit> = Vec::new();
    for port in ports {
        match port.kind {
            Kind::Real(unit) if !used.iter().any(|other| other.name == unit.name) => {
                used.push(unit)
            }
            _ => {}
        }
    }
    Element::new("ssd:Units").holding(used.iter().map(unit))
}

fn unit(unit: &Unit) -> Element {
    let exponents = Unit::BASE.into_iter().zip(unit.exponents);
    let base = exponents.filter(|(_, exponent)| *exponent != 0);
    let base = base.fold(Element::new("ssc:BaseUnit"), |base, (name, exponent)| {
        base.with(name, exponent)
    });
    Element::new("ssc:Unit")
        .with("name", unit.name)
        .holding([base])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::{CLOSED_LOOP, COMPONENTS};

    #[test]
    fn where_the_fmus_are_not_built_the_error_tells_what_builds_them() {
        let folder = std::env::temp_dir().join(format!("ssp-{}-missing", std::process::id()));
        let path = folder.join("loop.ssp");
        let error = write(&path, CLOSED_LOOP, COMPONENTS, &folder)
            .err()
            .unwrap();
        let shown = folder.display();
        assert_eq!(
            error.to_string(),
            format!("there is no {shown}/DctPlant.fmu; `cargo fmu build --out {shown}` makes it")
        );
        assert!(!folder.exists());
    }
}
