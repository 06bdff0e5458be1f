//! Figures of a documentation page that are measured when the page is made, never typed.
//!
//! The models run here over the scenarios of `examples/closed_loop`, and what they miss is counted as
//! `dct-harness` does.

mod control;
mod observer;
mod plant;

pub(super) use control::control;
pub(super) use observer::observer;
pub(super) use plant::plant;

use crate::Figures;
use crate::drive::{Loop, Place, Role};

/// Communication step [s].
const STEP: f64 = 1e-3;
/// Friction that is believed in the paper's cases [1].
const CASES: [[f64; 2]; 2] = [[0.4, 0.1], [0.1, 0.4]];

/// Two significant figures; a whole number from 10 on.
fn rounded(value: f64) -> String {
    let digits = match value {
        value if value < 0.095 => 3,
        value if value < 0.95 => 2,
        value if value < 9.95 => 1,
        _ => 0,
    };
    format!("{value:.digits$}")
}

/// Where a component has an output or input.
fn place(all: &Loop<'_>, at: usize, name: &str) -> Option<Place> {
    let roles = [Role::Output, Role::Input];
    let signals = roles.into_iter().flat_map(|role| all.signals(at, role));
    let mut named = signals.filter(|(found, _)| found == name);
    named.next().map(|(_, place)| place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_figures() {
        let shown = [0.0123, 0.123, 1.23, 9.96, 123.4].map(rounded);
        assert_eq!(shown, ["0.012", "0.12", "1.2", "10", "123"]);
    }
}
