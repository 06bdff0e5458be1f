//! The rows of a run, as they are made.

use cosim_raw::prefetch;
use std::sync::{Mutex, MutexGuard, PoisonError};

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

    /// Adds the signals of the world that are kept, `None` for all; a row that is not good is written
    /// over by the next one.
    pub fn push(&mut self, world: &[f64], kept: Option<&[usize]>, good: bool) {
        let begin = self.good * self.width;
        match &mut self.rows {
            Rows::Own(rows) => {
                let there = write((rows, begin, self.width), world, kept);
                self.good += usize::from(there && good);
            }
            Rows::Seen(seen) => {
                let mut seen = open(seen);
                let there = write((&mut seen.rows, begin, self.width), world, kept);
                self.good += usize::from(there && good);
                seen.good = self.good;
            }
        }
    }
}

/// What others see; a thread that panicked has left nothing half done.
pub fn open(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a row at its place; false where there is none.
fn write(
    (rows, begin, width): (&mut [f64], usize, usize),
    world: &[f64],
    kept: Option<&[usize]>,
) -> bool {
    let rest = rows.get_mut(begin..);
    let Some((row, later)) = rest.and_then(|rest| rest.split_at_mut_checked(width)) else {
        return false;
    };
    prefetch(later.get(..width).unwrap_or_default());
    match kept {
        None => row.copy_from_slice(world),
        Some(places) => row.iter_mut().zip(places).for_each(|(value, place)| {
            *value = world.get(*place).copied().unwrap_or(f64::NAN);
        }),
    }
    true
}
