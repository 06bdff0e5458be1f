//! The GUID: a hash of the table and its start values, so that a library refuses a model
//! description that was written from another table.

use crate::hash::Hash;
use crate::{Access, Model, Variable};
use core::fmt::Write;

/// GUID of model `M`, as in `modelDescription.xml`: `{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}`.
#[must_use]
pub fn guid<M: Model>() -> String {
    text(table_hash::<M>()).map(char::from).iter().collect()
}

/// How a GUID is written; each x is a digit.
const LAYOUT: Text = *b"{xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx}";

/// The characters of a GUID.
pub(crate) type Text = [u8; 38];

/// The GUID that [`table_hash`] makes.
pub(crate) fn text(hash: u128) -> Text {
    let mut rest = hash;
    LAYOUT.map(|place| {
        if place != b'x' {
            return place;
        }
        rest = rest.rotate_left(4);
        let [digit, ..] = rest.to_le_bytes();
        match digit % 16 {
            digit @ 0..10 => b'0' + digit,
            digit => b'a' + digit - 10,
        }
    })
}

/// The GUID as a number.
pub(crate) fn table_hash<M: Model>() -> u128 {
    let mut hash = Hash::new();
    let mut model = M::default();
    hash.text(M::NAME);
    hash.text(M::DESCRIPTION);
    number(&mut hash, Some(M::EXPERIMENT.start));
    number(&mut hash, Some(M::EXPERIMENT.stop));
    number(&mut hash, Some(M::EXPERIMENT.step));
    for row in M::VARIABLES {
        add_row(&mut hash, row);
        add_start(&mut hash, row, &mut model);
    }
    hash.value()
}

fn add_row<M>(hash: &mut Hash, row: &Variable<M>) {
    hash.text(row.name);
    hash.text(row.description);
    debug(hash, &(row.causality, row.variability, row.unit));
    [row.min, row.max, row.nominal]
        .into_iter()
        .for_each(|limit| number(hash, limit));
    debug(hash, &(row.dependencies, row.initial_dependencies));
    debug(hash, &(row.rate.is_some(), row.slope.is_some()));
}

fn add_start<M>(hash: &mut Hash, row: &Variable<M>, model: &mut M) {
    match row.access {
        Access::Real(field) => debug(hash, &("Real", field(model).to_bits())),
        Access::Integer(field) => debug(hash, &("Integer", *field(model))),
        Access::Boolean(field) => debug(hash, &("Boolean", *field(model))),
        Access::Enumeration(field, kind) => debug(hash, &(kind, *field(model))),
    }
}

fn number(hash: &mut Hash, number: Option<f64>) {
    debug(hash, &number.map(f64::to_bits));
}

fn debug(hash: &mut Hash, value: &dyn core::fmt::Debug) {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write!(text, "{value:?}");
    hash.text(&text);
}
