//! The tables of a documentation page.

use super::{formula, text};
use crate::about::Equation;
use crate::table::{COLUMNS, Sheet};
use crate::{Entry, Result};
use quick_xml::escape::escape;

/// A table of HTML cells.
pub(super) struct Table {
    class: &'static str,
    columns: Vec<&'static str>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Its element; nothing when it has no row. The first cell of a row without columns is its heading.
    pub(super) fn html(&self) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        let cells = |tag: &str, cells: &[String]| {
            let cell = |cell: &String| match cell.parse::<f64>() {
                Ok(_) => format!("<{tag} class=\"number\">{cell}</{tag}>"),
                Err(_) => format!("<{tag}>{cell}</{tag}>"),
            };
            cells.iter().map(cell).collect::<String>()
        };
        let columns: Vec<String> = self.columns.iter().map(|name| (*name).to_owned()).collect();
        let head = match columns.is_empty() {
            true => String::new(),
            false => format!("<thead><tr>{}</tr></thead>\n", cells("th", &columns)),
        };
        let row = |row: &Vec<String>| match (self.columns.is_empty(), row.as_slice()) {
            (true, [first, rest @ ..]) => {
                format!("<tr><th>{first}</th>{}</tr>\n", cells("td", rest))
            }
            (_, all) => format!("<tr>{}</tr>\n", cells("td", all)),
        };
        let rows: String = self.rows.iter().map(row).collect();
        format!(
            "<div class=\"wide\"><table class=\"{}\">\n{head}<tbody>\n{rows}</tbody></table></div>\n",
            self.class
        )
    }
}

fn plain(cell: &str) -> String {
    escape(cell).into_owned()
}

fn code(name: &str) -> String {
    format!("<code>{}</code>", escape(name))
}

/// What the FMU is, before anything is explained.
pub(super) fn facts(sheet: &Sheet) -> Table {
    let [start, stop, step] = &sheet.experiment;
    let count = |causality: &str| sheet.of(causality).count();
    let facts = [
        ("Kind", "FMI 2.0, co-simulation".to_owned()),
        ("Version", plain(sheet.version)),
        ("Licence", plain(sheet.license)),
        ("GUID", code(&sheet.guid)),
        (
            "Variables",
            format!(
                "{} inputs, {} outputs, {} parameters",
                count("input"),
                count("output"),
                count("parameter")
            ),
        ),
        (
            "Default experiment",
            format!("{start} s to {stop} s, communication step {step} s"),
        ),
        ("Offers", plain(&sheet.capabilities.join(", "))),
        ("Made by", plain(crate::description::GENERATION_TOOL)),
    ];
    let rows = facts.into_iter().filter(|(_, fact)| !fact.is_empty());
    Table {
        class: "facts",
        columns: Vec::new(),
        rows: rows.map(|(name, fact)| vec![name.into(), fact]).collect(),
    }
}

/// Columns of [`COLUMNS`] that tell something of the variables of a causality.
fn shown(causality: &str) -> &'static [&'static str] {
    match causality {
        "input" => &["name", "type", "start", "min", "max", "description", "vr"],
        "output" => &["name", "type", "depends on", "description", "vr"],
        "parameter" => &[
            "name",
            "type",
            "variability",
            "start",
            "min",
            "max",
            "description",
            "vr",
        ],
        _ => &["name", "type", "variability", "description", "vr"],
    }
}

/// The cell of a row in a column of [`COLUMNS`].
fn text_of<'a>(row: &'a [String; 10], column: &str) -> &'a str {
    let at = COLUMNS.iter().position(|name| *name == column);
    at.map_or("", |at| row[at].as_str())
}

/// The variables of a causality; the values of constants among what is computed have a column of their own.
pub(super) fn variables(sheet: &Sheet, causality: &str) -> Table {
    let mut columns = shown(causality).to_vec();
    let constants = sheet
        .of(causality)
        .any(|row| !text_of(row, "start").is_empty());
    if constants && !columns.contains(&"start") {
        columns.insert(2, "start");
    }
    let cell = |row: &[String; 10], column: &str| {
        let text = text_of(row, column);
        match column {
            "name" => code(text),
            // The values of an enumeration have a table of their own.
            "type" => plain(text.split(" {").next().unwrap_or(text)),
            _ => plain(text),
        }
    };
    let rows = sheet.of(causality);
    let rows = rows.map(|row| columns.iter().map(|column| cell(row, column)).collect());
    Table {
        class: "variables",
        rows: rows.collect(),
        columns: columns.clone(),
    }
}

/// Every value of every enumeration.
pub(super) fn enumerations(sheet: &Sheet) -> Table {
    let items = sheet.enumerations.iter().flat_map(|kind| {
        kind.items.iter().map(|item| {
            vec![
                code(kind.name),
                item.value.to_string(),
                code(item.name),
                plain(item.description),
            ]
        })
    });
    Table {
        class: "types",
        columns: vec!["type", "value", "name", "meaning"],
        rows: items.collect(),
    }
}

/// Bundles of ports.
pub(super) fn terminals(entry: &Entry) -> Table {
    let rows = entry
        .present_terminals()
        .into_iter()
        .map(|(terminal, members)| {
            vec![
                code(terminal.name),
                code(terminal.kind),
                plain(terminal.description),
                members.into_iter().map(code).collect::<Vec<_>>().join(", "),
            ]
        });
    Table {
        class: "terminals",
        columns: vec!["terminal", "kind", "what it bundles", "variables"],
        rows: rows.collect(),
    }
}

/// What was measured.
pub(super) fn figures(entry: &Entry) -> Result<String> {
    let Some(measure) = entry.figures else {
        return Ok(String::new());
    };
    let figures = measure()?;
    let table = Table {
        class: "figures",
        columns: figures.columns,
        rows: figures.rows,
    };
    Ok(format!(
        "<p>{}</p>\n{}",
        plain(&figures.caption),
        table.html()
    ))
}

/// Numbers, formulas, meanings.
pub(super) fn equations(equations: &[Equation]) -> String {
    let row = |one: &Equation| {
        vec![
            plain(one.number),
            formula::block(one.formula),
            text::inline(one.meaning),
        ]
    };
    let table = Table {
        class: "equations",
        columns: vec!["number", "equation", "meaning"],
        rows: equations.iter().map(row).collect(),
    };
    table.html()
}
