//! Parameter sets of an .ssp: which component gets which value.

use super::change::{Change, told};
use super::package::Package;
use super::structure::{End, Structure, convert, inside, plain};
use super::xml::{Node, at, elements, every, one, parsed, real, tag, text, unit};
use crate::description::{Family, Variable};
use crate::error::Error;
use crate::known_units;
use crate::plan::Value;
use crate::suggest::did_you_mean;
use crate::unit::Unit;
use indexmap::IndexMap;
use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// A value as a parameter set has it: text and unit.
type Given = (String, Option<Unit>);

/// A value that is bound to a connector of a system, and what its mapping does to it.
struct Bound<'d> {
    given: Given,
    change: Change,
    binding: Node<'d>,
}

/// Values of all components.
pub struct Values<'s, 'd> {
    package: &'s Package,
    structure: &'s Structure<'d>,
    /// By full name of the component, then by variable.
    pub of: HashMap<String, BTreeMap<String, Value>>,
    bound: HashMap<End, Bound<'d>>,
}

impl<'s, 'd> Values<'s, 'd> {
    /// Puts all parameter sets into the components; those of outer systems count more.
    pub fn new(package: &'s Package, structure: &'s Structure<'d>) -> Result<Self, Error> {
        let mut values = Self {
            package,
            structure,
            of: HashMap::new(),
            bound: HashMap::new(),
        };
        for (name, element) in &structure.components {
            values.bind(*element, name)?;
        }
        let mut systems: Vec<_> = structure.systems.iter().collect();
        systems.sort_by_key(|(name, _)| (name.is_empty(), Reverse(name.matches('/').count())));
        for (name, element) in systems {
            values.bind(*element, name)?;
        }
        Ok(values)
    }

    fn fault(&self, node: Node<'_>, what: String) -> Error {
        at(&self.structure.file, node, what)
    }

    /// Puts the parameter sets of a component or system into what they name.
    fn bind(&mut self, element: Node<'d>, base: &str) -> Result<(), Error> {
        for binding in every(element, "ParameterBindings", "ParameterBinding") {
            let values = self.parameters(binding)?;
            for (source, target, change) in self.mapping(binding, &values)? {
                let end = self.named(
                    base,
                    &format!("{}{target}", text(binding, "prefix")),
                    binding,
                )?;
                let Some(given) = values.get(&source).cloned() else {
                    continue;
                };
                if self.structure.components.contains_key(&end.element) {
                    let value = self.value(&end, &given, &change, binding)?;
                    self.put(end, value);
                } else {
                    let bound = Bound {
                        given,
                        change,
                        binding,
                    };
                    self.bound.insert(end, bound);
                }
            }
        }
        Ok(())
    }

    fn put(&mut self, end: End, value: Value) {
        self.of
            .entry(end.element)
            .or_default()
            .insert(end.name, value);
    }

    /// The connector that a hierarchical name means, seen from an element.
    fn named(&self, base: &str, name: &str, place: Node<'_>) -> Result<End, Error> {
        let end = |element: &str, name: &str| End {
            element: element.to_owned(),
            name: name.to_owned(),
        };
        let Some(system) = self.structure.systems.get(base) else {
            return Ok(end(base, name));
        };
        let first = inside(base);
        let all = self
            .structure
            .components
            .keys()
            .chain(self.structure.systems.keys());
        let within = all.filter_map(|full| {
            let relative = full.strip_prefix(&first).filter(|name| !name.is_empty())?;
            let rest = name.strip_prefix(&relative.replace('/', "."))?;
            Some((full, rest.strip_prefix('.')?))
        });
        if let Some((full, rest)) = within.max_by_key(|(full, _)| full.len()) {
            return Ok(end(full, rest));
        }
        let connectors = every(*system, "Connectors", "Connector").into_iter();
        let known: Vec<&str> = connectors
            .map(|connector| text(connector, "name"))
            .collect();
        if known.contains(&name) {
            return Ok(end(base, name));
        }
        let components = self.structure.components.keys().map(String::as_str);
        let hint = did_you_mean(name, known.into_iter().chain(components));
        Err(self.fault(
            place,
            format!("parameter '{name}': no such component{hint}"),
        ))
    }

    /// Text and unit of each value of a parameter set, inline or in a file.
    fn parameters(&self, binding: Node<'_>) -> Result<IndexMap<String, Given>, Error> {
        if let Some(set) = one(binding, "ParameterValues").and_then(|v| elements(v).next()) {
            return given(&self.structure.file, set);
        }
        let name = text(binding, "source");
        let text = self.package.text(name)?;
        let file = self.package.named(name);
        given(&file, parsed(&file, &text)?.root_element())
    }

