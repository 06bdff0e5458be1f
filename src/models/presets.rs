//! Presets: vehicles by name, and the rows of a model that describe the vehicle.

use crate::vehicle::Vehicle;
use crate::{ClutchControl, Observer, Plant};
use dct_driveline::Params;
use fmi2_cosim::{Causality, Model, Variable};

/// A vehicle with a name.
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// Name, e.g. `wet6`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// Its numbers; their sources are in its documentation.
    pub params: Params,
    /// Another preset that it differs from in what the plant alone knows: other models take that one.
    pub of_plant: bool,
}

/// All presets; the first is the one every model starts with.
pub const PRESETS: [Preset; 5] = [
    Preset {
        name: "paper",
        title: "the paper's test bench, Table 1 and assumed values",
        params: Params::TABLE_1,
        of_plant: false,
    },
    Preset {
        name: "wet6",
        title: "six gears, wet clutches, after mathworks/Simscape-Dual-Clutch",
        params: Params::WET_6,
        of_plant: false,
    },
    Preset {
        name: "dry7",
        title: "seven gears, dry clutches, ratios of the 0AM (DQ200)",
        params: Params::DRY_7,
        of_plant: false,
    },
    Preset {
        name: "wet6_fade",
        title: "wet6 whose friction follows slip and oil-cooled temperature",
        params: Params::WET_6_FADE,
        of_plant: true,
    },
    Preset {
        name: "dry7_fade",
        title: "dry7 whose friction follows slip and temperature",
        params: Params::DRY_7_FADE,
        of_plant: true,
    },
];

/// A model that a preset can describe.
pub trait Parametrised: Model {
    /// The model with the vehicle of a preset; everything else is at its start value.
    fn of_preset(preset: &Preset) -> Self;
    /// The vehicle it knows.
    fn vehicle(&mut self) -> Params;
    /// Whether a row is a parameter of the vehicle, so that a preset has a value for it.
    fn describes_vehicle(row: &Variable<Self>) -> bool;
}

/// The plant knows all of a vehicle: what another model shares with it is the vehicle's.
macro_rules! parametrised {
    ($($model:ty)*) => {$(
        impl Parametrised for $model {
            fn of_preset(preset: &Preset) -> Self {
                let mut model = Self::default();
                *model.params() = preset.params;
                model
            }

            fn vehicle(&mut self) -> Params {
                *self.params()
            }

            fn describes_vehicle(row: &Variable<Self>) -> bool {
                row.causality == Causality::Parameter && is_of_vehicle(row.name)
            }
        }
    )*};
}

parametrised! { Plant Observer ClutchControl }

fn is_of_vehicle(name: &str) -> bool {
    let found = Plant::VARIABLES.iter().find(|row| row.name == name);
    found.is_some_and(|row| row.causality == Causality::Parameter) && !name.ends_with("_start")
}
