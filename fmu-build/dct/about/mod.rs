//! Prose of the documentation pages of this workspace's models.

mod control;
mod observer;
mod plant;

pub(super) use control::CONTROL;
pub(super) use observer::OBSERVER;
pub(super) use plant::PLANT;

use crate::about::{About, Equation};

/// An equation in one line.
const fn equation(number: &'static str, formula: &'static str, meaning: &'static str) -> Equation {
    Equation {
        number,
        formula,
        meaning,
    }
}