    /// Source, target and change of each parameter that is bound.
    fn mapping(
        &self,
        binding: Node<'_>,
        values: &IndexMap<String, Given>,
    ) -> Result<Vec<(String, String, Change)>, Error> {
        let Some(mapping) = one(binding, "ParameterMapping") else {
            let all = values.keys();
            return Ok(all
                .map(|name| (name.clone(), name.clone(), Change::NONE))
                .collect());
        };
        let name = text(mapping, "source");
        if name.is_empty() {
            return entries(&self.structure.file, mapping, values);
        }
        let (file, text) = (self.package.named(name), self.package.text(name)?);
        entries(&file, parsed(&file, &text)?.root_element(), values)
    }

    /// A bound value as the FMU takes it.
    fn value(
        &self,
        end: &End,
        (text, given): &Given,
        change: &Change,
        place: Node<'_>,
    ) -> Result<Value, Error> {
        let variable = self.structure.variable(end, place)?;
        let wrong = |what: String| self.fault(place, format!("parameter '{end}': {what}"));
        if !variable.items.is_empty() {
            return Ok(Value::Text(text.clone()));
        }
        if variable.family == Family::Boolean {
            let set = matches!(text.as_str(), "true" | "1");
            let coded = change.at(f64::from(u8::from(set)));
            let coded = (!change.table.is_empty()).then_some(coded).transpose();
            return Ok(Value::Boolean(
                coded.map_err(wrong)?.map_or(set, |code| code != 0.0),
            ));
        }
        let mut value = self.real(end, text, place)?;
        let theirs = self.structure.unit(end);
        if let (Some(one), Some(other)) = (given, &theirs) {
            let (factor, offset) = convert(one, other).map_err(wrong)?;
            value = factor * value + offset;
        }
        Ok(typed(variable, change.at(value).map_err(wrong)?))
    }

    fn real(&self, end: &End, text: &str, place: Node<'_>) -> Result<f64, Error> {
        let what = || format!("'{end}': '{text}' is no number and no known item");
        real(text).ok_or_else(|| self.fault(place, what()))
    }

    /// Gives a component the value that is bound to a connector of a system around it; false where none is.
    pub fn pass_on(&mut self, source: &End, taker: &End, change: &Change) -> Result<bool, Error> {
        let Some(Bound {
            given: (text, given),
            change: mapped,
            binding,
        }) = self.bound.get(source)
        else {
            return Ok(false);
        };
        let variable = self.structure.variable(taker, *binding)?;
        let value = if variable.family == Family::Boolean || !variable.items.is_empty() {
            self.value(taker, &(text.clone(), None), &Change::NONE, *binding)?
        } else {
            let wrong = |what: String| self.fault(*binding, format!("'{source}': {what}"));
            let mut number = self.real(source, text, *binding)?;
            if let (Some(one), Some(other)) = (given, &self.structure.unit(source)) {
                number = Change::line(convert(one, other).map_err(wrong)?)
                    .at(number)
                    .map_err(wrong)?;
            }
            let number = mapped.at(number).and_then(|number| change.at(number));
            typed(variable, number.map_err(wrong)?)
        };
        self.put(taker.clone(), value);
        Ok(true)
    }
}

/// A number as a variable takes it.
fn typed(variable: &Variable, number: f64) -> Value {
    match variable.family {
        Family::Real | Family::Boolean => Value::Number(number),
        Family::Integer => Value::Number(number.trunc()),
    }
}

/// Text and unit of each value of a parameter set.
fn given(file: &Path, set: Node<'_>) -> Result<IndexMap<String, Given>, Error> {
    let mut units = HashMap::new();
    for node in every(set, "Units", "Unit") {
        units.insert(text(node, "name"), unit(file, node)?);
    }
    let mut found = IndexMap::new();
    for parameter in every(set, "Parameters", "Parameter") {
        for value in elements(parameter).filter(|value| tag(*value) != "Annotations") {
            let name = text(value, "unit");
            let known = units.get(name).cloned();
            let unit = known.or_else(|| known_units::find(name).filter(|_| !name.is_empty()));
            let word = value
                .attribute("value")
                .unwrap_or_else(|| text(value, "name"));
            found.insert(text(parameter, "name").to_owned(), (word.to_owned(), unit));
        }
    }
    Ok(found)
}

/// The entries of a parameter mapping.
fn entries(
    file: &Path,
    mapping: Node<'_>,
    values: &IndexMap<String, Given>,
) -> Result<Vec<(String, String, Change)>, Error> {
    let all = mapping
        .descendants()
        .filter(|node| tag(*node) == "MappingEntry");
    all.map(|entry| {
        let [source, target] = ["source", "target"].map(|name| text(entry, name).to_owned());
        if !values.contains_key(&source) {
            let hint = did_you_mean(&source, values.keys().map(String::as_str));
            let what = format!("mapping: no parameter '{source}'{hint}");
            return Err(at(file, entry, what));
        }
        let file: PathBuf = file.to_owned();
        let cell = |row: Node<'_>, word: &str| {
            let what = || format!("'{source}': '{word}' is no number");
            plain(word).ok_or_else(|| at(&file, row, what()))
        };
        let change = told(&file, entry, [&cell, &cell])?;
        Ok((source, target, change))
    })
    .collect()
}
