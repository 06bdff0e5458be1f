//! The systems inside a system structure as one flat system: components, and who feeds whom with what change.
//!
//! A component of a nested system is called `outer/inner/component`. Connectors of systems are passed
//! through: units, transformations and values that are bound to them add up on the way.

use super::change::{Change, told};
use super::xml::{Node, at, elements, every, number, one, real, tag, text, unit};
use crate::description::{Causality, Description, Family, Variable};
use crate::error::Error;
use crate::known_units;
use crate::library::Library;
use crate::suggest::did_you_mean;
use crate::unit::Unit;
use indexmap::IndexMap;
use std::collections::HashMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

const GIVE: [&str; 3] = ["output", "calculatedParameter", "constant"];
const TAKE: [&str; 3] = ["input", "parameter", "structuralParameter"];
const FMU: &str = "application/x-fmu-sharedlibrary";

/// Systems inside each other: more are a mistake.
const DEEPEST: usize = 64;

/// Connections from a source to an input: more are a ring.
const LONGEST: usize = 1000;

/// A connector of a component, or of a system (the root is "").
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct End {
    /// Full name of the component or system.
    pub element: String,
    /// Its connector.
    pub name: String,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.element.is_empty() {
            return f.write_str(&self.name);
        }
        write!(f, "{}.{}", self.element, self.name)
    }
}

/// A connection: who gives, and where it stands.
type Hop<'d> = (End, Node<'d>);

/// Components and connections; connections once the FMUs are described.
pub struct Structure<'d> {
    /// Where it stands, for errors.
    pub file: PathBuf,
    /// The outermost system.
    pub root: Node<'d>,
    /// Components by full name.
    pub components: IndexMap<String, Node<'d>>,
    /// Systems by full name.
    pub systems: IndexMap<String, Node<'d>>,
    /// FMUs by full name of their component; set from outside.
    pub fmus: HashMap<String, Arc<Library>>,
    hops: IndexMap<End, Hop<'d>>,
    connectors: HashMap<End, Node<'d>>,
    units: HashMap<&'d str, Unit>,
    codes: HashMap<&'d str, Vec<(&'d str, f64)>>,
}

impl<'d> Structure<'d> {
    /// Reads the components and systems of a description.
    pub fn new(file: PathBuf, description: Node<'d>) -> Result<Self, Error> {
        let root = one(description, "System");
        let root = root.ok_or_else(|| at(&file, description, "has no System"))?;
        let mut units = HashMap::new();
        for node in every(description, "Units", "Unit") {
            units.insert(text(node, "name"), unit(&file, node)?);
        }
        let mut structure = Self {
            root,
            components: IndexMap::new(),
            systems: IndexMap::new(),
            fmus: HashMap::new(),
            hops: IndexMap::new(),
            connectors: HashMap::new(),
            units,
            codes: HashMap::new(),
            file,
        };
        for kind in every(description, "Enumerations", "Enumeration") {
            let items = elements(kind).map(|item| {
                let value = number(&structure.file, item, "value", 0.0)?;
                Ok((text(item, "name"), value))
            });
            let items = items.collect::<Result<_, Error>>()?;
            structure.codes.insert(text(kind, "name"), items);
        }
        structure.collect(root, String::new(), 0)?;
        Ok(structure)
    }

    fn fault(&self, node: Node<'_>, what: impl Into<String>) -> Error {
        at(&self.file, node, what)
    }

    /// Notes a system, its components, and the systems inside it.
    fn collect(&mut self, system: Node<'d>, name: String, depth: usize) -> Result<(), Error> {
        if depth > DEEPEST {
            let what = format!("systems lie more than {DEEPEST} deep in each other");
            return Err(self.fault(system, what));
        }
        self.note_connectors(system, &name)?;
        self.systems.insert(name.clone(), system);
        for element in one(system, "Elements").into_iter().flat_map(elements) {
            let full = self.full(&name, element)?;
            match tag(element) {
                "System" => self.collect(element, full, depth + 1)?,
                "Component" => self.component(element, full)?,
                other => {
                    let what = format!(
                        "{other} '{full}' is not supported: put components or systems in its place"
                    );
                    return Err(self.fault(element, what));
                }
            }
        }
        Ok(())
    }

