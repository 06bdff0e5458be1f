//! A table of inputs over time, read from a CSV file.

use crate::{Error, Result};
use std::fs;
use std::path::Path;

/// Rows of numbers; the first column is the time [s].
pub(crate) struct Stimuli {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// One column with the times of its rows.
pub(crate) struct Column<'a> {
    pub(crate) name: &'a str,
    rows: &'a [Vec<f64>],
    index: usize,
}

impl Stimuli {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).map_err(Error::io(path))?;
        Self::parse(&text).map_err(|(line, what)| Error::Stimuli {
            path: path.into(),
            line,
            what,
        })
    }

    /// From the text of a CSV file; an error has its line.
    pub(crate) fn parse(text: &str) -> std::result::Result<Self, (usize, String)> {
        let mut lines = text.lines();
        let heading = lines.next().unwrap_or_default();
        let heading = heading.trim_start_matches('\u{feff}').split(',');
        let names: Vec<_> = heading
            .map(|name| name.trim().trim_matches('"').to_owned())
            .collect();
        if names[0] != "time" {
            let told = format!("the first column must be called time, not '{}'", names[0]);
            return Err((1, told));
        }
        if let Some(twice) = (1..names.len()).find(|at| names[..*at].contains(&names[*at])) {
            return Err((1, format!("column '{}' is there twice", names[twice])));
        }
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (line, text) in (2..).zip(lines).filter(|(_, text)| !text.trim().is_empty()) {
            let wrong = |what: String| (line, what);
            let numbers = text.split(',').map(|cell| number(cell.trim()));
            let row: Vec<f64> = numbers
                .collect::<std::result::Result<_, _>>()
                .map_err(wrong)?;
            if row.len() != names.len() {
                let (found, wanted) = (row.len(), names.len());
                return Err(wrong(format!(
                    "{found} numbers, the heading has {wanted} names"
                )));
            }
            if rows.last().is_some_and(|last| last[0] >= row[0]) {
                return Err(wrong(format!("the time {} s does not increase", row[0])));
            }
            rows.push(row);
        }
        if rows.is_empty() {
            return Err((2, "there is no row".into()));
        }
        Ok(Self { names, rows })
    }

    /// First and last time [s].
    pub(crate) fn times(&self) -> (f64, f64) {
        (self.rows[0][0], self.rows[self.rows.len() - 1][0])
    }

    /// Names of the columns after the time.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().skip(1).map(String::as_str)
    }

    pub(crate) fn column(&self, name: &str) -> Option<Column<'_>> {
        let index = self.names.iter().skip(1).position(|other| other == name)? + 1;
        Some(Column {
            name: &self.names[index],
            rows: &self.rows,
            index,
        })
    }
}

fn number(cell: &str) -> std::result::Result<f64, String> {
    match cell {
        "true" => Ok(1.0),
        "false" => Ok(0.0),
        other => {
            let finite = other.parse().ok().filter(|value: &f64| value.is_finite());
            finite.ok_or_else(|| format!("{other:?} is no finite number"))
        }
    }
}

impl Column<'_> {
    /// Index of the last row that is not later; the first one before all.
    fn row(&self, time: f64) -> usize {
        self.rows
            .partition_point(|row| row[0] <= time)
            .saturating_sub(1)
    }

    /// The value at a time, interpolated linearly.
    pub(crate) fn at(&self, time: f64) -> f64 {
        let here = self.row(time);
        let (from, to) = (
            &self.rows[here],
            &self.rows[(here + 1).min(self.rows.len() - 1)],
        );
        if time <= from[0] || to[0] <= from[0] {
            return from[self.index];
        }
        let part = (time - from[0]) / (to[0] - from[0]);
        from[self.index] + part * (to[self.index] - from[self.index])
    }

    /// The number of the last row.
    pub(crate) fn kept(&self, time: f64) -> f64 {
        self.rows[self.row(time)][self.index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reals_are_interpolated_and_whole_numbers_kept() {
        let stimuli = Stimuli::parse("time,a,n\n0,1,1\n2,2,3\n").unwrap();
        let (a, n) = (stimuli.column("a").unwrap(), stimuli.column("n").unwrap());
        assert_eq!(
            [0.0, 1.0, 2.0, 9.0].map(|time| a.at(time)),
            [1.0, 1.5, 2.0, 2.0]
        );
        assert_eq!([0.0, 1.9, 2.0].map(|time| n.kept(time)), [1.0, 1.0, 3.0]);
        assert_eq!(stimuli.times(), (0.0, 2.0));
        assert!(stimuli.column("time").is_none() && stimuli.column("b").is_none());
    }

    #[test]
    fn faults_are_named_with_their_line() {
        for (text, line, what) in [
            ("t,a\n0,1\n", 1, "must be called time, not 't'"),
            ("time;a\n0;1\n", 1, "must be called time, not 'time;a'"),
            ("time,a,b,a\n0,1,2,3\n", 1, "column 'a' is there twice"),
            ("time,time\n0,1\n", 1, "column 'time' is there twice"),
            ("time,a\n", 2, "no row"),
            ("time,a\n0,x\n", 2, "\"x\" is no finite number"),
            ("time,a\n0,1\n1\n", 3, "1 numbers, the heading has 2 names"),
            ("time,a\n0,1\n0,1\n", 3, "0 s does not increase"),
        ] {
            let (at, told) = Stimuli::parse(text).err().unwrap();
            assert_eq!(at, line, "{text}");
            assert!(told.contains(what), "{told}");
        }
        assert!(Stimuli::parse("\u{feff}time,a\n0,1\n").is_ok());
    }
}
