//! What all files of an .ssp share: elements by name whatever their namespace, numbers, units, places of errors.

use crate::error::Error;
use crate::unit::{BASES, Unit};
use std::path::Path;

/// An element.
pub type Node<'d> = roxmltree::Node<'d, 'd>;

/// Name of an element without its namespace; SSP 1.0 and 2.0 share them anyway.
pub fn tag<'d>(node: Node<'d>) -> &'d str {
    node.tag_name().name()
}

/// The elements inside one.
pub fn elements<'d>(node: Node<'d>) -> impl Iterator<Item = Node<'d>> {
    node.children().filter(Node::is_element)
}

/// The first element of a name inside one.
pub fn one<'d>(node: Node<'d>, name: &str) -> Option<Node<'d>> {
    elements(node).find(|node| tag(*node) == name)
}

/// The elements of a name inside a group inside one.
pub fn every<'d>(node: Node<'d>, group: &str, name: &'static str) -> Vec<Node<'d>> {
    let all = one(node, group).into_iter().flat_map(elements);
    all.filter(|node| tag(*node) == name).collect()
}

/// An attribute, empty where there is none.
pub fn text<'d>(node: Node<'d>, name: &str) -> &'d str {
    node.attribute(name).unwrap_or_default()
}

/// An attribute that is a number, or this one where there is none.
pub fn number(file: &Path, node: Node<'_>, name: &str, otherwise: f64) -> Result<f64, Error> {
    let Some(text) = node.attribute(name) else {
        return Ok(otherwise);
    };
    real(text).ok_or_else(|| at(file, node, format!("{name} = '{text}' is no number")))
}

/// A number as XML has it.
pub fn real(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}

/// What is wrong at an element of a file.
pub fn at(file: &Path, node: Node<'_>, what: impl Into<String>) -> Error {
    let row = node.document().text_pos_at(node.range().start).row;
    Error::Content {
        path: file.to_owned(),
        line: usize::try_from(row).unwrap_or_default(),
        what: what.into(),
    }
}

/// A unit that a file defines; without a BaseUnit it measures nothing.
pub fn unit(file: &Path, node: Node<'_>) -> Result<Unit, Error> {
    let mut unit = Unit::named(text(node, "name"), [0; 8]);
    let Some(base) = one(node, "BaseUnit") else {
        return Ok(unit);
    };
    for (name, exponent) in BASES.iter().zip(&mut unit.exponents) {
        let text = base.attribute(*name).unwrap_or("0");
        let wrong = || at(file, base, format!("{name} = '{text}' is no whole number"));
        *exponent = text.trim().parse().map_err(|_| wrong())?;
    }
    unit.factor = number(file, base, "factor", 1.0)?;
    unit.offset = number(file, base, "offset", 0.0)?;
    Ok(unit)
}

/// Reads an XML document; one with a document type is refused: entities expand without end.
pub fn parsed<'d>(file: &Path, text: &'d str) -> Result<roxmltree::Document<'d>, Error> {
    roxmltree::Document::parse(text).map_err(|error| {
        let (told, place) = (error.to_string(), error.pos());
        let what = told.strip_suffix(&format!(" at {place}"));
        Error::Content {
            path: file.to_owned(),
            line: usize::try_from(place.row).unwrap_or_default(),
            what: what.unwrap_or(&told).to_owned(),
        }
    })
}