    fn full(&self, system: &str, element: Node<'_>) -> Result<String, Error> {
        let name = text(element, "name");
        if name.is_empty() || name.contains(['.', '/']) || name == "scenario" {
            let what = format!(
                "an element is called '{name}'; '.', '/' and 'scenario' have a meaning in results: rename it"
            );
            return Err(self.fault(element, what));
        }
        let full = inside(system) + name;
        if self.is_element(&full) {
            return Err(self.fault(element, format!("two elements are called '{full}'")));
        }
        Ok(full)
    }

    fn is_element(&self, name: &str) -> bool {
        self.components.contains_key(name) || self.systems.contains_key(name)
    }

    fn component(&mut self, element: Node<'d>, name: String) -> Result<(), Error> {
        let kind = element.attribute("type").unwrap_or(FMU);
        if kind != FMU {
            let what = format!(
                "component '{name}' is of type {kind}; only FMUs can run: put the system itself in its place"
            );
            return Err(self.fault(element, what));
        }
        self.note_connectors(element, &name)?;
        self.components.insert(name, element);
        Ok(())
    }

    fn note_connectors(&mut self, element: Node<'d>, name: &str) -> Result<(), Error> {
        for connector in every(element, "Connectors", "Connector") {
            let end = End {
                element: name.to_owned(),
                name: text(connector, "name").to_owned(),
            };
            if one(connector, "Dimension").is_some() {
                let what = format!("connector '{end}' is an array; FMI 2.0 has none");
                return Err(self.fault(connector, what));
            }
            self.connectors.insert(end, connector);
        }
        Ok(())
    }

    /// Reads all connections; the FMUs are described by now.
    pub fn connect(&mut self) -> Result<(), Error> {
        for (name, system) in self.systems.clone() {
            for connection in every(system, "Connections", "Connection") {
                let (giver, taker) = self.directed(&name, connection)?;
                if self.hops.contains_key(&taker) {
                    return Err(self.fault(connection, format!("'{taker}' has two sources")));
                }
                self.hops.insert(taker, (giver, connection));
            }
        }
        Ok(())
    }

    /// Giver and taker; start and end of a connection do not say which is which.
    fn directed(&self, system: &str, connection: Node<'_>) -> Result<(End, End), Error> {
        let (start, first) = self.end(system, connection, ["startElement", "startConnector"])?;
        let (end, second) = self.end(system, connection, ["endElement", "endConnector"])?;
        let turned = first == Some(false) || (first.is_none() && second == Some(true));
        Ok(if turned { (end, start) } else { (start, end) })
    }

    /// An end of a connection, and whether it gives a value to the system that the connection is in.
    fn end(
        &self,
        system: &str,
        connection: Node<'_>,
        [element, name]: [&str; 2],
    ) -> Result<(End, Option<bool>), Error> {
        let element = connection.attribute(element);
        let end = End {
            element: element.map_or(system.to_owned(), |element| inside(system) + element),
            name: text(connection, name).to_owned(),
        };
        if element.is_some() && !self.is_element(&end.element) {
            let known = self.components.keys().chain(self.systems.keys());
            let hint = did_you_mean(&end.element, known.map(String::as_str));
            return Err(self.fault(connection, format!("no '{end}'{hint}")));
        }
        let own = match self.components.contains_key(&end.element) {
            true => Some(self.variable(&end, connection)?.causality),
            false => None,
        };
        let kind = self.connectors.get(&end).and_then(|c| c.attribute("kind"));
        let gives = match (kind, own) {
            (Some(kind), _) if GIVE.contains(&kind) => Some(true),
            (Some(kind), _) if TAKE.contains(&kind) => Some(false),
            (None, Some(Causality::Output)) => Some(true),
            (None, Some(Causality::Input | Causality::Parameter { .. })) => Some(false),
            _ => None,
        };
        Ok((end, gives.map(|gives| gives == element.is_some())))
    }

    fn description(&self, element: &str) -> Option<&Description> {
        Some(self.fmus.get(element)?.description())
    }

    /// The variable of an FMU behind a connector that is named at `place`.
    pub fn variable(&self, end: &End, place: Node<'_>) -> Result<&Variable, Error> {
        let description = self.description(&end.element);
        let found = description.and_then(|description| description.find(&end.name));
        found.ok_or_else(|| {
            let lacks = description.map(|description| description.lacks(&end.name));
            self.fault(place, format!("'{end}' {}", lacks.unwrap_or_default()))
        })
    }

    /// Each fed connector of a component, where its value comes from, and what happens to it on its way.
    pub fn feeds(&self) -> Result<Vec<(End, End, Change)>, Error> {
        let takers = self.hops.keys();
        let takers = takers.filter(|taker| self.components.contains_key(&taker.element));
        takers
            .map(|taker| {
                let way = self.trace(taker)?;
                let source = way.first().map_or(taker, |(giver, ..)| giver);
                Ok((taker.clone(), source.clone(), self.change(&way)?))
            })
            .collect()
    }

