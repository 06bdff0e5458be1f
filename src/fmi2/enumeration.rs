//! Types whose values have names.

/// An enumeration type of the model description; variables of it are an `i32` in the model.
///
/// ```
/// use fmi2_cosim::{Enumeration, Item, Variable};
///
/// const MODE: Enumeration = Enumeration {
///     name: "Mode",
///     description: "What the heater does",
///     items: &[
///         Item { name: "off", value: 1, description: "Nothing" },
///         Item { name: "heating", value: 2, description: "Full power" },
///     ],
/// };
///
/// fmi2_cosim::variables! {
///     struct Heater {
///         wanted: enumeration_input("mode", &MODE, "What it is to do") = 1,
///     }
/// }
/// # assert_eq!((Heater::default().wanted, Heater::TABLE[0].name), (1, "mode"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Enumeration {
    /// Type name, e.g. `ValveState`.
    pub name: &'static str,
    /// What it tells.
    pub description: &'static str,
    /// Its values; unique, ascending.
    pub items: &'static [Item],
}

/// One value of an [`Enumeration`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Item {
    /// Name, e.g. `opening`.
    pub name: &'static str,
    /// Value at the ABI.
    pub value: i32,
    /// What it means.
    pub description: &'static str,
}
