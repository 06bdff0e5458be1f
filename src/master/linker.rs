//! Links between the contract's variables and a supplier's, as a mapping file says.

use crate::contract;
use crate::description::{Causality, Description, Family, Variable};
use crate::error::Error;
use crate::known_units;
use crate::mapping::{Codes, Entries, Mapping, Told};
use crate::plan::{Link, Value};
use crate::suggest::did_you_mean;
use crate::unit::Unit;

/// A link, and the variables at its ends.
#[derive(Debug, Clone)]
pub struct Linked {
    /// How values pass.
    pub link: Link,
    /// Ours, in SI.
    pub ours: Variable,
    /// The supplier's.
    pub theirs: Variable,
}

/// Makes links; knows the supplier's description and where an error is to be mended.
pub struct Linker<'a> {
    /// The file.
    pub mapping: &'a Mapping,
    /// The supplier's.
    pub description: &'a Description,
    /// Ours.
    pub contract: &'a Description,
}

/// What a section of a mapping maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Inputs.
    Input,
    /// Outputs.
    Output,
    /// Parameters.
    Parameter,
}

impl Side {
    fn is(self, causality: Causality) -> bool {
        match self {
            Self::Input => causality == Causality::Input,
            Self::Output => causality == Causality::Output,
            Self::Parameter => matches!(causality, Causality::Parameter { .. }),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Output => "output",
            Self::Parameter => "parameter",
        }
    }
}

