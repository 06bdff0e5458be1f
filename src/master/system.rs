//! The system file of `dct-harness`: components, scenario, step; and the plan that follows.

use crate::description::Description;
use crate::error::Error;
use crate::given::Given;
use crate::library::{Libraries, Library};
use crate::mapping::Mapping;
use crate::names::{Name, PLANT};
use crate::noise::Noise;
use crate::plan::{Component, Connection, Coupling, Plan, Value};
use crate::scenario::Scenario;
use crate::ssp::{self, Package};
use crate::supplier::{Supplier, put};
use crate::system_file::{File, Parameters, Part, Set};
use crate::{ssv, system_file, wiring};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Components that step first, in this order; all others keep the order of the file.
const ORDER: [&str; 3] = ["plant", "observer", "control"];

/// More communication points than this are a mistake.
const MOST_STEPS: f64 = 1e8;

/// A system file that has been read.
pub struct System {
    /// Name of the system.
    pub name: String,
    /// Communication step [s].
    pub step: f64,
    /// End of the run [s].
    pub stop: f64,
    /// The scenario; an .ssp may have none.
    pub scenario: Option<PathBuf>,
    /// Whether inputs have slopes within a step.
    pub interpolate: bool,
    /// What is noisy.
    pub noise: Noise,
    path: PathBuf,
    coupling: Coupling,
    parts: Vec<(String, Part)>,
    connections: Vec<Connection>,
    /// An .ssp, where the FMUs are; it has all connections.
    package: Option<Package>,
    given: Given,
    plant: Option<PathBuf>,
    mapping: Option<Mapping>,
}

impl System {
    /// Reads a system file, .toml or .ssp; the FMUs of an .ssp are opened.
    pub fn open(path: &Path, libraries: &mut Libraries) -> Result<Self, Error> {
        if !ssp::is_one(path) {
            return Self::load(path);
        }
        let package = Package::open(path, libraries.folder())?;
        let told = ssp::read(&package, libraries)?;
        let parts = told.members.into_iter().map(|member| {
            let part = Part {
                fmu: member.fmu,
                parameters: Parameters::One(Set::Values(member.values)),
                substeps: member.substeps,
            };
            (member.name, part)
        });
        Ok(Self {
            name: told.name,
            step: told.step,
            stop: told.stop.unwrap_or(f64::NAN),
            scenario: told.scenario,
            interpolate: told.interpolate,
            noise: Noise::default(),
            path: path.to_owned(),
            coupling: told.coupling,
            parts: parts.collect(),
            connections: told.connections,
            package: Some(package),
            given: Given::default(),
            plant: None,
            mapping: None,
        })
    }

