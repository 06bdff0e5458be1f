//! The closed loop of this workspace's models inside this program, over the scenarios of `examples/closed_loop`.

use crate::drive::{Driven, Part, Stimuli};
use crate::{Error, Result, library};
use dct_models::{ClutchControl, Observer, Plant};
use std::fmt::Write as _;
use std::fs;

const SCENARIOS: &str = "examples/closed_loop/scenarios";

/// The models, in the order in which a signal passes through them.
pub(crate) fn models() -> Vec<Box<dyn Part>> {
    vec![
        Driven::<Plant>::boxed(),
        Driven::<Observer>::boxed(),
        Driven::<ClutchControl>::boxed(),
    ]
}

/// A scenario of `examples/closed_loop` up to a time [s], with parameters as further columns.
pub(crate) fn scenario(name: &str, parameters: &[(&str, f64)], until: f64) -> Result<Stimuli> {
    let path = library::workspace().join(SCENARIOS).join(name);
    let read = fs::read_to_string(&path);
    let scenario = read.map_err(Error::io(&path))?;
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
