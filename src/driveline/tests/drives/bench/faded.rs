//! The paper's drive with friction that changes, with gears that lose power, and on another box.

use super::Scenario;
use super::scenarios::paper;
use dct_driveline::Params;
use dct_driveline::friction::FrictionCurve;
use dct_driveline::thermal::Thermal;

/// Friction falls by 15 % with the slip and by a third with 100 K: `assumed:` a lining that is not good.
pub fn fading() -> Scenario {
    let mut scenario = paper();
    scenario.name = "friction fades".to_string();
    for clutch in &mut scenario.p.clutch {
        clutch.curve = FrictionCurve {
            slip: [0.0, 10.0, 30.0, 60.0, 120.0],
            factor: [1.0, 0.97, 0.93, 0.88, 0.85],
        };
        let mut thermal = Thermal {
            capacity: 400.0,
            conductance: 5.0,
            ..Thermal::OFF
        };
        let points = thermal.temperature.len();
        for k in 0..points {
            let share = k as f64 / (points - 1) as f64;
            thermal.temperature[k] = thermal.ambient + 100.0 * share;
            thermal.factor[k] = 1.0 - share / 3.0;
        }
        clutch.thermal = thermal;
    }
    scenario
}

/// Every gear loses 2 % of the power; no observer knows.
pub fn losing() -> Scenario {
    let mut scenario = paper();
    scenario.name = "gears lose 2 %".to_string();
    let efficiencies = scenario.p.eta.as_flattened_mut().iter_mut();
    efficiencies.for_each(|eta| *eta = 0.98);
    scenario
}

/// The same positions and torques on the seven-speed box.
pub fn dry_7() -> Scenario {
    Scenario {
        name: "dry7".to_string(),
        p: Params::DRY_7,
        ..paper()
    }
}

/// The same on linings that lose 6 % over slip and fade when hot: [`Params::DRY_7_FADE`].
pub fn dry_7_fade() -> Scenario {
    Scenario {
        name: "dry7_fade".to_string(),
        p: Params::DRY_7_FADE,
        ..paper()
    }
}

/// The same after a mountain road: faces at 280 °C, where the resin begins to give up.
pub fn dry_7_hot() -> Scenario {
    let mut scenario = dry_7_fade();
    scenario.name = "dry7_fade, hot".to_string();
    for clutch in &mut scenario.p.clutch {
        clutch.thermal.start = 553.15;
    }
    scenario
}
