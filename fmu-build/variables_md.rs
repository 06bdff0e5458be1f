//! A section of `VARIABLES.md`: the table of a model for people.

use crate::Result;
use crate::table::{COLUMNS, rows};
use fmi2_cosim::Model;

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
