//! Units that are known by name: for FMUs that state no BaseUnit, and for `unit = "…"` in a mapping.
//!
//! The list of `dct-harness`; a test holds them together, to the last bit.

use crate::unit::Unit;
use std::f64::consts::PI;

const TURN: f64 = 2.0 * PI; // rad
const MINUTE: f64 = 60.0; // s
const HOUR: f64 = 3600.0; // s
const ZERO_CELSIUS: f64 = 273.15; // K

/// Exponents of kg, m, s, A, K, mol, cd, rad.
type Exponents = [i32; 8];

const fn mechanical(kg: i32, m: i32, s: i32, rad: i32) -> Exponents {
    [kg, m, s, 0, 0, 0, 0, rad]
}

const fn thermal(kg: i32, m: i32, s: i32, kelvin: i32) -> Exponents {
    [kg, m, s, 0, kelvin, 0, 0, 0]
}

const NUMBER: Exponents = mechanical(0, 0, 0, 0);
const TIME: Exponents = mechanical(0, 0, 1, 0);
const LENGTH: Exponents = mechanical(0, 1, 0, 0);
const AREA: Exponents = mechanical(0, 2, 0, 0);
const ANGLE: Exponents = mechanical(0, 0, 0, 1);
const TURNING: Exponents = mechanical(0, 0, -1, 1);
const SPEED: Exponents = mechanical(0, 1, -1, 0);
const ACCELERATION: Exponents = mechanical(0, 1, -2, 0);
const MASS: Exponents = mechanical(1, 0, 0, 0);
const FORCE: Exponents = mechanical(1, 1, -2, 0);
const TORQUE: Exponents = mechanical(1, 2, -2, 0);
const STIFFNESS: Exponents = mechanical(1, 2, -2, -1);
const PRESSURE: Exponents = mechanical(1, -1, -2, 0);
const POWER: Exponents = mechanical(1, 2, -3, 0);
const TEMPERATURE: Exponents = thermal(0, 0, 0, 1);

/// Name, exponents, factor to SI.
const KNOWN: [(&str, Exponents, f64); 59] = [
    ("1", NUMBER, 1.0),
    ("-", NUMBER, 1.0),
    ("%", NUMBER, 0.01),
    ("s", TIME, 1.0),
    ("ms", TIME, 1e-3),
    ("m", LENGTH, 1.0),
    ("mm", LENGTH, 1e-3),
    ("cm", LENGTH, 1e-2),
    ("m2", AREA, 1.0),
    ("mm2", AREA, 1e-6),
    ("cm2", AREA, 1e-4),
    ("rad", ANGLE, 1.0),
    ("deg", ANGLE, PI / 180.0),
    ("rad/s", TURNING, 1.0),
    ("rpm", TURNING, TURN / MINUTE),
    ("1/min", TURNING, TURN / MINUTE),
    ("r/min", TURNING, TURN / MINUTE),
    ("rev/min", TURNING, TURN / MINUTE),
    ("rev/s", TURNING, TURN),
    ("deg/s", TURNING, PI / 180.0),
    ("m/s", SPEED, 1.0),
    ("km/h", SPEED, 1e3 / HOUR),
    ("kph", SPEED, 1e3 / HOUR),
    ("kmph", SPEED, 1e3 / HOUR),
    ("m/s2", ACCELERATION, 1.0),
    ("m/s^2", ACCELERATION, 1.0),
    ("m/s3", mechanical(0, 1, -3, 0), 1.0),
    ("kg", MASS, 1.0),
    ("t", MASS, 1e3),
    ("kg.m2", mechanical(1, 2, 0, 0), 1.0),
    ("N", FORCE, 1.0),
    ("kN", FORCE, 1e3),
    ("N.m", TORQUE, 1.0),
    ("Nm", TORQUE, 1.0),
    ("N*m", TORQUE, 1.0),
    ("kN.m", TORQUE, 1e3),
    ("kNm", TORQUE, 1e3),
    ("N/m", mechanical(1, 0, -2, 0), 1.0),
    ("N/mm", mechanical(1, 0, -2, 0), 1e3),
    ("1/s", mechanical(0, 0, -1, 0), 1.0),
    ("N.m/rad", STIFFNESS, 1.0),
    ("kN.m/rad", STIFFNESS, 1e3),
    ("N.m.s/rad", mechanical(1, 2, -1, -1), 1.0),
    ("Pa", PRESSURE, 1.0),
    ("kPa", PRESSURE, 1e3),
    ("MPa", PRESSURE, 1e6),
    ("bar", PRESSURE, 1e5),
    ("J", TORQUE, 1.0),
    ("kJ", TORQUE, 1e3),
    ("W", POWER, 1.0),
    ("kW", POWER, 1e3),
    ("K", TEMPERATURE, 1.0),
    ("degC", TEMPERATURE, 1.0),
    ("°C", TEMPERATURE, 1.0),
    ("kg/m3", mechanical(1, -3, 0, 0), 1.0),
    ("m3", mechanical(0, 3, 0, 0), 1.0),
    ("m3/J", mechanical(-1, 1, 2, 0), 1.0),
    ("J/K", thermal(1, 2, -2, -1), 1.0),
    ("W/K", thermal(1, 2, -3, -1), 1.0),
];

/// Other spellings.
const SPELLINGS: [(&str, &str); 8] = [
    ("", "1"),
    ("U/min", "rpm"),
    ("min^-1", "rpm"),
    ("°", "deg"),
    ("kmh", "km/h"),
    ("N·m", "N.m"),
    ("N m", "N.m"),
    ("m/s²", "m/s2"),
];

/// A unit by its name or another spelling of it.
pub fn find(name: &str) -> Option<Unit> {
    let other = SPELLINGS.iter().find(|(spelling, _)| *spelling == name);
    let name = other.map_or(name, |(_, name)| name);
    let known = KNOWN.iter().find(|(known, ..)| *known == name);
    known.map(|(name, exponents, factor)| Unit {
        name: (*name).to_owned(),
        exponents: *exponents,
        factor: *factor,
        offset: match *name {
            "degC" | "°C" => ZERO_CELSIUS,
            _ => 0.0,
        },
    })
}

/// All names, other spellings last.
pub fn names() -> impl Iterator<Item = &'static str> {
    let spellings = SPELLINGS.iter().map(|(spelling, _)| *spelling);
    KNOWN.iter().map(|(name, ..)| *name).chain(spellings)
}
