//! What happens to a value on its way: a line, or a table.

use super::xml::{Node, elements, number, tag, text};
use crate::error::Error;
use std::path::Path;

/// target = factor * source + offset, or `table`: source, target.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    pub factor: f64,
    pub offset: f64,
    pub table: Vec<(f64, f64)>,
}

impl Change {
    /// Leaves a value as it is.
    pub const NONE: Self = Self::line((1.0, 0.0));

    /// Factor and offset.
    pub const fn line((factor, offset): (f64, f64)) -> Self {
        let table = vec![];
        Self {
            factor,
            offset,
            table,
        }
    }

    fn table(rows: impl IntoIterator<Item = Result<(f64, f64), Error>>) -> Result<Self, Error> {
        let mut table: Vec<(f64, f64)> = vec![];
        for row in rows {
            let (source, target) = row?;
            match table.iter_mut().find(|(known, _)| *known == source) {
                Some((_, known)) => *known = target,
                None => table.push((source, target)),
            }
        }
        Ok(Self {
            table,
            ..Self::NONE
        })
    }

    /// Whether it does anything.
    pub fn changes(&self) -> bool {
        !self.table.is_empty() || (self.factor, self.offset) != (1.0, 0.0)
    }

    /// This change followed by another one; the error says why that cannot be.
    pub fn then(self, other: Self) -> Result<Self, String> {
        if !self.table.is_empty() {
            let rows = self.table.iter().map(|(k, v)| Ok((*k, other.at(*v)?)));
            let table = rows.collect::<Result<_, String>>()?;
            return Ok(Self {
                table,
                ..Self::NONE
            });
        }
        match (other.table.is_empty(), self.changes()) {
            (true, false) => Ok(other),
            (true, true) => Ok(Self::line((
                other.factor * self.factor,
                other.factor * self.offset + other.offset,
            ))),
            (false, false) => Ok(other),
            (false, true) => Err("a table cannot follow a factor or an offset".into()),
        }
    }

    /// The target's value for one of the source's.
    pub fn at(&self, value: f64) -> Result<f64, String> {
        if self.table.is_empty() {
            return Ok(self.factor * value + self.offset);
        }
        let row = self.table.iter().find(|(source, _)| *source == value);
        row.map(|(_, target)| *target)
            .ok_or_else(|| format!("{value} is in no row of a table"))
    }
}

/// Makes a number of a table's word, which stands in this element.
pub type Cell<'c> = dyn Fn(Node<'_>, &str) -> Result<f64, Error> + 'c;

/// The change that stands in a connection or a mapping entry; `cells` are of its source and its target.
pub fn told(file: &Path, node: Node<'_>, cells: [&Cell<'_>; 2]) -> Result<Change, Error> {
    for child in elements(node) {
        if tag(child) == "LinearTransformation" {
            let factor = number(file, child, "factor", 1.0)?;
            return Ok(Change::line((factor, number(file, child, "offset", 0.0)?)));
        }
        if tag(child).ends_with("MappingTransformation") {
            let rows = elements(child).filter(|row| tag(*row) == "MapEntry");
            let [source, target] = cells;
            return Change::table(rows.map(|row| {
                let from = source(row, text(row, "source"))?;
                Ok((from, target(row, text(row, "target"))?))
            }));
        }
    }
    Ok(Change::NONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[(f64, f64)]) -> Change {
        Change::table(rows.iter().copied().map(Ok)).unwrap()
    }

    #[test]
    fn changes_add_up_in_their_order() {
        let (double, shifted) = (Change::line((2.0, 0.0)), Change::line((1.0, 3.0)));
        let codes = table(&[(1.0, 10.0), (2.0, 20.0), (1.0, 30.0)]);
        assert_eq!(codes.table, [(1.0, 30.0), (2.0, 20.0)]);
        for (first, second, at, expected) in [
            (double.clone(), shifted.clone(), 5.0, Some(13.0)),
            (shifted.clone(), double.clone(), 5.0, Some(16.0)),
            (Change::NONE, codes.clone(), 2.0, Some(20.0)),
            (codes.clone(), double.clone(), 1.0, Some(60.0)),
            (codes.clone(), codes.clone(), 1.0, None),
            (double, codes, 1.0, None),
        ] {
            let found = first.then(second).and_then(|change| change.at(at)).ok();
            assert_eq!(found, expected);
        }
    }
}
