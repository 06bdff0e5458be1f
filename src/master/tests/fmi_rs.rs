//! fmi-rs, the importer of fmpy's authors: its validator finds nothing in the three FMUs, and they give the
//! bits that they give in fmpy, each alone and all in a loop.
//!
//! Needs `target/fmu/*.fmu` and `.venv`, as `cargo xtask test` makes them.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::fmi2::types::fmi2Status;
use fmi_rs::fmi2::{CS, FMU2};
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, ScalarVariable, VariableType};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

type Values = BTreeMap<String, BTreeMap<String, Value>>;

/// What tests/importer_cases.py gives every importer, and fmpy's answers.
#[derive(Deserialize)]
struct Cases {
    models: Vec<String>,
    connections: Vec<(String, String, String)>,
    starts: Values,
    later: Values,
    step: f64,
    steps: u32,
    half: u32,
    alone: Values,
    loop_starts: Values,
    /// Communication step [s], outputs.
    loops: Vec<(f64, Values)>,
}

const PYTHON: &str = "
import json, importer_cases as c
print(json.dumps({
    'models': c.MODELS, 'connections': c.CONNECTIONS, 'starts': c.STARTS, 'later': c.LATER,
    'step': c.STEP, 'steps': c.STEPS, 'half': c.HALF, 'loop_starts': c.LOOP_STARTS,
    'alone': {model: c.expected(model) for model in c.MODELS},
    'loops': [(step, c.expected_loop(step)) for step in c.LOOP_STEPS],
}))
";

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    root.canonicalize().unwrap()
}

fn cases() -> Cases {
    let mut python = Command::new(root().join(".venv/bin/python"));
    let done = python
        .args(["-c", PYTHON])
        .current_dir(root().join("tests"))
        .output()
        .unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    serde_json::from_slice(&done.stdout).unwrap()
}

/// An instance with the description it was made from.
struct Part {
    instance: Arc<FMU2<CS>>,
    /// Keeps the unpacked files.
    file: FMU2Builder,
}

fn done(status: fmi2Status) {
    assert_eq!(status, fmi2Status::Ok);
}

impl Part {
    fn new(model: &str) -> Self {
        let path = root().join(format!("target/fmu/{model}.fmu"));
        let file = FMU2Builder::new(&path).unwrap();
        let instance = file.instantiate_cs(model).unwrap();
        Self { instance, file }
    }

    fn variable(&self, name: &str) -> &ScalarVariable {
        self.file.model_description.variable_by_name(name).unwrap()
    }

    fn set(&self, name: &str, value: &Value) {
        let variable = self.variable(name);
        let references = [variable.valueReference];
        done(match variable.variableType {
            VariableType::Real { .. } => self
                .instance
                .setReal(&references, &[value.as_f64().unwrap()]),
            VariableType::Boolean { .. } => {
                let value = i32::from(value.as_bool().unwrap());
                self.instance.setBoolean(&references, &[value])
            }
            _ => {
                let value = i32::try_from(value.as_i64().unwrap()).unwrap();
                self.instance.setInteger(&references, &[value])
            }
        });
    }

    fn set_all(&self, values: &BTreeMap<String, Value>) {
        for (name, value) in values {
            self.set(name, value);
        }
    }

    /// A value; Booleans as 0 and 1, as fmpy has them.
    fn get(&self, name: &str) -> Value {
        let variable = self.variable(name);
        let references = [variable.valueReference];
        let (mut real, mut whole) = ([0.0], [0]);
        done(match variable.variableType {
            VariableType::Real { .. } => self.instance.getReal(&references, &mut real),
            VariableType::Boolean { .. } => self.instance.getBoolean(&references, &mut whole),
            _ => self.instance.getInteger(&references, &mut whole),
        });
        match variable.variableType {
            VariableType::Real { .. } => real[0].into(),
            _ => whole[0].into(),
        }
    }

    fn enter(&self) {
        done(self.instance.setupExperiment(None, 0.0, None));
        done(self.instance.enterInitializationMode());
    }

    fn exit(&self) {
        done(self.instance.exitInitializationMode());
    }

    fn step(&self, number: u32, step: f64) {
        done(self.instance.doStep(f64::from(number) * step, step, 1));
    }

    /// Compares all outputs to the last bit; JSON numbers of Python name every double exactly.
    fn compare(&self, expected: &BTreeMap<String, Value>, when: &str) {
        let outputs = self.file.model_description.modelVariables.iter();
        let outputs: Vec<_> = outputs
            .filter(|v| v.causality == Causality::Output)
            .collect();
        assert!(!outputs.is_empty());
        for output in outputs {
            let (found, wanted) = (self.get(&output.name), &expected[&output.name]);
            let same = found.as_f64().map(f64::to_bits) == wanted.as_f64().map(f64::to_bits);
            assert!(same, "{when}: {} is {found}, in fmpy {wanted}", output.name);
        }
    }
}

#[test]
fn the_validator_of_fmi_rs_finds_nothing() {
    for model in ["DctPlant", "DctObserver", "DctClutchControl"] {
        let found = Part::new(model).file.model_description.validate();
        let texts: Vec<_> = found
            .iter()
            .map(|problem| problem.message.as_str())
            .collect();
        assert_eq!(texts, Vec::<&str>::new(), "{model}");
    }
}

#[test]
fn the_validator_of_fmi_rs_finds_a_spoilt_description() {
    let path = root().join("modelDescription/DctPlant.xml");
    let sound = std::fs::read_to_string(path).unwrap();
    let spoilt = sound.replacen("name=\"brake.torque\"", "name=\"engine.torque\"", 1);
    for (text, problems) in [(&sound, 0), (&spoilt, 1)] {
        let found = ModelDescription::from_string(text).unwrap().validate();
        assert_eq!(found.len(), problems, "{found:?}");
    }
}

#[test]
fn alone_and_in_the_loop_they_give_the_bits_of_fmpy() {
    let cases = cases();
    assert!(cases.loops.len() >= 3 && !cases.connections.is_empty());
    for model in &cases.models {
        alone(&cases, model);
    }
    for (step, expected) in &cases.loops {
        coupled(&cases, *step, expected);
    }
}

fn alone(cases: &Cases, model: &str) {
    let part = Part::new(model);
    part.set_all(&cases.starts[model]);
    part.enter();
    part.exit();
    for number in 0..cases.steps {
        if number == cases.half {
            part.set_all(&cases.later[model]);
        }
        part.step(number, cases.step);
    }
    part.compare(&cases.alone[model], "alone");
}

/// Jacobi: all outputs are passed on, then all parts step.
fn coupled(cases: &Cases, step: f64, expected: &Values) {
    let parts: BTreeMap<_, _> = cases
        .models
        .iter()
        .map(|model| (model, Part::new(model)))
        .collect();
    for (model, part) in &parts {
        part.set_all(&cases.loop_starts[*model]);
        part.enter();
    }
    for _ in &parts {
        transfer(cases, &parts);
    }
    parts.values().for_each(Part::exit);
    let mut number = 0;
    while f64::from(number) * step < 1.0 - 0.5 * step {
        transfer(cases, &parts);
        parts.values().for_each(|part| part.step(number, step));
        number += 1;
    }
    for (model, part) in &parts {
        part.compare(&expected[*model], &format!("in a loop of {step} s"));
    }
}

fn transfer(cases: &Cases, parts: &BTreeMap<&String, Part>) {
    let values = cases
        .connections
        .iter()
        .map(|(from, to, name)| (to, name, parts[from].get(name)));
    for (to, name, value) in values.collect::<Vec<_>>() {
        parts[to].set(name, &value);
    }
}
