//! The inputs of one component: where they are read, and what happens to a value on its way.

use crate::error::Error;
use crate::plan::Input;
use cosim_raw::Places;
use std::collections::HashMap;

/// Gathers the inputs of one component from the world.
#[derive(Debug, Default)]
pub struct Gather {
    sources: Places,
    /// Those that are not gathered for a while, too.
    all: Vec<usize>,
    /// Only where noise is added: place, source of the noise.
    noises: Vec<(usize, usize)>,
    /// Factor and offset of each.
    lines: Vec<(f64, f64)>,
    tables: Vec<Table>,
    /// Whether something is changed at all.
    changes: bool,
    /// Places of those that have no slope.
    held: Vec<usize>,
    /// What they are in initialisation mode, if that is known of all.
    initial: Option<Vec<f64>>,
    /// The gathered values.
    pub values: Vec<f64>,
    /// Their time derivatives within a step; none at all without interpolation.
    pub slopes: Vec<f64>,
}

#[derive(Debug)]
struct Table {
    name: String,
    place: usize,
    rows: Vec<(f64, f64)>,
}

impl Gather {
    /// For inputs in this order; `places` says where signals stand in the world.
    pub fn new(
        component: &str,
        inputs: &[Input],
        places: &HashMap<&str, usize>,
    ) -> Result<Self, Error> {
        let mut gather = Self {
            initial: inputs.iter().map(|input| input.initial).collect(),
            ..Self::default()
        };
        let mut sources = vec![];
        for (place, input) in inputs.iter().enumerate() {
            let name = format!("{component}.{}", input.name);
            let find = |source: &String| {
                let missing = || format!("reads '{source}', which does not exist");
                let found = places.get(source.as_str()).copied();
                found.ok_or_else(|| Error::variable(&name, missing()))
            };
            sources.push(find(&input.source)?);
            if let Some(noise) = &input.noise {
                gather.noises.push((place, find(noise)?));
            }
            gather.push(place, input, name);
        }
        gather.all.clone_from(&sources);
        gather.sources = Places::new(sources);
        Ok(gather)
    }

    fn push(&mut self, place: usize, input: &Input, name: String) {
        self.values.push(0.0);
        self.lines.push(input.line);
        self.changes |= input.line != (1.0, 0.0) || input.noise.is_some();
        if !input.table.is_empty() {
            self.changes = true;
            self.tables.push(Table {
                name,
                place,
                rows: input.table.clone(),
            });
        }
    }

    /// Lets inputs have slopes; `follows` says which of them may.
    pub fn steer(&mut self, follows: &[bool]) {
        let all = follows.iter().enumerate();
        let held = all.filter(|(_, follows)| !**follows);
        self.held = held.map(|(place, _)| place).collect();
        self.slopes = vec![0.0; self.values.len()];
    }

    /// Gathers all but what the scenario leaves `still`, its signals being the first of the world; returns which
    /// ones it gathers. Nothing changes where values change on their way, or have slopes.
    pub fn hold(&mut self, still: &[bool]) -> Option<Vec<bool>> {
        if self.changes || !self.slopes.is_empty() {
            return None;
        }
        let moves = |source: &usize| !still.get(*source).is_some_and(|still| *still);
        let keep: Vec<bool> = self.all.iter().map(moves).collect();
        let sources = kept(&self.all, &keep);
        self.values.resize(sources.len(), 0.0);
        self.sources = Places::new(sources);
        Some(keep)
    }

    /// Whether it reads one of these places of the world.
    pub fn reads(&self, places: &std::ops::Range<usize>) -> bool {
        let mut sources = self.sources.all().iter();
        sources.any(|source| places.contains(source))
    }

    /// Reads the world in initialisation mode, or what is known of it.
    pub fn gather_initial(&mut self, world: &[f64]) -> Result<(), Error> {
        if let Some(initial) = &self.initial {
            self.values.copy_from_slice(initial);
            return Ok(());
        }
        self.gather(world, 0.0)
    }

    /// Reads the world at communication point `time` [s].
    #[inline(always)]
    pub fn gather(&mut self, world: &[f64], time: f64) -> Result<(), Error> {
        self.sources.copy(world, &mut self.values);
        if self.changes {
            self.change(world, time)?;
        }
        Ok(())
    }

    /// Does to the gathered values what happens to them on their way.
    fn change(&mut self, world: &[f64], time: f64) -> Result<(), Error> {
        for (place, source) in &self.noises {
            if let Some(value) = self.values.get_mut(*place) {
                *value += world.get(*source).copied().unwrap_or(f64::NAN);
            }
        }
        let codes = self.tables.iter().map(|table| {
            let value = self.values.get(table.place).copied().unwrap_or(f64::NAN);
            Ok((table.place, table.look_up(value, time)?))
        });
        let codes: Vec<(usize, f64)> = codes.collect::<Result<_, Error>>()?;
        for (value, (factor, offset)) in self.values.iter_mut().zip(&self.lines) {
            *value = *value * factor + offset;
        }
        for (place, code) in codes {
            if let Some(value) = self.values.get_mut(place) {
                *value = code;
            }
        }
        Ok(())
    }

