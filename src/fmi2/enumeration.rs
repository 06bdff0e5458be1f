//! Types whose values have names.

/// An enumeration type of the model description.
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
