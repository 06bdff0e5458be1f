//! A compiled master for FMI 2.0 co-simulation FMUs, on the [`fmi`] crate.
//!
//! It knows FMUs as files and names only, and couples them as `dct-harness` does, to the last bit:
//!
//! ```text
//! system.toml ──> System ──> Plan ──> Run ──> rows
//!                    ^                 │
//!   scenario.csv ────┘     world (one vector of f64) ──> inputs of FMU 1 ──step──> outputs ──┐
//!                            ^                                                            │
//!                            └─────────────── FMU 2, FMU 3, … in the given order <────────┘
//! ```
//!
//! An input takes what a `connections` entry of the file says, else the equal-named output of another FMU, else the
//! scenario's signal of that name, unless a start value was given for it, which then stays
//! (`wiring`). Within a step the FMUs run one after the other on the newest values (Gauss-Seidel),
//! or all on those of the step's beginning (Jacobi). Inputs hold within a step, or have `slopes` where
//! an FMU can follow them; a step that an FMU discards is divided (`discard`); a supplier's FMU may
//! stand under other names, units and codings (`mapped`). Time is counted in whole steps: the
//! communication point k is `k * step`, never a sum.
//!
//! Independent runs share nothing but the unpacked FMU files: [`run_all`] gives them to threads.
//!
//! A [`Watch`] looks at runs while they are made, and ends them at a communication point. [`Live`] tells of one run
//! that does not get there, since an FMU does not return.
//!
//! Rows are recorded as they are made, one after the other: a column of 30,000 rows would be
//! written with one cache line per value.
//!
//! FMUs run inside this process. `dct-harness` starts one process more around those that this
//! project did not build.
//!
//! # The `fmi` crate 0.8
//!
//! What had to be worked around, so that the next reader need not find it again:
//! - its build runs bindgen (libclang) and a C compiler; hence this workspace of its own. The PyPI
//!   package libclang has no C headers of its own: `BINDGEN_EXTRA_CLANG_ARGS` points it at the
//!   compiler's (`-I$(cc -print-file-name=include)`);
//! - [`fmi::fmi2::import::Fmi2Import`] owns the unpacked FMU and removes it when dropped, while an
//!   instance does not borrow it: an instance here keeps its [`Library`] and is dropped first;
//! - its safe instance hides the component, and with it input and output derivatives; its logger
//!   drops the category of a message, reads a null one, and panics at a status Pending: `cosim_raw`
//!   calls its raw binding instead;
//! - its description of an Enumeration has no items, and one of a Real no unit, minimum or
//!   maximum: [`description`] reads the file itself;
//! - `import::from_path` unpacks everything: `package` unpacks what a run needs.

mod beside;
mod contract;
pub mod csv;
mod derivatives;
pub mod description;
mod discard;
mod error;
mod fmu;
mod gather;
mod given;
pub mod known_units;
mod library;
mod linker;
mod live;
mod mapped;
mod mapping;
mod names;
mod noise;
mod outcome;
mod package;
mod parallel;
mod part;
pub mod plan;
mod recorder;
mod rest;
mod run;
mod scenario;
mod signals;
mod slopes;
mod ssp;
mod ssv;
mod start;
mod suggest;
mod supplier;
mod system;
mod system_file;
pub mod unit;
mod watch;
mod wiring;
mod world;

pub use beside::Measured;
pub use cosim_raw::Message;
pub use error::{Error, Seconds};
pub use library::{Libraries, Library};
pub use live::Live;
pub use mapping::Mapping;
pub use noise::Noise;
pub use outcome::{Outcome, Told};
pub use parallel::{Job, Made, run_all, run_into, run_seen};
pub use plan::Plan;
pub use run::Run;
pub use scenario::Scenario;
pub use system::System;
pub use watch::Watch;
