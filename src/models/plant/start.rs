//! How a run starts: rows of its parameters, and what outputs have their first value from.
//!
//! Speeds start from parameters and gears, whatever torques and positions are: so an importer that couples the FMUs
//! finds an order for their initial values, plant, observer, control, and no loop.

use super::Plant;
use fmi2_cosim::{Unit as U, Variable};

/// The wheels, and how the gears that are preselected turn them to shafts; others before them.
macro_rules! turned {
    ($($other:literal),*; $($shaft:literal),*) => {
        &[
            $($other,)*
            "vehicle.speed_start",
            "wheel.radius",
            $(
                concat!($shaft, ".gear"),
                concat!($shaft, ".finalDriveRatio"),
                concat!($shaft, ".gearRatio[1]"),
                concat!($shaft, ".gearRatio[2]"),
                concat!($shaft, ".gearRatio[3]"),
                concat!($shaft, ".gearRatio[4]"),
                concat!($shaft, ".reverseRatio"),
            )*
        ]
    };
}

/// The start temperature of a clutch, or that of what cools it.
macro_rules! heat {
    ($clutch:literal) => {
        &[
            concat!($clutch, ".temperature_start"),
            concat!($clutch, ".thermal.ambient"),
            concat!($clutch, ".thermal.capacity"),
        ]
    };
}

/// Names of variables.
pub(super) type Names = &'static [&'static str];

/// Nothing: always the same.
pub(super) const NOTHING: Names = &[];
/// ω_e.
pub(super) const ENGINE: Names = &["engine.speed_start"];
/// ω_w, ω_o.
pub(super) const WHEELS: Names = &["vehicle.speed_start", "wheel.radius"];
/// Jerk: 0 but for rounding of V.
pub(super) const JERK: Names = &["vehicle.speed_start", "wheel.radius", "vehicle.jerkTime"];
/// ω_c1, ω_c2.
pub(super) const SHAFTS: [Names; 2] = [turned!(; "shaft1"), turned!(; "shaft2")];
/// ω_d: that of the engine, or of a shaft that it differs from by rounding only.
pub(super) const DAMPER: Names = turned!("engine.speed_start"; "shaft1", "shaft2");
/// Temperatures of the clutches.
pub(super) const HEAT: [Names; 2] = [heat!("clutch1"), heat!("clutch2")];

/// Rows of the start.
pub(super) const ROWS: [Variable<Plant>; 3] = [
    Variable::parameter(
        "vehicle.jerkTime",
        U::SECOND,
        |m: &mut Plant| &mut m.jerk_time,
        "tau of the two low-passes of filtered acceleration and jerk; 0.016 s is 10 Hz",
    )
    .min(1e-4),
    Variable::parameter(
        "engine.speed_start",
        U::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.engine_speed_start,
        "Engine speed at the start",
    ),
    Variable::parameter(
        "vehicle.speed_start",
        U::METRE_PER_SECOND,
        |m: &mut Plant| &mut m.vehicle_speed_start,
        "Vehicle speed at the start",
    ),
];
