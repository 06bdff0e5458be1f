//! The inputs or outputs of one FMU: value references beside their values, one group per family.

use crate::description::{Family, Variable};
use crate::gather::kept;
use cosim_raw::{Instance, Status};
use num_traits::AsPrimitive;

/// What an FMU function that failed is called, and the status it returned.
pub type Failure = (&'static str, Status);

/// Inputs or outputs of one FMU: reals first, then integers, then booleans.
#[derive(Debug, Default)]
pub struct Signals {
    reals: Vec<u32>,
    integers: Narrow,
    booleans: Narrow,
    /// Integers and booleans as they are read.
    read: Vec<i32>,
    /// References of all three, those that are left out for a while, too.
    all: [Vec<u32>; 3],
}

/// Integers or booleans: in the loop they are numbers, here they are what FMI calls them.
#[derive(Debug, Default)]
struct Narrow {
    references: Vec<u32>,
    values: Vec<i32>,
    /// The numbers that the FMU has been given; before, none.
    given: Vec<f64>,
}

impl Narrow {
    fn new(references: Vec<u32>) -> Self {
        Self {
            values: vec![0; references.len()],
            references,
            given: vec![],
        }
    }

    /// Takes numbers that the FMU is to have; false if it has them: variables keep what they are set to.
    #[inline(always)]
    fn narrow(&mut self, numbers: &[f64]) -> bool {
        // What is no number differs from itself: it is looked at anew.
        *numbers != *self.given && self.take(numbers)
    }

    /// [`Self::narrow`] of other numbers than before, which may be the same values.
    #[inline(never)]
    fn take(&mut self, numbers: &[f64]) -> bool {
        let mut new = self.given.is_empty();
        for (value, number) in self.values.iter_mut().zip(numbers) {
            let now = integer(*number);
            new |= now != *value;
            *value = now;
        }
        self.given.clear();
        self.given.extend_from_slice(numbers);
        new
    }
}

/// Integers and booleans as numbers.
#[inline(always)]
fn widen(values: &[i32], numbers: &mut [f64]) {
    let (fours, rest) = values.as_chunks::<4>();
    let (to, few) = numbers.as_chunks_mut::<4>();
    for (to, four) in to.iter_mut().zip(fours) {
        *to = four.map(f64::from);
    }
    for (number, value) in few.iter_mut().zip(rest) {
        *number = f64::from(*value);
    }
}

impl Signals {
    /// Lays out variables, which come sorted by family.
    pub fn new<'a>(variables: impl IntoIterator<Item = &'a Variable>) -> Self {
        let mut all = [const { vec![] }; 3];
        for variable in variables {
            let [reals, integers, booleans] = &mut all;
            match variable.family {
                Family::Real => reals.push(variable.reference),
                Family::Integer => integers.push(variable.reference),
                Family::Boolean => booleans.push(variable.reference),
            }
        }
        let count = all.iter().map(Vec::len).sum();
        let mut signals = Self {
            all,
            ..Self::default()
        };
        signals.retain(&vec![true; count]);
        signals
    }

    /// Has from now on those of `new` that `keep` says.
    pub fn retain(&mut self, keep: &[bool]) {
        let [reals, integers, booleans] = &self.all;
        let (keep_reals, narrow) = keep.split_at(reals.len().min(keep.len()));
        let (keep_integers, keep_booleans) = narrow.split_at(integers.len().min(narrow.len()));
        self.reals = kept(reals, keep_reals);
        self.integers = Narrow::new(kept(integers, keep_integers));
        self.booleans = Narrow::new(kept(booleans, keep_booleans));
        self.read = vec![0; self.integers.values.len() + self.booleans.values.len()];
    }

    /// Sets the FMU's variables; `numbers` has as many as there are.
    #[inline(always)]
    pub fn set(&mut self, instance: &mut Instance, numbers: &[f64]) -> Result<(), Failure> {
        let (reals, narrow) = numbers.split_at(self.reals.len().min(numbers.len()));
        if !reals.is_empty() {
            let done = instance.set_real(&self.reals, reals);
            done.map_err(|status| ("fmi2SetReal", status))?;
        }
        if narrow.is_empty() {
            return Ok(());
        }
        let (integers, booleans) = narrow.split_at(self.integers.values.len().min(narrow.len()));
        if !integers.is_empty() && self.integers.narrow(integers) {
            let done = instance.set_integer(&self.integers.references, &self.integers.values);
            done.map_err(|status| ("fmi2SetInteger", status))?;
        }
        if !booleans.is_empty() && self.booleans.narrow(booleans) {
            let done = instance.set_boolean(&self.booleans.references, &self.booleans.values);
            done.map_err(|status| ("fmi2SetBoolean", status))?;
        }
        Ok(())
    }

    /// Reads the FMU's variables into `numbers`, which has as many as there are.
    #[inline(always)]
    pub fn get(&mut self, instance: &mut Instance, numbers: &mut [f64]) -> Result<(), Failure> {
        let (reals, narrow) = numbers.split_at_mut(self.reals.len().min(numbers.len()));
        if !reals.is_empty() {
            let done = instance.get_real(&self.reals, reals);
            done.map_err(|status| ("fmi2GetReal", status))?;
        }
        if narrow.is_empty() {
            return Ok(());
        }
        let count = self.integers.references.len().min(self.read.len());
        let (integers, booleans) = self.read.split_at_mut(count);
        if !integers.is_empty() {
            let done = instance.get_integer(&self.integers.references, integers);
            done.map_err(|status| ("fmi2GetInteger", status))?;
        }
        if !booleans.is_empty() {
            let done = instance.get_boolean(&self.booleans.references, booleans);
            done.map_err(|status| ("fmi2GetBoolean", status))?;
        }
        widen(&self.read, narrow);
        Ok(())
    }
}

/// A number as an integer: exact for every i32, saturating beyond.
fn integer(value: f64) -> i32 {
    value.as_()
}

#[cfg(test)]
mod tests {
    use super::{Narrow, integer};

    #[test]
    fn what_an_fmu_has_it_is_not_given_again() {
        let mut gear = Narrow::new(vec![7]);
        let given = [0.0, 0.0, 2.0, 2.0, 2.4, 0.0].map(|number| gear.narrow(&[number]));
        assert_eq!(given, [true, false, true, false, false, true]);
        assert_eq!(gear.values, [0]);
    }

    #[test]
    fn integers_are_exact_and_saturate_beyond_their_range() {
        for exact in [i32::MIN, -1, 0, 7, i32::MAX] {
            assert_eq!(integer(f64::from(exact)), exact);
        }
        assert_eq!((integer(3e9), integer(-3e9)), (i32::MAX, i32::MIN));
        assert_eq!((integer(2.9), integer(f64::NAN)), (2, 0));
    }
}
