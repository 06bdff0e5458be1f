//! The smoke experiment of this workspace's models: the launch of the closed loop, which each of them sees from
//! its own side.

use crate::drive::{Loop, Role, Stimuli, shown};
use crate::models::{MODELS, Smoke};
use crate::{Error, Result, library};
use std::fmt::Write as _;
use std::fs;

const SCENARIOS: &str = "examples/closed_loop/scenarios";
/// Launch and lock-up of clutch 1 [s].
const STOP: f64 = 3.0;
/// Communication step [s]: a power of 2, so that no importer rounds a time or a step.
const STEP: f64 = 1.0 / 128.0;
/// Believed friction of the paper's case 1 [1].
const FRICTION: [(&str, f64); 2] = [
    ("clutch1.nominalFriction", 0.4),
    ("clutch2.nominalFriction", 0.1),
];
/// Speed at which the engine idles [rad/s].
const IDLE: [(&str, f64); 1] = [("engine.speed_start", 90.0)];

/// The launch as seen by the plant.
pub(crate) const PLANT: Smoke = smoke("Launch: clutch 1 closes, slips and locks up", plant, &IDLE);
/// By the observer.
pub(crate) const OBSERVER: Smoke = smoke(
    "Launch with a clutch whose friction is believed to be 0.4 instead of 0.26",
    observer,
    &FRICTION,
);
/// By the control.
pub(crate) const CONTROL: Smoke = smoke(
    "Launch by torque requests, with the friction that the observer learns",
    control,
    &FRICTION,
);

const fn smoke(
    description: &'static str,
    inputs: fn() -> Result<String>,
    parameters: &'static [(&'static str, f64)],
) -> Smoke {
    Smoke {
        description,
        inputs,
        parameters,
        step: STEP,
        every: 16,
    }
}

fn plant() -> Result<String> {
    inputs(0)
}

fn observer() -> Result<String> {
    inputs(1)
}

fn control() -> Result<String> {
    inputs(2)
}

/// What a model's inputs are while the closed loop runs.
fn inputs(model: usize) -> Result<String> {
    let parameters: Vec<_> = IDLE.into_iter().chain(FRICTION).collect();
    let stimuli = scenario("torque_tracking.csv", &parameters, STOP)?;
    let parts = MODELS.iter().map(|entry| (entry.part)()).collect();
    let mut all = Loop::new(parts, &stimuli);
    let inputs = all.signals(model, Role::Input);
    let mut text = String::from("time");
    for (name, _) in &inputs {
        let _ = write!(text, ",{name}");
    }
    text.push('\n');
    all.run(STEP, &mut |time, all| {
        all.exchange(time)?;
        let _ = write!(text, "{time:?}");
        for (_, place) in &inputs {
            let _ = write!(text, ",{}", shown(place.kind, all.value(model, *place)?));
        }
        text.push('\n');
        Ok(())
    })?;
    Ok(text)
}

/// A scenario of `examples/closed_loop` up to a time [s], with parameters as further columns.
pub(crate) fn scenario(name: &str, parameters: &[(&str, f64)], until: f64) -> Result<Stimuli> {
    let path = library::workspace().join(SCENARIOS).join(name);
    let read = fs::read_to_string(&path);
    let scenario = read.map_err(|source| Error::Io {
        path: path.clone(),
        source,
    })?;
    let mut text = String::new();
    for line in scenario.lines() {
        let time = line.split(',').next().unwrap_or_default().parse::<f64>();
        if time.as_ref().is_ok_and(|time| *time > until) {
            break;
        }
        text.push_str(line);
        for (name, value) in parameters {
            match time {
                Ok(_) => drop(write!(text, ",{value}")),
                Err(_) => drop(write!(text, ",{name}")),
            }
        }
        text.push('\n');
    }
    Stimuli::parse(&text).map_err(|(line, what)| Error::Stimuli { path, line, what })
}
