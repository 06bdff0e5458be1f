//! `VARIABLES.md`: the tables of all models for people, one section each.

use crate::table::{COLUMNS, LEGEND, rows};
use crate::{Entry, Result};
use fmi2_cosim::Model;

/// The text of `VARIABLES.md`.
///
/// # Errors
/// When a start value is not finite.
pub(crate) fn text(models: &[Entry]) -> Result<String> {
    let mut text = format!(
        "# Variables of the FMUs\n\n\
         Written by `cargo fmu describe` from the tables in `src/models`; do not edit.\n\n\
         {LEGEND}\n"
    );
    for entry in models {
        text.push('\n');
        text.push_str(&(entry.table)()?);
    }
    Ok(text)
}

/// The section of model `M`: a heading, its sentence and one row per variable.
pub(crate) fn section<M: Model>() -> Result<String> {
    let mut text = format!("## {}\n\n{}\n\n", M::NAME, M::DESCRIPTION);
    text.push_str(&line(&COLUMNS));
    text.push_str(&line(&["---"; COLUMNS.len()]));
    for row in rows::<M>()? {
        text.push_str(&line(&row));
    }
    Ok(text)
}

fn line(cells: &[impl AsRef<str>]) -> String {
    let cells: Vec<_> = cells
        .iter()
        .map(|cell| cell.as_ref().replace('|', "\\|"))
        .collect();
    format!("| {} |\n", cells.join(" | "))
}
