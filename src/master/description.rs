//! What an FMU says of its variables, read from its `modelDescription.xml`.
//!
//! The description of the `fmi` crate leaves out what an Enumeration's items and a unit's factor
//! are; hence this reader of just what a master needs.

use crate::known_units;
use crate::suggest::did_you_mean;
use crate::unit::Unit;
use roxmltree::{Document, Node};
use std::collections::HashMap;

/// FMI's get/set family of a variable; an enumeration travels as an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer` and enumerations.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
}

/// What a variable is for, as far as a master cares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before every step.
    Input,
    /// Read after every step.
    Output,
    /// Set before the run; `tunable` ones may be changed by a scenario.
    Parameter {
        /// Whether it may change during a run.
        tunable: bool,
    },
    /// Anything else.
    Other,
}

/// One scalar variable; those of type String are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name in the FMU.
    pub name: String,
    /// Its value reference.
    pub reference: u32,
    /// Its get/set family.
    pub family: Family,
    /// What it is for.
    pub causality: Causality,
    /// Items of its enumeration: name and number.
    pub items: Vec<(String, i32)>,
    /// Its unit, when the FMU defines it or it is known by its name.
    pub unit: Option<Unit>,
    /// Name of its unit as the FMU states it; empty without one.
    pub unit_name: String,
    /// Its start value as the FMU states it.
    pub start: Option<String>,
    /// Whether it is a Real that changes continuously.
    pub continuous: bool,
}

impl Variable {
    /// Whether it is an input that may have a derivative; a tunable parameter may not.
    pub fn follows(&self) -> bool {
        self.continuous && self.causality == Causality::Input
    }

    /// Whether it changes in jumps only, so that a scenario's rows are held; a tunable parameter may change in a ramp.
    pub fn is_discrete(&self) -> bool {
        self.family != Family::Real || self.causality == Causality::Input && !self.continuous
    }

    /// Whether something may feed it.
    pub fn can_be_set(&self) -> bool {
        matches!(
            self.causality,
            Causality::Input | Causality::Parameter { tunable: true }
        )
    }
}

/// What the FMU says that it can do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Abilities {
    /// canHandleVariableCommunicationStepSize.
    pub varies_step: bool,
    /// canInterpolateInputs.
    pub interpolates: bool,
    /// maxOutputDerivativeOrder is above 0.
    pub tells_slopes: bool,
}

impl Abilities {
    fn read(root: Node<'_, '_>) -> Self {
        let node = root.children().find(|n| n.has_tag_name("CoSimulation"));
        let stated = |name| node.and_then(|node| node.attribute(name));
        let can = |name| matches!(stated(name), Some("true" | "1"));
        let order = stated("maxOutputDerivativeOrder").and_then(|order| order.parse::<u32>().ok());
        Self {
            varies_step: can("canHandleVariableCommunicationStepSize"),
            interpolates: can("canInterpolateInputs"),
            tells_slopes: order.is_some_and(|order| order > 0),
        }
    }
}

/// The variables and units of an FMU.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Description {
    /// In the order of the file.
    pub variables: Vec<Variable>,
    /// Units with a BaseUnit, by name.
    pub units: HashMap<String, Unit>,
    /// What it can do.
    pub abilities: Abilities,
}

impl Description {
    /// Reads `modelDescription.xml`; the error is a sentence.
    pub fn parse(xml: &str) -> Result<Self, String> {
        let document = Document::parse(xml).map_err(|error| error.to_string())?;
        let root = document.root_element();
        let units = children(root, "UnitDefinitions", "Unit").filter_map(Unit::read);
        let known = Known {
            types: children(root, "TypeDefinitions", "SimpleType")
                .filter_map(|node| Some((node.attribute("name")?, node)))
                .collect(),
            units: units.collect(),
        };
        let variables = children(root, "ModelVariables", "ScalarVariable")
            .filter_map(|node| known.variable(node).transpose());
        Ok(Self {
            variables: variables.collect::<Result<_, _>>()?,
            units: known.units,
            abilities: Abilities::read(root),
        })
    }

    /// A variable by name.
    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// "does not exist", and the name that was probably meant.
    pub fn lacks(&self, name: &str) -> String {
        let known = self.variables.iter().map(|variable| variable.name.as_str());
        format!("does not exist{}", did_you_mean(name, known))
    }

    /// Variables that pass `choose`: reals first, then integers, then booleans.
    pub fn chosen(&self, choose: impl Fn(&Variable) -> bool) -> Vec<&Variable> {
        let mut found: Vec<&Variable> = self.variables.iter().filter(|v| choose(v)).collect();
        found.sort_by_key(|variable| variable.family);
        found
    }
}

fn children<'a>(
    root: Node<'a, 'a>,
    list: &'static str,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'a>> {
    let lists = root.children().filter(move |node| node.has_tag_name(list));
    lists
        .flat_map(|node| node.children())
        .filter(move |node| node.has_tag_name(tag))
}

/// What variables refer to by name.
struct Known<'a> {
    types: HashMap<&'a str, Node<'a, 'a>>,
    units: HashMap<String, Unit>,
}

