//! A drive with the wet six-speed box, whose clutches are moved by pressure.

use super::scenarios::base;
use super::{Knots, Scenario};
use dct_driveline::Params;

/// The drive as the FMUs take it as well.
const DRIVE: &str = include_str!("../../../../../examples/closed_loop/scenarios/drive_wet6.csv");

/// One signal of [`DRIVE`] over time.
fn signal(name: &str) -> Knots {
    let mut rows = DRIVE.lines().map(|row| row.split(','));
    let column = rows
        .next()
        .and_then(|mut names| names.position(|signal| signal == name));
    let knots: Knots = rows
        .filter_map(|mut row| {
            let time = row.clone().next()?.parse().ok()?;
            Some((time, row.nth(column?)?.parse().ok()?))
        })
        .collect();
    assert!(knots.len() + 1 == DRIVE.lines().count(), "{name}");
    knots
}

/// Launch, up to third gear, kick-down to second, engine braking, tip-in. A clutch touches at 5 bar.
///
/// No gain of any method was tuned on it, nor on this box.
pub fn wet_6() -> Scenario {
    let gears = [signal("shaft1.gear"), signal("shaft2.gear")];
    let preselected = |row: usize| gears.each_ref().map(|shaft| shaft[row].1 as i32);
    Scenario {
        p: Params::WET_6,
        t_e: signal("engine.torque"),
        pressure: [signal("clutch1.pressure"), signal("clutch2.pressure")],
        t_brake: signal("brake.torque"),
        phi: signal("road.grade"),
        gears: (0..gears[0].len())
            .map(|row| (gears[0][row].0, preselected(row)))
            .collect(),
        ..base("wet6", 22.0)
    }
}

/// The same with linings whose friction rises with slip and falls with the temperature of their plates.
pub fn wet_6_fade() -> Scenario {
    Scenario {
        name: "wet6_fade".to_string(),
        p: Params::WET_6_FADE,
        ..wet_6()
    }
}