    /// Reads a system file.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = system_file::text(path)?;
        let file: File = toml::from_str(&text).map_err(|error| Error::Content {
            path: path.to_owned(),
            line: error.span().map_or(0, |span| line(&text, span.start)),
            what: error.message().to_owned(),
        })?;
        let parts = file.components.into_iter();
        let mut parts: Vec<_> = parts.map(|(Name(name), part)| (name, part)).collect();
        parts.sort_by_key(|(name, _)| rank(name));
        let folder = path.parent().unwrap_or(Path::new(""));
        Ok(Self {
            name: file.system.name,
            step: file.system.step,
            stop: file.system.stop,
            scenario: Some(folder.join(file.system.scenario)),
            path: path.to_owned(),
            coupling: file.system.coupling,
            interpolate: file.system.interpolate,
            noise: Noise::new(file.noise),
            parts,
            connections: file.connections,
            package: None,
            given: Given::default(),
            plant: None,
            mapping: None,
        })
    }

    /// Sets one parameter or start value, above all others.
    pub fn set(&mut self, component: &str, variable: &str, value: Value) -> Result<(), Error> {
        let system = (self.path.as_path(), &*known(&self.parts));
        self.given.set((component, variable, value), system)
    }

    /// Takes a parameter file (.ssv) for a component, above the values of the file.
    pub fn preset(&mut self, component: &str, file: &Path) -> Result<(), Error> {
        self.given
            .preset(component, file, (&self.path, &known(&self.parts)))
    }

    /// Lets observer and control start with what an observer had learnt in an earlier run (.ssv), above `preset`.
    pub fn start_with(&mut self, learnt: &Path) -> Result<(), Error> {
        self.given.learnt(learnt, (&self.path, &known(&self.parts)))
    }

    /// Takes another FMU as component `plant`.
    pub fn replace_plant(&mut self, fmu: PathBuf) -> Result<(), Error> {
        self.needs_plant("--plant")?;
        self.plant = Some(fmu);
        Ok(())
    }

    /// Lets the plant stand under the names, units and codings of a mapping.
    pub fn map(&mut self, mapping: Mapping) -> Result<(), Error> {
        self.needs_plant("--map")?;
        let known = |name: &String| {
            let standard = ORDER.contains(&name.as_str());
            standard || self.parts.iter().any(|(known, _)| known == name)
        };
        let mut named = mapping.values.keys().chain(&mapping.share);
        if let Some(missing) = named.find(|name| !known(name)) {
            let file = self.path.display();
            return Err(mapping.error(format!("{file} has no component '{missing}'")));
        }
        self.mapping = Some(mapping);
        Ok(())
    }

    /// Reads the scenario. Inputs of an .ssp that it has no column for keep their start values; returns them.
    pub fn scenario(&mut self) -> Result<(Scenario, Vec<String>), Error> {
        let script =
            |connection: &Connection| Some(connection.from.strip_prefix("scenario.")?.to_owned());
        let Some(path) = &self.scenario else {
            if self
                .connections
                .iter()
                .any(|connection| script(connection).is_some())
            {
                return Err(self.fault("has inputs of its own; give --scenario FILE.csv".into()));
            }
            return Ok((Scenario::none(), vec![]));
        };
        let scenario = Scenario::load(path)?;
        if self.package.is_none() {
            return Ok((scenario, vec![]));
        }
        let free =
            |c: &mut Connection| script(c).is_some_and(|name| scenario.find(&name).is_none());
        let free = self
            .connections
            .extract_if(.., free)
            .map(|c| c.to)
            .collect();
        Ok((scenario, free))
    }

    fn fault(&self, what: String) -> Error {
        Error::Content {
            path: self.path.clone(),
            line: 0,
            what,
        }
    }

    fn needs_plant(&self, option: &str) -> Result<(), Error> {
        if self.parts.iter().any(|(name, _)| name == PLANT) {
            return Ok(());
        }
        let file = self.path.display();
        Err(Error::Usage(format!(
            "{option}: {file} has no component '{PLANT}'"
        )))
    }

    /// Communication points [s].
    pub fn times(&self) -> Result<Vec<f64>, Error> {
        if self.stop.is_nan() && self.package.is_some() {
            return Err(self.fault("says no stopTime; give --stop SECONDS".into()));
        }
        let usable = |seconds: f64| seconds.is_finite() && seconds > 0.0;
        if !usable(self.step) || !usable(self.stop) || self.stop / self.step > MOST_STEPS {
            return Err(self.fault(format!(
                "step = {:?} s and stop = {:?} s must be above 0, with at most {MOST_STEPS:e} steps",
                self.step, self.stop
            )));
        }
        Ok(crate::plan::communication_points(self.step, self.stop))
    }

    /// The scenario's and the noise's signals of a plan at all `times` [s], row by row.
    pub fn rows(
        &self,
        scenario: &Scenario,
        (plan, held): (&Plan, &[bool]),
        times: &[f64],
    ) -> Result<Vec<f64>, Error> {
        let (scripted, noise) = plan.script.split_at(held.len().min(plan.script.len()));
        let rows = scenario.rows(scripted, held, times);
        self.noise.beside(rows, held.len(), noise, times)
    }

    /// Decides everything, and which of the scenario's signals are held between its rows; FMU files are looked
    /// for in `folder`.
    pub fn plan(
        &self,
        folder: &Path,
        scenario: &Scenario,
        libraries: &mut Libraries,
    ) -> Result<(Plan, Vec<bool>), Error> {
        let opened = self.opened(folder, libraries)?;
        let mut components = self.unconnected(&opened)?;
        let supplier = self.supplier(&opened, &mut components)?;
        let seen = self.parts.iter().zip(&opened).map(|((name, _), library)| {
            let ours = supplier.as_ref().filter(|_| name == PLANT);
            ours.map_or(library.description(), |supplier| &supplier.ours)
        });
        let seen: Vec<&Description> = seen.collect();
        let told = wiring::Told {
            connections: &self.connections,
            all: self.package.is_some(),
        };
        wiring::wire(&mut components, &seen, told, scenario)?;
        let (mut script, held) = wiring::script(&components, &seen, scenario);
        script.extend(self.noise.wire(&mut components, &seen, self.interpolate)?);
        if let (Some(supplier), Some(plant)) = (&supplier, plant(&mut components)) {
            plant.start = supplier.translated(&plant.start)?;
            plant.mapped = Some(supplier.plan());
        }
        let plan = Plan {
            components,
            coupling: self.coupling,
            interpolate: self.interpolate,
            log: false,
            script,
            record: None,
        };
        Ok((plan, held))
    }

    /// The components with their start values, before anything is connected.
    fn unconnected(&self, opened: &[Arc<Library>]) -> Result<Vec<Component>, Error> {
        let component = |((name, part), library): (&(String, Part), &Arc<Library>)| {
            Ok(Component {
                name: name.clone(),
                start: self.values(name, part, library.description())?,
                fmu: library.path.clone(),
                inputs: vec![],
                substeps: part.substeps.get(),
                mapped: None,
            })
        };
        self.parts.iter().zip(opened).map(component).collect()
    }

    fn opened(&self, folder: &Path, libraries: &mut Libraries) -> Result<Vec<Arc<Library>>, Error> {
        let own = |name: &str| self.plant.as_ref().filter(|_| name == PLANT);
        let paths = self.parts.iter().map(|(name, part)| {
            let given = own(name).cloned();
            given.unwrap_or_else(|| folder.join(&part.fmu))
        });
        paths.map(|path| libraries.open(&path)).collect()
    }

    /// The mapped plant, if there is a mapping; others have got from it what it shares.
    fn supplier<'a>(
        &'a self,
        opened: &'a [Arc<Library>],
        components: &mut [Component],
    ) -> Result<Option<Supplier<'a>>, Error> {
        let place = components.iter().position(|part| part.name == PLANT);
        let library = place.and_then(|place| opened.get(place));
        let (Some(mapping), Some(library)) = (&self.mapping, library) else {
            return Ok(None);
        };
        let supplier = Supplier::new(mapping, library.description())?;
        let values = plant(components).map(|plant| plant.start.clone());
        let shared = supplier.shared(&values.unwrap_or_default());
        let all = components.iter_mut().zip(opened);
        for (part, library) in all.filter(|(part, _)| mapping.share.contains(&part.name)) {
            supplier.share(&shared, library.description(), &mut part.start);
        }
        Ok(Some(supplier))
    }

    /// Values of a component; of two for one variable the last counts.
    fn values(
        &self,
        name: &str,
        part: &Part,
        description: &Description,
    ) -> Result<Vec<(String, Value)>, Error> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let sets = match &part.parameters {
            Parameters::One(set) => std::slice::from_ref(set),
            Parameters::Several(sets) => sets.as_slice(),
        };
        let mut found: Vec<(String, Value)> = vec![];
        for set in sets {
            let values = match set {
                Set::File(file) => ssv::read(&folder.join(file))?,
                Set::Values(values) => values.clone().into_iter().collect(),
            };
            values
                .into_iter()
                .for_each(|(name, value)| put(&mut found, name, value));
        }
        if let Some(mapping) = &self.mapping {
            if name == PLANT {
                found.retain(|(known, _)| !mapping.ignore.contains(known));
            }
            for (known, value) in mapping.values.get(name).into_iter().flatten() {
                put(&mut found, known.clone(), value.clone());
            }
        }
        self.given.put(name, description, &mut found);
        Ok(found)
    }
}

