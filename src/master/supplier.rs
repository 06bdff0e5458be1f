//! A supplier's plant in a system: its mapping applied to values, names and connections.

use crate::contract;
use crate::description::{Causality, Description, Family, Variable};
use crate::error::Error;
use crate::linker::{Linked, Linker, Side};
use crate::mapping::Mapping;
use crate::plan::{Mapped, Sum, Value};
use crate::suggest::did_you_mean;

/// Parameters and start values of a component, in the order in which they are set.
pub type Values = Vec<(String, Value)>;

/// A plant that is mapped.
pub struct Supplier<'a> {
    mapping: &'a Mapping,
    inputs: Vec<Linked>,
    outputs: Vec<Linked>,
    parameters: Vec<Linked>,
    sums: Vec<Sum>,
    theirs: &'a Description,
    /// What the other components see of it.
    pub ours: Description,
}

impl<'a> Supplier<'a> {
    /// Checks a mapping against the description of the FMU that it is for.
    pub fn new(mapping: &'a Mapping, theirs: &'a Description) -> Result<Self, Error> {
        let contract = contract::plant()?;
        let linker = Linker {
            mapping,
            description: theirs,
            contract: &contract,
        };
        linker.check_names(&mapping.inputs, Side::Input)?;
        linker.check_names(&mapping.outputs, Side::Output)?;
        linker.check_names(&mapping.parameters, Side::Parameter)?;
        let mut outputs = linker.links(&mapping.outputs, Side::Output)?;
        outputs.extend(linker.links(&mapping.extra, Side::Output)?);
        let sums = mapping.sums()?.into_iter().map(|(name, terms)| Sum {
            ours: name.clone(),
            terms,
            moves: contract.find(name).is_some_and(|v| v.continuous),
        });
        let mut supplier = Self {
            inputs: linker.links(&mapping.inputs, Side::Input)?,
            outputs,
            parameters: linker.links(&mapping.parameters, Side::Parameter)?,
            sums: sums.collect(),
            mapping,
            theirs,
            ours: Description::default(),
        };
        supplier.refuse_two_sources()?;
        supplier.ours.variables = supplier.variables(&contract);
        Ok(supplier)
    }

    fn refuse_two_sources(&self) -> Result<(), Error> {
        let names: Vec<&str> = self.inputs.iter().map(|k| k.link.theirs.as_str()).collect();
        let twice = names
            .iter()
            .find(|name| names.iter().filter(|n| n == name).count() > 1);
        twice.map_or(Ok(()), |name| {
            let what = format!("inputs: '{name}' of the FMU is given twice; keep one");
            Err(self.mapping.error(what))
        })
    }

    /// Inputs, outputs and tunable parameters under our names, in SI.
    fn variables(&self, contract: &Description) -> Vec<Variable> {
        let si = |linked: &Linked| {
            let name = &linked.link.ours;
            let known = contract.find(name).map(|_| contract::unit(contract, name));
            Variable {
                unit: known.or_else(|| linked.ours.unit.clone()),
                ..linked.ours.clone()
            }
        };
        let ports = self.inputs.iter().chain(&self.outputs).map(si);
        let sums = self
            .sums
            .iter()
            .filter_map(|sum| contract.find(&sum.ours).cloned());
        let parameters = self.parameters.iter().map(|linked| Variable {
            causality: linked.theirs.causality,
            ..si(linked)
        });
        ports.chain(sums).chain(parameters).collect()
    }

    /// What a run needs of it.
    pub fn plan(&self) -> Mapped {
        let links = |side: &[Linked]| side.iter().map(|k| k.link.clone()).collect::<Vec<_>>();
        let mut inputs = links(&self.inputs);
        inputs.extend(links(&self.parameters));
        Mapped {
            file: self.mapping.path().to_owned(),
            inputs,
            outputs: links(&self.outputs),
            sums: self.sums.clone(),
        }
    }

    /// Values as the FMU has them: names of ours are SI, its own names have its units.
    pub fn translated(&self, values: &[(String, Value)]) -> Result<Values, Error> {
        let mut found: Values = vec![];
        for (name, value) in values {
            let (name, value) = self.their_value(name, value)?;
            put(&mut found, name, value);
        }
        Ok(found)
    }

    fn their_value(&self, name: &str, value: &Value) -> Result<(String, Value), Error> {
        let links = || self.parameters.iter().chain(&self.inputs);
        if let Some(linked) = links().find(|linked| linked.link.ours == name) {
            let value = typed(linked, value).map_err(|what| {
                let what = format!("'{name}' = '{}': {what}", linked.link.theirs);
                self.mapping.error(what)
            })?;
            return Ok((linked.link.theirs.clone(), value));
        }
        if self.theirs.find(name).is_none() {
            let known = self.parameters.iter().map(|k| k.link.ours.as_str());
            let hint = did_you_mean(name, known);
            return Err(self.mapping.error(format!(
                "parameters: nothing stands for '{name}' of the system; map it, or list it in 'ignore'{hint}"
            )));
        }
        Ok((name.to_owned(), value.clone()))
    }

