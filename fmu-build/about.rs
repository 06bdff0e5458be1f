//! What the table of variables cannot tell about a model: the prose of its documentation page.

/// Prose of a documentation page. Sentences know `` `code` ``, `**strong**` and `$formula$`.
///
/// ```
/// use fmu_build::about::{About, Equation};
///
/// const OVEN: About = About {
///     purpose: &["Warms a body with power $P$."],
///     equations: &[Equation {
///         number: "(1)",
///         formula: "C T' = P - G (T - T_room)",
///         meaning: "heat balance",
///     }],
///     validity: &["One temperature: the body conducts far better than its surface."],
/// };
/// # assert_eq!(OVEN.equations.len(), 1);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct About {
    /// What it is for: paragraphs.
    pub purpose: &'static [&'static str],
    /// What it computes.
    pub equations: &'static [Equation],
    /// Where it holds and where it does not: one point each.
    pub validity: &'static [&'static str],
}

impl About {
    /// Nothing: the page shows the tables alone.
    pub const NOTHING: Self = Self {
        purpose: &[],
        equations: &[],
        validity: &[],
    };
}

/// An equation of a documentation page.
///
/// Its formula is plain ASCII: `omega_c1` is ω with the index c1, `J_ct2_eq` has the index "ct2,eq", `x'` is a time
/// derivative, `x_hat` an estimate, `x_err` its error, `x^2` a power, `{a}/{b}` a fraction, `<=` is ≤.
#[derive(Debug, Clone, Copy)]
pub struct Equation {
    /// Its number where it comes from, e.g. `(11)`; may be empty.
    pub number: &'static str,
    /// The formula.
    pub formula: &'static str,
    /// What it says: a few words.
    pub meaning: &'static str,
}
