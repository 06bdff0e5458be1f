//! An FMI 2.0 co-simulation shell for any model.
//!
//! A model is a plain struct with [`Model`] implemented: a table of rows that point at its fields,
//! an `initialize` and a `step`. Everything an importer sees is derived from that table: value
//! references, getters, setters and what may be set when, the model description, the GUID.
//!
//! ```text
//! importer ──C ABI──> ffi (34 functions) ──> Instance<M> (life cycle, checks) ──> M: Model
//! ```

#![deny(unsafe_code)]

mod check;
mod error;
mod export;
pub mod ffi;
mod guid;
mod hash;
mod instance;
mod logger;
pub mod model;
mod saved;
mod state;
pub mod unit;
mod value;
pub mod variable;

pub use check::check;
pub use error::{Error, Status};
pub use guid::guid;
pub use instance::{Instance, TIME_TOLERANCE};
pub use model::{Category, Experiment, Failure, Log, Model, StateFields};
pub use saved::Saved;
pub use state::{Call, State};
pub use unit::{DisplayUnit, Unit};
pub use value::Value;
pub use variable::{Access, Causality, Enumeration, Initial, Item, Variability, Variable};
