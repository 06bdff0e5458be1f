//! Which source each input reads: a `connections` entry of the file, an equal name, the scenario.
//!
//! An estimate carries the name of the truth. Where both are there, `control` reads `observer`'s.
//! A tunable parameter counts as an input where the scenario has a column of its name.

use crate::description::{Causality, Description, Family, Variable};
use crate::error::Error;
use crate::fmu;
use crate::plan::{Component, Connection, Input};
use crate::scenario::Scenario;
use crate::suggest::did_you_mean;
use std::collections::HashSet;

/// The connections of a system file.
#[derive(Clone, Copy)]
pub struct Told<'a> {
    /// As they are written.
    pub connections: &'a [Connection],
    /// There are no others: inputs without one keep their start values, and units are converted already.
    pub all: bool,
}

/// Gives every component its inputs.
pub fn wire(
    components: &mut [Component],
    descriptions: &[&Description],
    told: Told<'_>,
    scenario: &Scenario,
) -> Result<(), Error> {
    let mut inputs = vec![];
    {
        let wiring = Wiring {
            components,
            descriptions,
            connections: told.connections,
            all: told.all,
            scenario,
        };
        wiring.check_connections()?;
        for (component, description) in wiring.components.iter().zip(descriptions) {
            inputs.push(wiring.inputs(component, description)?);
        }
    }
    for (component, inputs) in components.iter_mut().zip(inputs) {
        component.inputs = inputs;
    }
    Ok(())
}

/// The scenario's signals that inputs read, in the order of its columns, and whether each is held
/// between its rows, as integers, booleans and discrete Reals are; a tunable Real may change in a ramp.
pub fn script(
    components: &[Component],
    descriptions: &[&Description],
    scenario: &Scenario,
) -> (Vec<String>, Vec<bool>) {
    let readers = |signal: &str| {
        let source = format!("scenario.{signal}");
        let all = components.iter().zip(descriptions);
        let readers: Vec<&Variable> = all
            .flat_map(|(component, description)| {
                let inputs = component
                    .inputs
                    .iter()
                    .filter(|input| input.source == source);
                inputs.filter_map(|input| description.find(&input.name))
            })
            .collect();
        readers
    };
    let used = scenario.names().iter().filter_map(|signal| {
        let readers = readers(signal);
        let held = readers.iter().any(|variable| variable.is_discrete());
        (!readers.is_empty()).then(|| (signal.clone(), held))
    });
    used.unzip()
}

struct Wiring<'a> {
    components: &'a [Component],
    descriptions: &'a [&'a Description],
    connections: &'a [Connection],
    all: bool,
    scenario: &'a Scenario,
}

