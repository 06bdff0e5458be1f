//! Scenario CSV: first column `time` [s], then one column per signal (SI units).

use crate::{Error, Seconds, csv};
use std::path::{Path, PathBuf};

/// Times that differ by less [s] are one.
const INSTANT: f64 = 1e-9;

/// Signals over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    path: PathBuf,
    time: Vec<f64>,
    names: Vec<String>,
    /// One column per name, each as long as `time`.
    columns: Vec<Vec<f64>>,
}

impl Scenario {
    /// Reads a scenario from a file.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|error| Error::File {
            path: path.into(),
            error,
        })?;
        Self::parse(path, &text)
    }

    /// A scenario without signals.
    pub fn none() -> Self {
        Self {
            path: "no scenario".into(),
            time: vec![0.0],
            names: vec![],
            columns: vec![],
        }
    }

    /// What to say of a run from 0 to `stop` [s] that leaves the rows; one of one row, or without signals, holds.
    pub fn beyond(&self, stop: f64) -> Vec<String> {
        let (true, [first, .., last]) = (!self.names.is_empty(), self.time.as_slice()) else {
            return vec![];
        };
        let name = self.path.file_name().unwrap_or_default().display();
        let early = || {
            let first = Seconds(*first);
            format!("scenario {name} begins at t = {first} s: its first values hold until then")
        };
        let late = || {
            let last = Seconds(*last);
            format!("scenario {name} ends at t = {last} s: its last values hold from then on")
        };
        let early = (*first > INSTANT).then(early);
        let late = (stop > last + INSTANT).then(late);
        early.into_iter().chain(late).collect()
    }

    /// Reads a scenario from text; `path` is for messages.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let mut scenario = Self::table(text).map_err(|(line, what)| Error::Content {
            path: path.into(),
            line,
            what,
        })?;
        scenario.path = path.into();
        Ok(scenario)
    }

    /// Reads the table; an error carries its line.
    fn table(text: &str) -> Result<Self, (usize, String)> {
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(index, line)| (index + 1, line));
        let header = lines
            .next()
            .map_or("", |(_, line)| line.trim_start_matches('\u{feff}'));
        let names = signals(csv::names(header)).map_err(|what| (1, what))?;
        let mut scenario = Self {
            path: PathBuf::new(),
            time: vec![],
            columns: vec![vec![]; names.len()],
            names,
        };
        for (line, text) in lines.filter(|(_, text)| !text.trim().is_empty()) {
            scenario.push(text).map_err(|what| (line, what))?;
        }
        if scenario.time.is_empty() {
            return Err((2, "needs at least one row".into()));
        }
        Ok(scenario)
    }

    fn push(&mut self, row: &str) -> Result<(), String> {
        let cells: Vec<_> = row.split(',').map(str::trim).collect();
        let (found, wanted) = (cells.len(), self.names.len() + 1);
        let (Some((time, values)), true) = (cells.split_first(), found == wanted) else {
            return Err(format!("has {found} cells, the header has {wanted}"));
        };
        let time = number("time", time)?;
        if let Some(last) = self.time.last().filter(|last| **last >= time) {
            return Err(format!("time {time} does not increase (before it: {last})"));
        }
        let cells = self.names.iter().zip(values);
        let values: Result<Vec<_>, _> = cells.map(|(name, cell)| number(name, cell)).collect();
        self.time.push(time);
        let columns = self.columns.iter_mut().zip(values?);
        columns.for_each(|(column, value)| column.push(value));
        Ok(())
    }

    /// Where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Times of the rows [s].
    pub fn times(&self) -> &[f64] {
        &self.time
    }

    /// The value of a column in a row; NaN where there is none.
    pub fn at(&self, column: usize, row: usize) -> f64 {
        let value = self.columns.get(column).and_then(|c| c.get(row));
        value.copied().unwrap_or(f64::NAN)
    }

    /// Names of the signals, in the order of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Values of a signal as they are in the file; none when there is no such signal.
    pub fn values(&self, name: &str) -> &[f64] {
        let column = self.find(name).and_then(|column| self.columns.get(column));
        column.map_or(&[], Vec::as_slice)
    }

    /// Signals at all `times` [s], row by row; `held` tells which are held between rows.
    pub fn rows(&self, names: &[String], held: &[bool], times: &[f64]) -> Vec<f64> {
        let columns: Vec<(usize, bool)> = names
            .iter()
            .zip(held)
            .filter_map(|(name, held)| Some((self.find(name)?, *held)))
            .collect();
        let row = |time: &f64| {
            let time = *time;
            let cells = columns.iter();
            cells.map(move |(column, held)| self.sample(*column, time, *held))
        };
        times.iter().flat_map(row).collect()
    }

    /// Column of a signal.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// A signal at `time` [s]: linear between rows, or held since the last row; before the first
    /// and after the last row the end values hold. The arithmetic is that of `numpy.interp`.
    pub fn sample(&self, column: usize, time: f64, hold: bool) -> f64 {
        let at = |row: usize| self.at(column, row);
        let after = self.time.partition_point(|row| *row <= time);
        let row = after.saturating_sub(1);
        match (self.time.get(row), self.time.get(after)) {
            (Some(start), Some(end)) if !hold && after > 0 && time > *start => {
                (at(after) - at(row)) / (end - start) * (time - start) + at(row)
            }
            _ => at(row),
        }
    }
}

