#![doc = include_str!("README.md")]
#![deny(unsafe_code)]

mod alias;
mod check;
mod debug;
mod enumeration;
mod error;
mod export;
#[doc(hidden)] // what `export!` expands to; no part of the API
pub mod ffi;
mod guid;
mod handle;
mod hash;
mod instance;
mod logger;
mod model;
mod number;
mod reference;
mod request;
mod resources;
mod row;
mod saved;
mod state;
mod unit;
mod value;
mod variable;
mod variables;

pub use alias::Alias;
pub use check::check;
pub use enumeration::{Enumeration, Item};
pub use error::{Error, Status};
pub use guid::guid;
pub use instance::{Instance, TIME_TOLERANCE, provides_directional_derivatives};
pub use model::{Category, Experiment, Failure, Log, Model, StateFields};
pub use number::Seconds;
pub use reference::{Reference, Typed};
pub use resources::{LoadError, Resources};
pub use saved::Saved;
pub use state::{Call, State};
pub use unit::{DisplayUnit, Unit};
pub use value::Value;
pub use variable::{Access, Causality, Initial, Variability, Variable};

#[cfg(test)]
mod tests {
    #[test]
    fn the_readme_tells_the_compiler_that_the_manifest_asks_for() {
        let told = concat!("\nRust ", env!("CARGO_PKG_RUST_VERSION"), " or later;");
        assert!(include_str!("README.md").contains(told));
    }

    /// The second example of the README runs the model of the first one, which is also in this file.
    #[test]
    fn the_readme_shows_the_model_that_its_examples_run() {
        assert!(include_str!("README.md").contains(include_str!("doc/tank.rs")));
    }
}
