//! What connects an FMU with others: its inputs and outputs, and the terminals that bundle them.

use crate::description::causality;
use crate::description::names::{self, Named};
use crate::xml::Element;
use fmi2_cosim::{Access, Causality, Enumeration, Model, Unit};

/// An input or output.
#[derive(Clone, Copy)]
pub struct Port {
    /// Name of the variable.
    pub name: &'static str,
    /// Input or output.
    pub causality: Causality,
    pub(crate) kind: Kind,
}

/// Type of a port.
#[derive(Clone, Copy)]
pub(crate) enum Kind {
    Real(Unit),
    Integer,
    Boolean,
    String,
    Enumeration(&'static Enumeration),
}

/// The ports of model `M`, in the order of its table.
pub(crate) fn ports<M: Model>() -> Vec<Port> {
    names::all(M::VARIABLES).filter_map(port).collect()
}

fn port<M>(named: Named<'_, M>) -> Option<Port> {
    let causality = named.causality();
    let is_port = matches!(causality, Causality::Input | Causality::Output);
    is_port.then_some(Port {
        name: named.name(),
        causality,
        kind: match named.row.access {
            Access::Real(_) => Kind::Real(named.row.unit),
            Access::Integer(_) => Kind::Integer,
            Access::Boolean(_) => Kind::Boolean,
            Access::String(_) => Kind::String,
            Access::Enumeration(_, kind) => Kind::Enumeration(kind),
        },
    })
}

impl Port {
    pub(crate) const fn is_input(&self) -> bool {
        matches!(self.causality, Causality::Input)
    }

    /// `input` or `output`.
    pub(crate) fn role(&self) -> &'static str {
        causality(self.causality)
    }
}

/// Ports that belong together: a tool that knows terminals connects them with one line.
pub struct Terminal {
    /// Name, the same in every FMU.
    pub name: &'static str,
    /// Terminals of one kind may be connected.
    pub kind: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Names of the ports; an FMU has those that are in its table.
    pub members: &'static [&'static str],
}

/// The terminals that have a member among the ports, with the members' names.
pub(crate) fn present(
    all: &'static [Terminal],
    ports: &[Port],
) -> Vec<(&'static Terminal, Vec<&'static str>)> {
    let members = |terminal: &'static Terminal| {
        let names = ports.iter().map(|port| port.name);
        let names: Vec<_> = names
            .filter(|name| terminal.members.contains(name))
            .collect();
        (terminal, names)
    };
    let found = all.iter().map(members);
    found.filter(|(_, members)| !members.is_empty()).collect()
}

/// `terminalsAndIcons.xml` of FMI 3.0, which tools read from FMUs of FMI 2.0 too; `None` when no
/// terminal has a member among the ports.
pub(crate) fn terminals(all: &'static [Terminal], ports: &[Port]) -> Option<String> {
    let elements = present(all, ports);
    let elements: Vec<_> = elements.iter().map(element).collect();
    let root = Element::new("fmiTerminalsAndIcons").with("fmiVersion", "3.0");
    (!elements.is_empty()).then(|| {
        root.holding([Element::new("Terminals").holding(elements)])
            .document()
    })
}

/// The rule `bus`: members of the same name are connected, others are left open.
fn element((terminal, members): &(&Terminal, Vec<&'static str>)) -> Element {
    Element::new("Terminal")
        .with("name", terminal.name)
        .with("matchingRule", "bus")
        .with("terminalKind", terminal.kind)
        .with("description", terminal.description)
        .holding(members.iter().copied().map(member))
}

fn member(name: &str) -> Element {
    Element::new("TerminalMemberVariable")
        .with("variableName", name)
        .with("memberName", name)
        .with("variableKind", "signal")
}
