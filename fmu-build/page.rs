//! `documentation/index.html` of an FMU: what the model is and its variables, for importers that
//! show it beside the model.

use crate::Result;
use crate::table::{COLUMNS, LEGEND, rows};
use fmi2_cosim::Model;
use quick_xml::escape::escape;

const STYLE: &str = "body{font:14px sans-serif;margin:2em}table{border-collapse:collapse}\
    td,th{border-bottom:1px solid #ccc;padding:.2em .6em;text-align:left}";

/// The page of model `M`.
pub(crate) fn page<M: Model>() -> Result<String> {
    let mut body = row("th", &COLUMNS);
    for cells in rows::<M>()? {
        body.push_str(&row("td", &cells));
    }
    let (name, sentence) = (escape(M::NAME), escape(M::DESCRIPTION));
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <title>{name}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{name}</h1>\n<p>{sentence}</p>\n<p>{LEGEND}</p>\n\
         <table>\n{body}</table>\n</body>\n</html>\n"
    ))
}

fn row(tag: &str, cells: &[impl AsRef<str>]) -> String {
    let cells = cells
        .iter()
        .map(|cell| format!("<{tag}>{}</{tag}>", escape(cell.as_ref())));
    format!("<tr>{}</tr>\n", cells.collect::<String>())
}
