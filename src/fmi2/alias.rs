//! Further names for the value of a row.

use crate::Causality;

/// Another name for the value of a row: a variable of its own in the model description, with the row's value
/// reference, type, unit and limits. A library knows nothing of it.
///
/// ```
/// use fmi2_cosim::{Alias, Unit};
///
/// fmi2_cosim::variables! {
///     /// A wall.
///     pub struct Wall {
///         loss: output("wall.heatFlow", Unit::WATT, "What comes through the wall")
///             .depends_on(&[])
///             .aliases(&[Alias::output("room.heatFlow", "What the room gets")]) = 0.0,
///     }
/// }
///
/// assert_eq!(Wall::TABLE[0].aliases[0].name, "room.heatFlow");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alias {
    /// Structured name, as that of a row.
    pub name: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// Output or local: of all names of a value, importers may set one (FMI 2.0.4, 2.2.7), that of the row.
    pub causality: Causality,
}

impl Alias {
    /// A name that other models connect to; only an output has such ones.
    #[must_use]
    pub const fn output(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            causality: Causality::Output,
        }
    }

    /// A name that people read, of any row.
    #[must_use]
    pub const fn local(name: &'static str, description: &'static str) -> Self {
        Self {
            name,
            description,
            causality: Causality::Local,
        }
    }
}
