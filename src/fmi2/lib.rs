//! An FMI 2.0 co-simulation shell for any model.
//!
//! A model is a plain struct with [`Model`] implemented: a table of rows that point at its fields,
//! an `initialize` and a `step`. Everything an importer sees is derived from that table: value
//! references, getters, setters and what may be set when, the model description, the GUID.
//!
//! ```text
//! importer ──C ABI──> ffi (34 functions) ──> Instance<M> (life cycle, checks) ──> M: Model
//! ```

pub mod model;
pub mod unit;
pub mod variable;

pub use model::{Category, Experiment, Failure, Log, Model, StateFields};
pub use unit::{DisplayUnit, Unit};
pub use variable::{Access, Causality, Enumeration, Initial, Item, Variability, Variable};