impl Known<'_> {
    fn variable(&self, node: Node<'_, '_>) -> Result<Option<Variable>, String> {
        let name = node.attribute("name").unwrap_or_default().to_owned();
        let element = node.children().find(Node::is_element);
        let family = match element.map(|element| element.tag_name().name()) {
            Some("Real") => Family::Real,
            Some("Integer" | "Enumeration") => Family::Integer,
            Some("Boolean") => Family::Boolean,
            _ => return Ok(None),
        };
        let reference = node
            .attribute("valueReference")
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| format!("variable '{name}' has no valueReference"))?;
        let declared = element.and_then(|element| element.attribute("declaredType"));
        let declared = declared.and_then(|name| self.types.get(name)).copied();
        Ok(Some(Variable {
            name,
            reference,
            family,
            causality: causality(node),
            items: declared.map(items).unwrap_or_default(),
            unit: element.and_then(|element| self.unit(element, declared)),
            unit_name: element
                .map(|element| unit_name(element, declared))
                .unwrap_or_default(),
            start: element
                .and_then(|element| element.attribute("start"))
                .map(str::to_owned),
            continuous: family == Family::Real && goes_on(node),
        }))
    }

    /// The unit that a variable or its type states; one for differences has no offset.
    fn unit(&self, element: Node<'_, '_>, declared: Option<Node<'_, '_>>) -> Option<Unit> {
        let name = unit_name(element, declared);
        if name.is_empty() {
            return None;
        }
        let unit = self.units.get(&name).cloned();
        let unit = unit.or_else(|| known_units::find(&name))?;
        let relative = stated(element, declared, "relativeQuantity");
        let relative = matches!(relative, Some("true" | "1"));
        Some(if relative { unit.difference() } else { unit })
    }
}

/// What a variable says, or else its type.
fn stated<'a>(
    element: Node<'a, '_>,
    declared: Option<Node<'a, '_>>,
    name: &str,
) -> Option<&'a str> {
    let kind = declared.and_then(|kind| kind.children().find(Node::is_element));
    let own = element.attribute(name);
    own.or_else(|| kind?.attribute(name))
}

fn unit_name(element: Node<'_, '_>, declared: Option<Node<'_, '_>>) -> String {
    stated(element, declared, "unit")
        .unwrap_or_default()
        .to_owned()
}

fn goes_on(node: Node<'_, '_>) -> bool {
    matches!(node.attribute("variability"), None | Some("continuous"))
}

fn items(kind: Node<'_, '_>) -> Vec<(String, i32)> {
    let items = kind.descendants().filter(|node| node.has_tag_name("Item"));
    let items = items.filter_map(|item| {
        let number = item.attribute("value")?.parse().ok()?;
        Some((item.attribute("name")?.to_owned(), number))
    });
    items.collect()
}

fn causality(node: Node<'_, '_>) -> Causality {
    match node.attribute("causality") {
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        Some("parameter") => Causality::Parameter {
            tunable: node.attribute("variability") == Some("tunable"),
        },
        _ => Causality::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XML: &str = r#"<fmiModelDescription>
        <UnitDefinitions><Unit name="rpm"><BaseUnit rad="1" s="-1" factor="0.5"/></Unit></UnitDefinitions>
        <TypeDefinitions><SimpleType name="Mode"><Enumeration>
            <Item name="open" value="1"/><Item name="shut" value="2"/></Enumeration></SimpleType></TypeDefinitions>
        <ModelVariables>
            <ScalarVariable name="mode" valueReference="7" causality="output"><Enumeration declaredType="Mode"/></ScalarVariable>
            <ScalarVariable name="label" valueReference="1"><String/></ScalarVariable>
            <ScalarVariable name="u" valueReference="3" causality="input"><Real unit="rpm"/></ScalarVariable>
            <ScalarVariable name="k" valueReference="4" causality="parameter" variability="tunable"><Real/></ScalarVariable>
        </ModelVariables></fmiModelDescription>"#;

    #[test]
    fn variables_come_with_type_causality_and_items() {
        let description = Description::parse(XML).unwrap();
        let names: Vec<_> = description
            .variables
            .iter()
            .map(|v| v.name.as_str())
            .collect();
        assert_eq!(
            names,
            ["mode", "u", "k"],
            "a String has no place in a loop of numbers"
        );
        let mode = description.find("mode").unwrap();
        assert_eq!((mode.family, mode.reference), (Family::Integer, 7));
        assert_eq!(mode.items, [("open".to_owned(), 1), ("shut".to_owned(), 2)]);
        let tunable = Causality::Parameter { tunable: true };
        assert_eq!(description.find("k").unwrap().causality, tunable);
        assert_eq!(description.units["rpm"].factor, 0.5);
        assert_eq!(
            description.find("u").unwrap().unit,
            Some(description.units["rpm"].clone())
        );
    }

    #[test]
    fn reals_come_before_integers() {
        let description = Description::parse(XML).unwrap();
        let all = description.chosen(|_| true);
        let names: Vec<_> = all.iter().map(|v| v.name.as_str()).collect();
        assert_eq!(names, ["u", "k", "mode"]);
    }

    #[test]
    fn a_variable_without_reference_is_named() {
        let xml = r#"<a><ModelVariables><ScalarVariable name="x"><Real/></ScalarVariable></ModelVariables></a>"#;
        assert_eq!(
            Description::parse(xml).unwrap_err(),
            "variable 'x' has no valueReference"
        );
        assert!(Description::parse("<a>").is_err());
    }
}
