//! A compiled master for FMI 2.0 co-simulation FMUs, on the [`fmi`] crate.
//!
//! It knows FMUs as files and names only, and couples them as `dct-harness` does:
//!
//! ```text
//! scenario CSV ──> world (one vector of f64) ──> inputs of FMU 1 ──step──> outputs ──┐
//!                    ^                                                            │
//!                    └─────────────── FMU 2, FMU 3, … in the given order <────────┘
//! ```
//!
//! An input takes the equal-named output of another FMU, else the scenario's signal of that name,
//! unless a start value was given for it, which then stays; where plant and observer both give a name,
//! the control reads the estimate. Within a step the FMUs run one after
//! the other on the newest values (Gauss-Seidel). Time is counted in whole steps: the
//! communication point k is `k * step`, never a sum.
//!
//! # The `fmi` crate 0.8
//!
//! What had to be worked around, so that the next reader need not find it again:
//! - its build runs bindgen (libclang) and a C compiler; hence this workspace of its own. The PyPI
//!   package libclang has no C headers of its own: `BINDGEN_EXTRA_CLANG_ARGS` points it at the
//!   compiler's (`-I$(cc -print-file-name=include)`);
//! - [`fmi::fmi2::import::Fmi2Import`] owns the unpacked FMU and removes it when dropped, while an
//!   instance does not borrow it: [`Fmu`] keeps both and drops the instance first;
//! - dropping an instance frees but does not terminate it: [`Fmu`] calls `fmi2Terminate`;
//! - `enter_initialization_mode` exists in two traits with different arguments; calls name the one
//!   they mean;
//! - `get_integer`, `get_boolean` and their setters do not compare the lengths of their slices;
//!   `signals` keeps references and values side by side;
//! - its description of an Enumeration has no content, and one of a Real no unit, minimum or
//!   maximum: enough to connect by name and type, not to convert units;
//! - its logger drops `fmi2Discard` to trace level and reads a null category: logging stays off.

mod component;
mod error;
mod master;
mod scenario;
mod signals;

pub use component::{Component, Fmu, Value};
pub use error::Error;
pub use master::Master;
pub use scenario::Scenario;
