//! The smoke experiment of this workspace's models: the launch of the closed loop, which each of them sees from
//! its own side.

use crate::dct::closed_loop::{models, scenario};
use crate::drive::{Loop, Role, shown};
use crate::{Result, Smoke};
use std::fmt::Write as _;

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
    let mut all = Loop::new(models(), &stimuli);
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
