//! The models behind the FMUs: one table of rows each, pointing at fields of plain structs.
//!
//! ```text
//! DctPlant ──speeds──> DctObserver ──friction──> DctClutchControl ──positions──> DctPlant
//! ```
//!
//! Names that two FMUs share are written once, in [`ports`].

#![forbid(unsafe_code)]

mod clutch_control;
mod gears;
mod observer;
mod plant;
pub mod ports;
pub mod presets;
mod rows;
mod step;
mod vehicle;

pub use clutch_control::ClutchControl;
pub use observer::Observer;
pub use plant::Plant;