    /// Reads time derivatives of the signals of the world; what a table codes has none.
    pub fn gather_slopes(&mut self, world: &[f64]) {
        self.sources.copy(world, &mut self.slopes);
        for (slope, (factor, _)) in self.slopes.iter_mut().zip(&self.lines) {
            *slope *= factor;
        }
        let still = self.tables.iter().map(|table| table.place);
        for place in still.chain(self.held.iter().copied()) {
            if let Some(slope) = self.slopes.get_mut(place) {
                *slope = 0.0;
            }
        }
    }
}

/// Those that `keep` says.
pub fn kept<T: Copy>(all: &[T], keep: &[bool]) -> Vec<T> {
    let all = all.iter().zip(keep).filter(|(_, keep)| **keep);
    all.map(|(one, _)| *one).collect()
}

impl Table {
    fn look_up(&self, value: f64, time: f64) -> Result<f64, Error> {
        let row = self.rows.iter().find(|(source, _)| *source == value);
        row.map(|(_, target)| *target).ok_or_else(|| Error::Value {
            name: self.name.clone(),
            value,
            time,
            what: "it is in no row of its table",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gather(line: (f64, f64), table: Vec<(f64, f64)>) -> Gather {
        let input = Input {
            name: "u".into(),
            source: "scenario.u".into(),
            line,
            table,
            noise: Some("scenario.noise.u".into()),
            initial: None,
        };
        let places = HashMap::from([("scenario.u", 1), ("scenario.noise.u", 2)]);
        Gather::new("plant", &[input], &places).unwrap()
    }

    #[test]
    fn noise_comes_before_the_line() {
        let mut gather = gather((2.0, 1.0), vec![]);
        gather.gather(&[0.0, 3.0, 0.5], 0.0).unwrap();
        assert_eq!(gather.values, [8.0]);
    }

    #[test]
    fn a_value_passes_its_line_or_its_table() {
        for (line, table, expected) in [
            ((1.0, 0.0), vec![], 3.0),
            ((2.0, 1.0), vec![], 7.0),
            ((2.0, 1.0), vec![(3.0, -1.0)], -1.0),
        ] {
            let mut gather = gather(line, table);
            gather.gather(&[0.0, 3.0, 0.0], 0.0).unwrap();
            assert_eq!(gather.values, [expected], "{line:?}");
        }
    }

    #[test]
    fn what_is_still_is_not_gathered_until_it_moves() {
        let input = |source: &str| Input {
            name: source.into(),
            source: source.into(),
            line: (1.0, 0.0),
            table: vec![],
            noise: None,
            initial: None,
        };
        let places = HashMap::from([("a", 0), ("b", 1), ("c", 2)]);
        let inputs = ["b", "c", "a"].map(input);
        let mut gather = Gather::new("plant", &inputs, &places).unwrap();
        for (still, expected) in [
            ([true, false], &[2.0, 3.0][..]),
            ([false, true], &[3.0, 1.0]),
            ([false, false], &[2.0, 3.0, 1.0]),
        ] {
            let keep = gather.hold(&still).unwrap();
            assert_eq!(keep, [!still[1], true, !still[0]]);
            gather.gather(&[1.0, 2.0, 3.0], 0.0).unwrap();
            assert_eq!(gather.values, expected);
        }
    }

    #[test]
    fn what_changes_on_its_way_is_gathered_on() {
        assert_eq!(gather((1.0, 0.0), vec![]).hold(&[true; 3]), None);
    }

    #[test]
    fn a_value_without_a_row_is_named_with_its_time() {
        let error = gather((1.0, 0.0), vec![(1.0, 2.0)]).gather(&[0.0, 3.0, 0.0], 0.5);
        let text = error.unwrap_err().to_string();
        assert_eq!(
            text,
            "plant.u is 3 at t = 0.5 s: it is in no row of its table"
        );
    }

    #[test]
    fn a_slope_passes_its_factor_and_no_table() {
        for (line, table, follows, expected) in [
            ((2.0, 1.0), vec![], true, 6.0),
            ((2.0, 1.0), vec![(3.0, 1.0)], true, 0.0),
            ((2.0, 1.0), vec![], false, 0.0),
        ] {
            let mut gather = gather(line, table);
            gather.steer(&[follows]);
            gather.gather_slopes(&[0.0, 3.0, 0.0]);
            assert_eq!(gather.slopes, [expected]);
        }
    }
}