impl Linker<'_> {
    /// The links of a section.
    pub fn links(&self, entries: &Entries, side: Side) -> Result<Vec<Linked>, Error> {
        let mapped = entries
            .iter()
            .filter_map(|(name, entry)| Some(self.link(name, entry.told()?, side)));
        mapped.collect()
    }

    /// Refuses a name that the contract does not have, or has as something else.
    pub fn check_names(&self, entries: &Entries, side: Side) -> Result<(), Error> {
        let known = |name: &String| {
            self.contract
                .find(name)
                .is_some_and(|v| side.is(v.causality))
        };
        let Some(missing) = entries.keys().find(|name| !known(name)) else {
            return Ok(());
        };
        let own = match side {
            Side::Output => "; give it under [extra] if it is one of your own",
            _ => "",
        };
        let section = side.name();
        let same = self.contract.variables.iter();
        let same = same.filter(|variable| side.is(variable.causality));
        let hint = did_you_mean(missing, same.map(|variable| variable.name.as_str()));
        let what = format!("{section}s: DctPlant has no {section} '{missing}'{hint}{own}");
        Err(self.mapping.error(what))
    }

    fn link(&self, name: &str, told: &Told, side: Side) -> Result<Linked, Error> {
        let error = |what: String| self.error(name, told, &what);
        let theirs = self.description.find(&told.variable);
        let theirs = theirs.ok_or_else(|| {
            let same = self.description.variables.iter();
            let same = same.filter(|variable| side.is(variable.causality));
            let hint = did_you_mean(&told.variable, same.map(|v| v.name.as_str()));
            error(format!("the FMU has no such variable{hint}"))
        })?;
        if !side.is(theirs.causality) {
            return Err(error(format!("is no {} of the FMU", side.name())));
        }
        let ours = match self.contract.find(name) {
            Some(ours) => ours.clone(),
            None => self.own(name, told, theirs)?,
        };
        let mut link = Link {
            ours: name.to_owned(),
            theirs: told.variable.clone(),
            gain: 1.0,
            shift: 0.0,
            table: self.table(name, told, &ours, theirs)?,
            moves: match side {
                Side::Input => ours.follows(),
                Side::Output => ours.continuous,
                Side::Parameter => false,
            },
        };
        if link.table.is_empty() {
            self.check_types(name, told, (&ours, theirs), side)?;
            if ours.family == Family::Real {
                (link.gain, link.shift) = self.line(name, told, theirs)?;
            }
        }
        Ok(Linked {
            link,
            ours,
            theirs: theirs.clone(),
        })
    }

    fn error(&self, name: &str, told: &Told, what: &str) -> Error {
        let theirs = &told.variable;
        self.mapping.error(format!("'{name}' = '{theirs}': {what}"))
    }

    /// A variable under a name of the user's own, in SI.
    fn own(&self, name: &str, told: &Told, theirs: &Variable) -> Result<Variable, Error> {
        let unit = self.unit(name, told, theirs)?;
        Ok(Variable {
            name: name.to_owned(),
            unit: Some(Unit::named("SI", unit.exponents)),
            ..theirs.clone()
        })
    }

    fn check_types(
        &self,
        name: &str,
        told: &Told,
        (ours, theirs): (&Variable, &Variable),
        side: Side,
    ) -> Result<(), Error> {
        let (source, target) = match side {
            Side::Output => (theirs, ours),
            _ => (ours, theirs),
        };
        let width = |variable: &Variable| match variable.family {
            Family::Boolean => 0,
            Family::Integer => 1,
            Family::Real => 2,
        };
        let coded = ours.items != theirs.items && self.contract.find(name).is_some();
        if width(source) > width(target) || coded {
            let (theirs, ours) = (theirs.family, ours.family);
            let what = format!(
                "is {theirs:?}, ours is {ours:?}; say with a table which value stands for which"
            );
            return Err(self.error(name, told, &what));
        }
        Ok(())
    }

    fn unit(&self, name: &str, told: &Told, theirs: &Variable) -> Result<Unit, Error> {
        if !told.unit.is_empty() {
            return known_units::find(&told.unit).ok_or_else(|| {
                let known: Vec<_> = known_units::names().filter(|n| !n.is_empty()).collect();
                let hint = did_you_mean(&told.unit, known.iter().copied());
                let what = format!("unknown unit '{}' ({}){hint}", told.unit, known.join(", "));
                self.error(name, told, &what)
            });
        }
        match &theirs.unit {
            Some(unit) => Ok(unit.clone()),
            None if theirs.unit_name.is_empty() => Ok(Unit::named("", [0; 8])),
            None => {
                let stated = &theirs.unit_name;
                let what = format!("the FMU defines no BaseUnit for '{stated}'; say unit = …");
                Err(self.error(name, told, &what))
            }
        }
    }

    /// Gain and shift: units first, then the entry's factor and offset.
    fn line(&self, name: &str, told: &Told, theirs: &Variable) -> Result<(f64, f64), Error> {
        let unit = self.unit(name, told, theirs)?;
        let target = match self.contract.find(name) {
            Some(_) => contract::unit(self.contract, name),
            None => Unit::named("SI", unit.exponents),
        };
        if unit.name.is_empty() && target.exponents != [0; 8] {
            let ours = target.name;
            let what = format!("the FMU states no unit; say unit = … (ours is {ours})");
            return Err(self.error(name, told, &what));
        }
        let (a, b) = unit.conversion(&target).ok_or_else(|| {
            let what = format!(
                "'{}' ({}) cannot become '{}' ({}); if the FMU's unit is wrong say unit = …",
                unit.name,
                unit.dimension(),
                target.name,
                target.dimension()
            );
            self.error(name, told, &what)
        })?;
        let factor = told.factor.unwrap_or(1.0);
        if !factor.is_normal() || !told.offset.is_finite() {
            let what = format!(
                "factor = {factor} and offset = {} must be finite, and factor not 0",
                told.offset
            );
            return Err(self.error(name, told, &what));
        }
        Ok((factor * a, factor * b + told.offset))
    }

    /// Pairs of numbers; several values of theirs may stand for one of ours.
    fn table(
        &self,
        name: &str,
        told: &Told,
        ours: &Variable,
        theirs: &Variable,
    ) -> Result<Vec<(f64, f64)>, Error> {
        let code = |variable: &Variable, value: &Value| {
            code(variable, value).map_err(|what| self.error(name, told, &what))
        };
        let mut pairs: Vec<(f64, f64)> = vec![];
        for (key, codes) in &told.table {
            let ours = code(ours, &Value::Text(key.clone()))?;
            let codes = match codes {
                Codes::One(value) => std::slice::from_ref(value),
                Codes::Several(values) => values.as_slice(),
            };
            for value in codes {
                let theirs = code(theirs, value)?;
                if pairs.iter().any(|(_, known)| *known == theirs) {
                    let what = "the table gives one value of theirs two meanings";
                    return Err(self.error(name, told, what));
                }
                pairs.push((ours, theirs));
            }
        }
        Ok(pairs)
    }
}

/// The number of an item, or a number or boolean as it is written.
fn code(variable: &Variable, value: &Value) -> Result<f64, String> {
    let text = match value {
        Value::Number(number) => return Ok(*number),
        Value::Boolean(value) => return Ok(f64::from(u8::from(*value))),
        Value::Text(text) => text,
    };
    let item = variable.items.iter().find(|(item, _)| item == text);
    if let Some((_, number)) = item {
        return Ok(f64::from(*number));
    }
    match text.to_lowercase().as_str() {
        "true" => Ok(1.0),
        "false" => Ok(0.0),
        other => other.parse().map_err(|_| {
            let items: Vec<_> = variable
                .items
                .iter()
                .map(|(item, _)| item.as_str())
                .collect();
            let known = match items.as_slice() {
                [] => "it is no enumeration".to_owned(),
                items => items.join(", "),
            };
            format!("table: '{}' has no item '{text}' ({known})", variable.name)
        }),
    }
}