    /// What others take of it: the mapped parameters by our names in SI, then what is known.
    pub fn shared(&self, values: &[(String, Value)]) -> Values {
        let given = |name: &str| values.iter().find(|(known, _)| known == name);
        let mut found: Values = vec![];
        for Linked { link, theirs, .. } in &self.parameters {
            if let Some((name, value)) = given(&link.ours) {
                put(&mut found, name.clone(), value.clone());
                continue;
            }
            let set = given(&link.theirs).and_then(|(_, value)| number(value));
            let start = theirs.start.as_ref().and_then(|start| start.parse().ok());
            let known = set.or(start).and_then(|theirs| to_ours(link, theirs));
            if let Some(value) = known {
                put(&mut found, link.ours.clone(), Value::Number(value));
            }
        }
        for (name, value) in &self.mapping.known {
            put(&mut found, name.clone(), value.clone());
        }
        found
    }

    /// Gives a component in `share` what it has as parameter and nobody set.
    pub fn share(&self, shared: &Values, description: &Description, values: &mut Values) {
        let parameter = |name: &str| {
            let variable = description.find(name);
            variable.is_some_and(|v| matches!(v.causality, Causality::Parameter { .. }))
        };
        for (name, value) in shared {
            if parameter(name) && !values.iter().any(|(known, _)| known == name) {
                values.push((name.clone(), value.clone()));
            }
        }
    }
}

/// A value that is given again keeps its first place.
pub fn put(values: &mut Values, name: String, value: Value) {
    match values.iter_mut().find(|(known, _)| *known == name) {
        Some((_, old)) => *old = value,
        None => values.push((name, value)),
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        Value::Boolean(value) => Some(f64::from(u8::from(*value))),
        Value::Text(_) => None,
    }
}

fn to_ours(link: &crate::plan::Link, value: f64) -> Option<f64> {
    if link.table.is_empty() {
        return Some(link.gain * value + link.shift);
    }
    let row = link.table.iter().find(|(_, theirs)| *theirs == value);
    row.map(|(ours, _)| *ours)
}

/// The supplier's start value for one of ours, as the type it has there.
fn typed(linked: &Linked, value: &Value) -> Result<Value, String> {
    let Some(ours) = number(value) else {
        return Ok(value.clone());
    };
    let link = &linked.link;
    let theirs = if link.table.is_empty() {
        (ours - link.shift) / link.gain
    } else {
        let row = link.table.iter().find(|(known, _)| *known == ours);
        let row = row.ok_or_else(|| format!("{ours:?} is in no row of its table"))?;
        row.1
    };
    let family = linked.theirs.family;
    match family {
        Family::Real => Ok(Value::Number(theirs)),
        Family::Integer if theirs.fract() == 0.0 => Ok(Value::Number(theirs)),
        Family::Boolean if theirs == 0.0 || theirs == 1.0 => Ok(Value::Boolean(theirs == 1.0)),
        _ => Err(format!(
            "{ours:?} would be {theirs:?} there, which is {family:?}; {}",
            match family {
                Family::Boolean => "give true or false",
                _ => "give a value that is a whole number there",
            }
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Link;

    fn told(family: Family, table: Vec<(f64, f64)>, value: &Value) -> String {
        let theirs = Variable {
            name: "n".into(),
            reference: 0,
            family,
            causality: Causality::Input,
            items: vec![],
            unit: None,
            unit_name: String::new(),
            start: None,
            continuous: false,
        };
        let link = Link {
            ours: "gear".into(),
            theirs: "n".into(),
            gain: 1.0,
            shift: 0.0,
            table,
            moves: false,
        };
        let linked = Linked {
            link,
            ours: theirs.clone(),
            theirs,
        };
        typed(&linked, value).map_or_else(|what| what, |value| format!("{value:?}"))
    }

    #[test]
    fn a_start_value_that_its_type_cannot_hold_is_refused_not_cut() {
        use Family::{Boolean, Integer, Real};
        let coded = || vec![(1.0, 5.0), (2.0, 1.5)];
        for (family, table, value, expected) in [
            (Real, vec![], 1.5, "Number(1.5)"),
            (Integer, vec![], 2.0, "Number(2.0)"),
            (
                Integer,
                vec![],
                1.5,
                "1.5 would be 1.5 there, which is Integer; give a value that is a whole number there",
            ),
            (Integer, vec![], f64::NAN, "would be NaN there"),
            (Integer, coded(), 1.0, "Number(5.0)"),
            (Integer, coded(), 2.0, "2.0 would be 1.5 there"),
            (Integer, coded(), 3.0, "3.0 is in no row of its table"),
            (Boolean, vec![], 1.0, "Boolean(true)"),
            (
                Boolean,
                vec![],
                2.0,
                "2.0 would be 2.0 there, which is Boolean; give true or false",
            ),
        ] {
            let told = told(family, table, &Value::Number(value));
            assert!(told.contains(expected), "{family:?} {value}: {told}");
        }
    }
}
