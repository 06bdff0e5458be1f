//! `documentation/index.html` of an FMU, for importers that show it beside the model.
//!
//! ```text
//! table of the model ──> facts, inputs, outputs, parameters, types ┐
//! About ──> purpose, equations (MathML), validity                  ├──> one file, no script, no network
//! terminals, CHANGELOG.md ──> terminals, changes                   ┘
//! ```

mod formula;
mod tables;
mod text;

use crate::about::About;
use crate::table::{LEGEND, Sheet};
use crate::{Entry, Error, Result};
use quick_xml::escape::escape;
use std::fmt::Write as _;
use std::fs;
use std::io::ErrorKind;

const STYLE: &str = include_str!("style.css");

const FOOT: &str = "<footer>\n<p>Licences of everything in the library: \
    <a href=\"licenses/license.txt\">licenses/license.txt</a>. What it needs of the machine: \
    <a href=\"externalDependencies.txt\">externalDependencies.txt</a>. Bill of materials: \
    <code>extra/org.cyclonedx/bom.cdx.json</code> of the FMU.</p>\n</footer>\n";

/// Something under a heading.
struct Section {
    id: &'static str,
    heading: &'static str,
    html: String,
}

/// The documentation page inside the FMU of an entry; sections without contents are left out. Its changes
/// are those of `CHANGELOG.md` in the folder that [`Entry::at`] named.
///
/// # Errors
/// When a number of the table is not finite, or the change log cannot be read.
pub(crate) fn page(entry: &Entry) -> Result<String> {
    let sheet = (entry.sheet)()?;
    let mut sections = sections(entry, &sheet)?;
    sections.retain(|section| !section.html.is_empty());
    let mut html = head(&sheet);
    html.push_str("<nav>");
    for Section { id, heading, .. } in &sections {
        let _ = write!(html, "<a href=\"#{id}\">{heading}</a>");
    }
    html.push_str("</nav>\n<main>\n");
    for Section {
        id,
        heading,
        html: body,
    } in &sections
    {
        let _ = write!(
            html,
            "<section id=\"{id}\">\n<h2>{heading}</h2>\n{body}</section>\n"
        );
    }
    Ok(html + "</main>\n" + FOOT + "</body>\n</html>\n")
}

fn head(sheet: &Sheet) -> String {
    let (name, sentence) = (escape(sheet.name), escape(sheet.description));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<div>\n<h1>{name}</h1>\n<p>{sentence}</p>\n</div>\n</header>\n"
    )
}

fn sections(entry: &Entry, sheet: &Sheet) -> Result<Vec<Section>> {
    let section = |id, heading, html| Section { id, heading, html };
    let variables = |causality| tables::variables(sheet, causality).html();
    let About {
        purpose,
        equations,
        validity,
    } = entry.about;
    Ok(vec![
        section("facts", "Facts", tables::facts(sheet).html()),
        section("purpose", "Purpose", list("p", purpose)),
        section("equations", "Equations", tables::equations(equations)),
        section("validity", "Validity", points(validity)),
        section("accuracy", "Accuracy", tables::figures(entry)?),
        section("inputs", "Inputs", legend(variables("input"))),
        section("outputs", "Outputs", variables("output")),
        section("parameters", "Parameters", variables("parameter")),
        section("locals", "Locals", variables("local")),
        section("types", "Types", tables::enumerations(sheet).html()),
        section("terminals", "Terminals", tables::terminals(entry).html()),
        section("files", "Parameter sets and experiment", files(entry)?),
        section("changes", "Changes", text::changes(&change_log(entry)?)),
    ])
}

fn legend(table: String) -> String {
    if table.is_empty() {
        return table;
    }
    format!("<p>{LEGEND}</p>\n{table}")
}

fn list(tag: &str, sentences: &[&str]) -> String {
    let each = |sentence: &&str| format!("<{tag}>{}</{tag}>\n", text::inline(sentence));
    sentences.iter().map(each).collect()
}

fn points(sentences: &[&str]) -> String {
    match list("li", sentences) {
        items if items.is_empty() => items,
        items => format!("<ul>\n{items}</ul>\n"),
    }
}

/// What lies beside the library for those who try it.
fn files(entry: &Entry) -> Result<String> {
    let mut items: Vec<String> = Vec::new();
    for set in (entry.sets)()? {
        items.push(format!("`{}.ssv`: {}", set.name, set.title));
    }
    if let Some(smoke) = &entry.smoke {
        items.push(format!("`smoke.exp`: {}", smoke.description));
    }
    if items.is_empty() {
        return Ok(String::new());
    }
    let list = points(&items.iter().map(String::as_str).collect::<Vec<_>>());
    Ok(format!(
        "<p>In <code>extra/org.fmi-standard.fmi-ls-ref</code> of the FMU; how to use them: \
         <a href=\"fmi-ls-ref.txt\">fmi-ls-ref.txt</a>.</p>\n{list}"
    ))
}

/// `CHANGELOG.md` in the folder of the entry; empty when there is none.
fn change_log(entry: &Entry) -> Result<String> {
    let path = entry.folder().join("CHANGELOG.md");
    match fs::read_to_string(&path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(Error::Io { path, source }),
        read => Ok(read.unwrap_or_default()),
    }
}