    /// The connections that lead to an input, from its source on.
    fn trace<'a>(&'a self, taker: &'a End) -> Result<Vec<(&'a End, &'a End, Node<'d>)>, Error> {
        let (mut way, mut end) = (vec![], taker);
        while let Some((giver, connection)) = self.hops.get(end) {
            if end != taker && self.components.contains_key(&end.element) {
                break;
            }
            way.push((giver, end, *connection));
            if way.len() > LONGEST {
                let what = format!("'{taker}' is fed by a ring of connectors");
                return Err(self.fault(*connection, what));
            }
            end = giver;
        }
        way.reverse();
        Ok(way)
    }

    /// The unit of a connector; that of the FMU counts first.
    pub fn unit(&self, end: &End) -> Option<Unit> {
        if let Some(description) = self.description(&end.element) {
            let variable = description.find(&end.name)?;
            if variable.family != Family::Real {
                return None;
            }
            if variable.unit.is_some() {
                return variable.unit.clone();
            }
        }
        let kinds = self
            .connectors
            .get(end)
            .copied()
            .into_iter()
            .flat_map(elements);
        let mut names = kinds.filter_map(|kind| kind.attribute("unit"));
        let name = names.find(|name| !name.is_empty())?;
        let known = self.units.get(name).cloned();
        known.or_else(|| known_units::find(name))
    }

    /// What happens to a value on its way: per connection, units first.
    fn change(&self, way: &[(&End, &End, Node<'d>)]) -> Result<Change, Error> {
        let mut found = Change::NONE;
        let mut carried = way.first().and_then(|(source, ..)| self.unit(source));
        for (giver, taker, connection) in way {
            let cell = |end| move |row: Node<'_>, word: &str| self.cell(end, row, word);
            let (from, to) = (cell(*giver), cell(*taker));
            let told = told(&self.file, *connection, [&from, &to])?;
            let unit = self.unit(taker);
            let kept = matches!(text(*connection, "suppressUnitConversion"), "true" | "1");
            let refused =
                |what: String| self.fault(*connection, format!("'{giver}' to '{taker}': {what}"));
            if let (Some(one), Some(other), true) =
                (&carried, &unit, told.table.is_empty() && !kept)
            {
                let line = convert(one, other).map_err(refused)?;
                found = found.then(Change::line(line)).map_err(refused)?;
            }
            let changes = told.changes();
            found = found.then(told).map_err(refused)?;
            carried = unit.or(if changes { None } else { carried });
        }
        Ok(found)
    }

    /// The number of a table's cell: an item's, a boolean's, or its own.
    fn cell(&self, end: &End, row: Node<'_>, word: &str) -> Result<f64, Error> {
        let own = self
            .description(&end.element)
            .and_then(|d| d.find(&end.name));
        let item = match own {
            Some(variable) => {
                let item = variable.items.iter().find(|(name, _)| name == word);
                item.map(|(_, number)| f64::from(*number))
            }
            None => {
                let kind = self
                    .connectors
                    .get(end)
                    .copied()
                    .and_then(|c| elements(c).next());
                let codes = kind.and_then(|kind| self.codes.get(text(kind, "name")));
                let mut codes = codes.into_iter().flatten();
                codes
                    .find(|(name, _)| *name == word)
                    .map(|(_, value)| *value)
            }
        };
        let what = || format!("'{end}': '{word}' is no number and no known item");
        item.or_else(|| plain(word))
            .ok_or_else(|| self.fault(row, what()))
    }
}

/// A number, also of a boolean's word.
pub fn plain(word: &str) -> Option<f64> {
    match word {
        "true" => Some(1.0),
        "false" => Some(0.0),
        word => real(word),
    }
}

/// Factor and offset from one unit to another; the error says that they measure different quantities.
pub fn convert(one: &Unit, other: &Unit) -> Result<(f64, f64), String> {
    one.conversion(other).ok_or_else(|| {
        let shown = |unit: &Unit| format!("'{}' ({})", unit.name, unit.dimension());
        format!("{} cannot become {}", shown(one), shown(other))
    })
}

/// What full names inside a system begin with.
pub fn inside(system: &str) -> String {
    if system.is_empty() {
        String::new()
    } else {
        format!("{system}/")
    }
}
