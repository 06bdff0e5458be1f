#![no_std]
#![forbid(unsafe_code)]
//! Driveline of a vehicle with dual-clutch transmission (DCT), and observers of its torques: the mathematics of one
//! paper, "Control-oriented modeling and torque estimations for vehicle driveline with dual-clutch transmission", as
//! functions of (parameters, state, input).
//!
//! | what | where |
//! | --- | --- |
//! | the plant (1)-(11): stick-slip clutches, gears, brake, stepped exactly | [`plant`], [`integrate`], [`matrices`], [`coupling`] |
//! | its vehicle: Table 1 and four other presets | [`Params`], [`clutch`], [`friction`], [`thermal`] |
//! | the control-oriented model (12)-(16), and identification (17), (18) | [`reduced`], [`identify`] |
//! | five observers (19)-(31) of clutch and drive-shaft torques | [`observer`] |
//! | from a clutch torque asked for to a position, and the jerk of the vehicle | [`control`], [`jerk`] |
//!
//! A launch with clutch 1, and what an observer that sees production signals alone makes of its torques:
//!
//! ```
//! use dct_driveline::Params;
//! use dct_driveline::integrate::Propagators;
//! use dct_driveline::observer::{Kalman, Observer, Sample, Settings};
//! use dct_driveline::params::Actuation;
//! use dct_driveline::plant::{Input, InputRate, Output, Plant};
//!
//! let (p, settings, h) = (Params::TABLE_1, Settings::CASE_1, 1e-3);
//! let actuation = [6e-3, 0.0].map(|position| Actuation { position, ..Actuation::default() });
//! let force = [0, 1].map(|i| p.clutch[i].force(actuation[i]));
//! let input = Input { t_e: 60.0, force, gear: [1, 2], ..Input::default() };
//! let mut propagators = Propagators::new(&p, input.gear, h);
//! let mut plant = Plant::start(&p, &input, 150.0, 0.0);
//! let mut y = plant.outputs(&p, &propagators.systems, &input);
//!
//! let measured = |y: &Output| Sample {
//!     t_e: input.t_e,
//!     omega_e: y.omega_e,
//!     omega_c: y.omega_c,
//!     omega_w: y.omega_w,
//!     actuation,
//!     gear: input.gear,
//!     ..Sample::default()
//! };
//! let mut observer = Kalman::default();
//! let mut estimate = observer.start(&p, &settings, &measured(&y));
//! for _ in 0..400 {
//!     plant.step(&p, &mut propagators, &input, &InputRate::default());
//!     y = plant.outputs(&p, &propagators.systems, &input);
//!     estimate = observer.step(&p, &settings, &measured(&y), h);
//! }
//! assert!(estimate.valid);
//! assert!((estimate.t_c[0] / y.t_c[0] - 1.0).abs() < 0.01); // of 54 N·m, by a friction that it was told wrong
//! assert!((estimate.t_o / y.t_o - 1.0).abs() < 0.01);
//! ```
//!
//! # What holds everywhere
//!
//! - SI: rad, rad/s, N·m, s. A positive torque accelerates the vehicle forward; slip is engine side less gearbox side.
//!   Arrays of two hold the odd shaft with clutch 1, then the even shaft with clutch 2.
//! - No `std`, no allocation, no `unsafe`, no features to choose. [`nalgebra`] is the one dependency, with `libm` for sin,
//!   tanh and exp: the same input gives the same bits on every platform.
//! - No globals, no interior mutability: all types are `Copy` or at least `Clone`, `Send` and `Sync`. A copy of a state is a
//!   saved state.
//! - A communication step is > 0 and finite. All other numbers may be any: nothing panics and every call comes back. An observer
//!   refuses a sample that is not finite and says so ([`observer::Fault`]); elsewhere what makes no sense leads to results that
//!   make none, mostly NaN.
//! - Structs are plain data with public fields. Before 1.0 they may gain fields in a minor version: write `..` and a preset or
//!   `Default::default()`. A new variant of an enum is a breaking change, so that `match` may name them all.

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

#[cfg(test)]
mod tests {
    const fn is_plain<T: Copy + Send + Sync + 'static>() {}
    const fn is_shared<T: Clone + Send + Sync + 'static>() {}

    /// As the front page says; the compiler is the test.
    const _: () = {
        is_plain::<crate::Params>();
        is_plain::<crate::plant::Plant>();
        is_plain::<crate::plant::Output>();
        is_plain::<crate::observer::Selected>();
        is_plain::<crate::observer::Settings>();
        is_plain::<crate::control::Servo>();
        is_plain::<crate::jerk::JerkFilter>();
        is_plain::<crate::identify::LeastSquares>();
        is_shared::<crate::integrate::Propagators>();
    };
}
