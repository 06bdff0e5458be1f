//! The rows of a run, as they are made.

use cosim_raw::{Places, prefetch};
use std::array;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Numbers that are looked at side by side: a line of the cache.
const LANES: usize = 8;

/// Rows so far.
#[derive(Default)]
pub struct Seen {
    pub names: Vec<String>,
    pub rows: Vec<f64>,
    pub good: usize,
}

/// Where rows go, one after the other.
pub enum Rows<'a> {
    /// Into memory that nobody else looks at.
    Own(&'a mut [f64]),
    /// Into memory that others may look at after each row.
    Seen(&'a Mutex<Seen>),
}

/// Rows so far; one that holds no number is not kept.
pub struct Recorder<'a> {
    rows: Rows<'a>,
    width: usize,
    good: usize,
}

impl<'a> Recorder<'a> {
    /// For rows of so many signals.
    pub fn new(rows: Rows<'a>, width: usize) -> Self {
        Self {
            rows,
            width,
            good: 0,
        }
    }

    /// How many rows are good.
    pub fn good(&self) -> usize {
        self.good
    }

    /// Adds the signals of the world that are kept, `None` for all, and tells whether all of the world are
    /// numbers; a row of a world of which that is not true is written over by the next one.
    #[inline(always)]
    pub fn push(&mut self, world: &[f64], kept: Option<&Places>) -> bool {
        let begin = self.good * self.width;
        let (there, good) = match &mut self.rows {
            Rows::Own(rows) => write((rows, begin, self.width), world, kept),
            Rows::Seen(seen) => {
                let mut seen = open(seen);
                let (there, good) = write((&mut seen.rows, begin, self.width), world, kept);
                seen.good = self.good + usize::from(there && good);
                (there, good)
            }
        };
        self.good += usize::from(there && good);
        good
    }
}

/// What others see; a thread that panicked has left nothing half done.
pub fn open(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a row at its place; returns whether there is one, and whether all of the world are numbers.
#[inline(always)]
fn write(
    (rows, begin, width): (&mut [f64], usize, usize),
    world: &[f64],
    kept: Option<&Places>,
) -> (bool, bool) {
    let rest = rows.get_mut(begin..);
    let Some((row, later)) = rest.and_then(|rest| rest.split_at_mut_checked(width)) else {
        return (false, are_numbers(world));
    };
    let ahead = later.get(..width).unwrap_or(world);
    let Some(places) = kept else {
        return (true, copy(world, row, ahead));
    };
    prefetch(ahead);
    places.copy(world, row);
    (true, are_numbers(world))
}

/// Copies a row in one pass that also looks at it as [`are_numbers`] does, and prefetches the one ahead.
#[inline]
fn copy(world: &[f64], row: &mut [f64], ahead: &[f64]) -> bool {
    let (Some(last), Some(last_to)) = (world.last_chunk(), row.last_chunk_mut()) else {
        row.copy_from_slice(world);
        return all_finite(world);
    };
    // The last ones, which may be among the lanes again: so there is no rest.
    let mut sums: [f64; LANES] = *last;
    *last_to = *last;
    let lanes = world.as_chunks::<LANES>().0.iter();
    let rows = row.as_chunks_mut::<LANES>().0.iter_mut();
    for ((lane, to), ahead) in lanes.zip(rows).zip(ahead.as_chunks::<LANES>().0) {
        prefetch(ahead);
        let lane = *lane;
        sums = array::from_fn(|k| sums[k] + lane[k]);
        *to = lane;
    }
    sum(sums, &[]).is_finite() || all_finite(world)
}

/// Whether all values are numbers: if they are, or nearly, so is their sum. Values too large for one are no reason.
///
/// Sums side by side do not wait for each other.
#[inline]
fn are_numbers(values: &[f64]) -> bool {
    let (lanes, rest) = values.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for lane in lanes {
        sums = array::from_fn(|k| sums[k] + lane[k]);
    }
    sum(sums, rest).is_finite() || all_finite(values)
}

#[inline]
fn sum(sums: [f64; LANES], rest: &[f64]) -> f64 {
    let four: [f64; 4] = array::from_fn(|k| sums[k] + sums[k + 4]);
    let rest = rest.iter().fold(0.0, |sum, value| sum + value);
    four[0] + four[2] + (four[1] + four[3]) + rest
}

#[cold]
fn all_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::are_numbers;

    #[test]
    fn one_value_that_is_no_number_is_seen_wherever_it_stands() {
        for count in 0..40 {
            let good = vec![1.0; count];
            assert!(are_numbers(&good));
            for place in 0..count {
                for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    let mut values = good.clone();
                    values[place] = bad;
                    assert!(!are_numbers(&values), "{bad} at {place} of {count}");
                }
            }
        }
        assert!(!are_numbers(&[f64::INFINITY, f64::NEG_INFINITY]));
    }

    #[test]
    fn numbers_too_large_for_a_sum_are_numbers() {
        assert!(are_numbers(&[f64::MAX; 20]));
    }
}
