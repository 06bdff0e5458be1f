//! Encoders whose ticks the speeds are counted by.

use crate::observer::Observer;
use fmi2_cosim::{Unit as U, Variable};

const fn ticks(
    name: &'static str,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::parameter(name, U::ONE, field, description).min(0.0)
}

/// Ticks per revolution.
pub(super) const TICKS: [Variable<Observer>; 4] = [
    ticks(
        "engine.encoderTicks",
        |m| &mut m.settings.encoder[0],
        "Ticks per revolution that engine.speed is counted by over a step; 0: not counted, or recognised",
    ),
    ticks(
        "clutch1.encoderTicks",
        |m| &mut m.settings.encoder[1],
        "Ticks per revolution that clutch1.speed is counted by over a step; 0: not counted, or recognised",
    ),
    ticks(
        "clutch2.encoderTicks",
        |m| &mut m.settings.encoder[2],
        "Ticks per revolution that clutch2.speed is counted by over a step; 0: not counted, or recognised",
    ),
    ticks(
        "wheel.encoderTicks",
        |m| &mut m.settings.encoder[3],
        "Ticks per revolution that wheel.speed is counted by over a step; 0: not counted, or recognised",
    ),
];