/// The signals of a heading whose first column is the time.
fn signals(mut names: Vec<String>) -> Result<Vec<String>, String> {
    let twice = |name: &&String| names.iter().filter(|other| other == name).count() > 1;
    if names.first().is_none_or(|first| first != "time") {
        let first = names.first().map_or("", String::as_str);
        return Err(format!(
            "the first column must be 'time' [s], not '{first}'; columns are separated by commas: \
             `dct-harness convert` does that, decimal commas too"
        ));
    }
    if let Some(name) = names.iter().find(|name| name.is_empty() || twice(name)) {
        return Err(format!("column name '{name}' is empty or used twice"));
    }
    names.remove(0);
    Ok(names)
}

/// A finite number in a column.
fn number(name: &str, cell: &str) -> Result<f64, String> {
    let value = cell.parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| format!("column '{name}': '{cell}' is not a finite number"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Scenario {
        Scenario::parse(Path::new("s.csv"), text).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn signals_are_linear_between_rows_or_held() {
        let scenario = parse("time,a,b\n0,1,2\n2,2,4\n4,0,0\n");
        let column = scenario.find("a").unwrap();
        for (time, linear, held) in [
            (-1.0, 1.0, 1.0),
            (0.0, 1.0, 1.0),
            (1.0, 1.5, 1.0),
            (2.0, 2.0, 2.0),
            (3.0, 1.0, 2.0),
            (9.0, 0.0, 0.0),
        ] {
            assert_eq!(scenario.sample(column, time, false), linear, "t = {time}");
            assert_eq!(scenario.sample(column, time, true), held, "t = {time}");
        }
        assert_eq!(scenario.find("c"), None);
    }

    #[test]
    fn a_bad_row_is_named_by_its_line_column_and_value() {
        for (text, line, said) in [
            ("t,a\n", 1, "not 't'; columns are separated by commas"),
            ("time;a\n0;1\n", 1, "not 'time;a'"),
            ("", 1, "must be 'time' [s], not ''"),
            ("time,a,b,a\n0,1,2,3\n", 1, "'a' is empty or used twice"),
            ("time,a,\n0,1,2\n", 1, "'' is empty or used twice"),
            ("time,a\n", 2, "at least one row"),
            (
                "time,a\n0,1\n0,1\n",
                3,
                "time 0 does not increase (before it: 0)",
            ),
            ("time,a\n0,inf\n", 2, "'a': 'inf' is not a finite number"),
            ("time,a\nnan,1\n", 2, "'time': 'nan'"),
            ("time,a,b\n0,1,2\n\n1,2,x\n", 4, "'b': 'x'"),
            ("time,a\n0,\n", 2, "'a': ''"),
            ("time,a\n0,1,2\n", 2, "has 3 cells, the header has 2"),
        ] {
            let (found, told) = Scenario::table(text).unwrap_err();
            assert_eq!(found, line, "{text}");
            assert!(told.contains(said), "{text}: {told}");
        }
    }
}