impl Wiring<'_> {
    fn check_connections(&self) -> Result<(), Error> {
        let mut fed = HashSet::new();
        for Connection { from, to, .. } in self.connections {
            let input = self.variable(to).is_some_and(|v| self.is_input(v));
            if !input {
                let hint = self.hint(to, |variable| self.is_input(variable));
                let what = format!("of [[connections]] is no input{hint}");
                return Err(Error::variable(to, what));
            }
            if self.family(from).is_none() {
                let hint = self.hint(from, |variable| variable.causality == Causality::Output);
                let what =
                    format!("of [[connections]] is no output and no signal of the scenario{hint}");
                return Err(Error::variable(from, what));
            }
            if !fed.insert(to) {
                return Err(Error::variable(to, "has two sources; keep one"));
            }
        }
        Ok(())
    }

    /// The variable of any component that was probably meant.
    fn hint(&self, name: &str, choose: impl Fn(&Variable) -> bool) -> String {
        let all = self.components.iter().zip(self.descriptions);
        let names: Vec<String> = all
            .flat_map(|(component, description)| {
                let chosen = description.variables.iter().filter(|v| choose(v));
                chosen.map(|v| format!("{}.{}", component.name, v.name))
            })
            .collect();
        did_you_mean(name, names.iter().map(String::as_str))
    }

    fn is_input(&self, variable: &Variable) -> bool {
        match variable.causality {
            Causality::Input => true,
            Causality::Parameter { tunable } => {
                tunable && self.scenario.find(&variable.name).is_some()
            }
            _ => false,
        }
    }

    fn inputs(
        &self,
        component: &Component,
        description: &Description,
    ) -> Result<Vec<Input>, Error> {
        let mut found = vec![];
        for variable in description.chosen(|variable| self.is_input(variable)) {
            let target = format!("{}.{}", component.name, variable.name);
            let explicit = self.connections.iter().find(|known| known.to == target);
            let given = component
                .start
                .iter()
                .any(|(name, _)| *name == variable.name);
            let source = match explicit {
                Some(connection) => connection.from.clone(),
                None if given || self.all => continue,
                None => self.source(component, &variable.name)?,
            };
            let table = explicit.map_or(&[][..], |connection| &connection.table);
            if table.is_empty() || source.starts_with("scenario.") {
                self.check_family(&target, variable, &source)?;
            }
            let line = explicit.and_then(Connection::line);
            found.push(Input {
                noise: None,
                initial: None,
                line: match line {
                    Some(line) if variable.family == Family::Real || self.all => line,
                    Some(_) => {
                        return Err(Error::variable(
                            target,
                            "is not Real; factor and offset are for real inputs",
                        ));
                    }
                    None => self.converted(&target, variable, &source)?,
                },
                name: variable.name.clone(),
                source,
                table: table.to_vec(),
            });
        }
        Ok(found)
    }

    /// Factor and offset between the units of both ends, where both declare one.
    fn converted(
        &self,
        target: &str,
        variable: &Variable,
        source: &str,
    ) -> Result<(f64, f64), Error> {
        let giver = self
            .variable(source)
            .and_then(|variable| variable.unit.as_ref());
        let (Some(giver), Some(taker)) = (giver, &variable.unit) else {
            return Ok((1.0, 0.0));
        };
        giver.conversion(taker).ok_or_else(|| Error::variable(
            target,
            format!("is in '{}', which its source '{source}' in '{}' cannot become; connect another output, or say factor = … in a [[connections]] entry", taker.name, giver.name),
        ))
    }

    /// The one equal-named output of another component, else the scenario's signal.
    fn source(&self, component: &Component, name: &str) -> Result<String, Error> {
        let others = self.components.iter().zip(self.descriptions);
        let mut equal: Vec<&str> = others
            .filter(|(other, _)| other.name != component.name)
            .filter(|(_, description)| fmu::outputs(description).iter().any(|v| v.name == name))
            .map(|(other, _)| other.name.as_str())
            .collect();
        if component.name == "control" && equal == ["plant", "observer"] {
            equal = vec!["observer"];
        }
        let target = || format!("{}.{name}", component.name);
        match equal.as_slice() {
            [other] => Ok(format!("{other}.{name}")),
            [] if self.scenario.find(name).is_some() => Ok(format!("scenario.{name}")),
            [] => Err(Error::variable(
                target(),
                format!(
                    "has no source: add a column '{name}' to {}, a [[connections]] entry, or a value under components.{}.parameters",
                    self.scenario.path().display(),
                    component.name
                ),
            )),
            several => Err(Error::variable(
                target(),
                format!(
                    "has several sources ({}); choose one with a [[connections]] entry",
                    several.join(", ")
                ),
            )),
        }
    }

    /// A variable by `component.variable`.
    fn variable(&self, full: &str) -> Option<&Variable> {
        let (component, name) = full.split_once('.')?;
        let place = self
            .components
            .iter()
            .position(|known| known.name == component)?;
        self.descriptions.get(place)?.find(name)
    }

    /// Family of a source; a signal of the scenario passes for a real.
    fn family(&self, source: &str) -> Option<Family> {
        if let Some(signal) = source.strip_prefix("scenario.") {
            return self.scenario.find(signal).map(|_| Family::Real);
        }
        let variable = self.variable(source)?;
        (variable.causality == Causality::Output).then_some(variable.family)
    }

    fn check_family(&self, target: &str, variable: &Variable, source: &str) -> Result<(), Error> {
        if let Some(signal) = source.strip_prefix("scenario.") {
            return self.check_column(target, variable.family, signal);
        }
        match self.family(source) {
            Some(family) if family == variable.family => Ok(()),
            family => Err(Error::variable(
                target,
                format!(
                    "is {:?}, its source '{source}' is {family:?}",
                    variable.family
                ),
            )),
        }
    }

    fn check_column(&self, target: &str, family: Family, signal: &str) -> Result<(), Error> {
        let fits = |value: &f64| match family {
            Family::Real => true,
            Family::Integer => value.fract() == 0.0,
            Family::Boolean => *value == 0.0 || *value == 1.0,
        };
        let values = self.scenario.values(signal);
        match values.iter().find(|value| !fits(value)) {
            None => Ok(()),
            Some(value) => Err(Error::variable(
                target,
                format!(
                    "is {family:?}, but column '{signal}' of {} has {value}",
                    self.scenario.path().display()
                ),
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const CONTROL: &str = r#"<d><ModelVariables>
        <ScalarVariable name="t" valueReference="0" causality="input"><Real/></ScalarVariable>
        <ScalarVariable name="on" valueReference="1" causality="input"><Boolean/></ScalarVariable>
        <ScalarVariable name="mu" valueReference="2" causality="parameter" variability="tunable"><Real/></ScalarVariable>
        </ModelVariables></d>"#;
    const GIVER: &str = r#"<d><ModelVariables>
        <ScalarVariable name="t" valueReference="0" causality="output"><Real/></ScalarVariable></ModelVariables></d>"#;

    fn wired(
        givers: &[&str],
        csv: &str,
        connections: &[(&str, &str)],
    ) -> Result<Vec<(String, String)>, Error> {
        let parse = |xml| Description::parse(xml).unwrap();
        let mut all: Vec<Description> = givers.iter().map(|_| parse(GIVER)).collect();
        all.push(parse(CONTROL));
        let names = givers.iter().chain(&["control"]);
        let mut components: Vec<Component> = names
            .map(|name| Component {
                name: (*name).into(),
                ..Component::default()
            })
            .collect();
        let scenario = Scenario::parse(Path::new("s.csv"), csv)?;
        let connections: Vec<_> = connections
            .iter()
            .map(|(to, from)| Connection {
                from: (*from).into(),
                to: (*to).into(),
                factor: None,
                offset: None,
                table: vec![],
            })
            .collect();
        let told = Told {
            connections: &connections,
            all: false,
        };
        wire(
            &mut components,
            &all.iter().collect::<Vec<_>>(),
            told,
            &scenario,
        )?;
        let inputs = components.pop().unwrap_or_default().inputs;
        Ok(inputs
            .into_iter()
            .map(|input| (input.name, input.source))
            .collect())
    }

    #[track_caller]
    fn check(givers: &[&str], csv: &str, connections: &[(&str, &str)], expected: &str) {
        let told = match wired(givers, csv, connections) {
            Ok(pairs) => pairs
                .iter()
                .map(|(to, from)| format!("{to}<{from} "))
                .collect(),
            Err(error) => error.to_string(),
        };
        assert!(told.contains(expected), "{told}");
    }

    #[test]
    fn an_input_reads_its_connection_or_an_equal_name_or_the_scenario() {
        let csv = "time,on\n0,1\n";
        check(&["plant"], csv, &[], "t<plant.t on<scenario.on ");
        check(&["plant", "observer"], csv, &[], "t<observer.t ");
        check(
            &["plant", "observer"],
            csv,
            &[("control.t", "plant.t")],
            "t<plant.t ",
        );
        check(&[], "time,on,t\n0,1,5\n", &[], "t<scenario.t ");
        check(&["plant"], "time,on,mu\n0,1,0.3\n", &[], "mu<scenario.mu ");
    }

    #[test]
    fn a_connection_that_cannot_be_is_explained() {
        check(&[], "time,on\n0,1\n", &[], "'control.t' has no source");
        check(&["a", "b"], "time,on\n0,1\n", &[], "several sources (a, b)");
        check(
            &["plant"],
            "time,on\n0,0.5\n",
            &[],
            "column 'on' of s.csv has 0.5",
        );
        check(
            &["plant"],
            "time,on\n0,1\n",
            &[("control.x", "plant.t")],
            "'control.x'",
        );
        check(
            &["plant"],
            "time,on\n0,1\n",
            &[("control.t", "plant.x")],
            "'plant.x'",
        );
        check(
            &["plant"],
            "time,on\n0,1\n",
            &[("control.on", "plant.t")],
            "is Boolean",
        );
    }
}