fn known(parts: &[(String, Part)]) -> Vec<&str> {
    parts.iter().map(|(name, _)| &**name).collect()
}

fn plant(components: &mut [Component]) -> Option<&mut Component> {
    components.iter_mut().find(|part| part.name == PLANT)
}

fn rank(name: &str) -> usize {
    let place = ORDER.iter().position(|known| *known == name);
    place.unwrap_or(ORDER.len())
}

fn line(text: &str, offset: usize) -> usize {
    text.get(..offset).unwrap_or(text).matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<System, Error> {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("loop.toml");
        std::fs::write(&path, text).unwrap();
        System::load(&path)
    }

    const HEAD: &str = "[system]\nname = \"n\"\nstep = 0.01\nstop = 1\nscenario = \"s.csv\"\n";

    #[test]
    fn the_plant_steps_first() {
        let parts = "[components.zulu]\nfmu = \"z\"\n[components.observer]\nfmu = \"o\"\n[components.plant]\nfmu = \"p\"\n";
        let system = load(&format!("{HEAD}{parts}")).unwrap_or_else(|error| panic!("{error}"));
        let names: Vec<_> = system.parts.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["plant", "observer", "zulu"]);
        assert_eq!(system.times().unwrap_or_default().len(), 101);
    }

    #[test]
    fn a_fault_is_told_with_its_line() {
        let Err(error) = load(&HEAD.replace("0.01", "\"fast\"")) else {
            panic!("was read")
        };
        assert!(error.to_string().contains("loop.toml:3: "), "{error}");
    }

    #[test]
    fn a_step_that_makes_no_sense_is_refused() {
        for step in ["0.0", "-1.0", "nan", "1e-300"] {
            let text = HEAD.replace("0.01", step) + "[components.plant]\nfmu = \"p\"\n";
            let system = load(&text).unwrap_or_else(|error| panic!("{error}"));
            assert!(system.times().is_err(), "{step}");
        }
    }
}
