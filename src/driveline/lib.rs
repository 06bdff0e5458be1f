#![no_std]
#![forbid(unsafe_code)]
//! Driveline of a vehicle with dual-clutch transmission (DCT): the mathematics of one paper.

pub mod clutch;
pub mod params;

pub use clutch::ForceMap;
pub use params::Params;
