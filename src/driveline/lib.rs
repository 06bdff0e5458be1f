#![no_std]
#![forbid(unsafe_code)]
//! Driveline of a vehicle with dual-clutch transmission (DCT): the mathematics of one paper.

pub mod clutch;
pub mod control;
pub mod coupling;
pub mod friction;
pub mod identify;
pub mod integrate;
pub mod jerk;
mod kept;
pub mod matrices;
pub mod observer;
pub mod params;
pub mod plant;
mod presets;
mod presets_fade;
pub mod reduced;
mod road;
mod rung;
mod tanh;
pub mod thermal;

pub use clutch::ForceMap;
pub use params::Params;
