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
pub mod observer;
pub mod params;
pub mod plant;
mod plant_block;
mod plant_brake;
mod plant_empty;
mod plant_friction;
mod plant_gear;
pub mod plant_matrices;
pub mod plant_mesh;
pub mod plant_modes;
mod plant_outputs;
mod plant_ports;
mod plant_quiet;
mod plant_rows;
mod plant_springs;
mod plant_tangent;
mod presets;
pub mod reduced;
mod rung;
mod rung_builder;
mod rung_loss;
mod rung_start;
mod rung_watch;
mod shaft;
pub mod thermal;

pub use clutch::ForceMap;
pub use params::Params;
