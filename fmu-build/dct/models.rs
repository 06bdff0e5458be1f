//! The models this workspace makes FMUs of: the one list that `describe` and `build` go through.

use super::{about, figures, icons, presets, smoke};
use crate::port::Terminal;
use crate::ssp::Component;
use crate::{Entry, Error, Result};
use dct_models::{ClutchControl, Observer, Plant, ports};

/// All models, in the order in which a signal passes through them.
pub const MODELS: &[Entry] = &[
    Entry::of::<Plant>("dct-plant")
        .terminals(TERMINALS)
        .about(about::PLANT)
        .icon(icons::PLANT)
        .parameter_sets(presets::presets::<Plant>)
        .smoke(smoke::PLANT)
        .figures(figures::plant),
    Entry::of::<Observer>("dct-observer")
        .terminals(TERMINALS)
        .about(about::OBSERVER)
        .icon(icons::OBSERVER)
        .parameter_sets(presets::shared::<Observer>)
        .smoke(smoke::OBSERVER)
        .figures(figures::observer),
    Entry::of::<ClutchControl>("dct-clutch-control")
        .terminals(TERMINALS)
        .about(about::CONTROL)
        .icon(icons::CONTROL)
        .parameter_sets(presets::positions::<ClutchControl>)
        .smoke(smoke::CONTROL)
        .figures(figures::control),
];

/// Name of the closed loop of all models.
pub const CLOSED_LOOP: &str = "DctClosedLoop";

/// The closed loop: the models under the names that they have in every system of this project.
pub const COMPONENTS: &[Component] = &[
    Component {
        name: "plant",
        entry: &MODELS[0],
    },
    Component {
        name: "observer",
        entry: &MODELS[1],
    },
    Component {
        name: "control",
        entry: &MODELS[2],
    },
];

/// What belongs together at the models' borders.
const TERMINALS: &[Terminal] = &[
    Terminal {
        name: "sensors",
        kind: "DctSensorBus",
        description: "Speeds that a production car measures: from the plant to the observer",
        members: &[
            ports::ENGINE_SPEED,
            ports::CLUTCH_SPEED[0],
            ports::CLUTCH_SPEED[1],
            ports::WHEEL_SPEED,
        ],
    },
    Terminal {
        name: "driver",
        kind: "DctDriverBus",
        description: "What engine, brake, gearbox and road do: the same to plant and observer",
        members: &[
            ports::ENGINE_TORQUE,
            ports::BRAKE_TORQUE,
            ports::ROAD_GRADE,
            ports::SHAFT_GEAR[0],
            ports::SHAFT_GEAR[1],
        ],
    },
    Terminal {
        name: "actuators",
        kind: "DctActuatorBus",
        description: "Clutch actuators: from the clutch control to plant and observer",
        members: &[
            ports::CLUTCH_POSITION[0],
            ports::CLUTCH_POSITION[1],
            ports::CLUTCH_PRESSURE[0],
            ports::CLUTCH_PRESSURE[1],
        ],
    },
    Terminal {
        name: "friction",
        kind: "DctFrictionBus",
        description: "Friction learnt while the clutches slip: from the observer to the control",
        members: &[
            ports::CLUTCH_FRICTION[0],
            ports::CLUTCH_FRICTION[1],
            ports::CLUTCH_MU_F[0],
            ports::CLUTCH_MU_F[1],
        ],
    },
];

/// Names of all models.
#[must_use]
pub fn names() -> Vec<&'static str> {
    MODELS.iter().map(|entry| entry.name).collect()
}

/// The model of this name.
///
/// # Errors
/// When there is none; the error tells which name was probably meant.
pub fn find(name: &str) -> Result<&'static Entry> {
    let entry = MODELS.iter().find(|entry| entry.name == name);
    entry.ok_or_else(|| Error::UnknownModel {
        name: name.to_owned(),
        known: names(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_found_by_its_name_and_a_slip_of_the_pen_is_told() {
        for name in names() {
            assert_eq!(find(name).unwrap().name, name);
        }
        let said = |name| find(name).err().unwrap().to_string();
        let known = "the models are DctPlant, DctObserver, DctClutchControl";
        assert_eq!(
            said("DctPlnt"),
            format!("there is no model DctPlnt; {known}; did you mean 'DctPlant'?")
        );
        assert_eq!(said("Engine"), format!("there is no model Engine; {known}"));
    }
}
