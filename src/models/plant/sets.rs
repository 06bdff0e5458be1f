//! The different parameters that the plants of a library have, and copies kept ready for those who touch theirs.

use dct_driveline::Params;
use fmi2_cosim::Failure;
use std::sync::Arc;

/// Copies that are kept ready.
const SPARE: usize = 4;

/// The parameters of the paper, which nobody holds.
pub(super) static TABLE_1: Params = Params::TABLE_1;

/// Whether parameters fit together.
pub(super) type Check = fn(&Params) -> Result<(), Failure>;

/// Which parameters these are: no other ones have this number as long as anybody uses the shelf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Set(u64);

impl Set {
    const TABLE_1: Self = Self(0);
}

/// The parameters of all plants of a library.
pub(super) struct Sets {
    /// Those that fit together.
    known: Vec<(Set, Arc<Params>)>,
    /// The last one that was given a number.
    last: Set,
    /// Copies of nobody.
    spare: Vec<Arc<Params>>,
}

impl Sets {
    pub(super) const EMPTY: Self = Self {
        known: Vec::new(),
        last: Set::TABLE_1,
        spare: Vec::new(),
    };

    /// Some parameters that nobody else has.
    pub(super) fn spare(&mut self) -> Arc<Params> {
        self.spare.pop().unwrap_or_else(|| Arc::new(TABLE_1))
    }

    /// Makes parameters the same as equal ones of another plant, and copies ready; not for the middle of a run:
    /// it allocates. None: those of Table 1.
    ///
    /// # Errors
    /// When they do not pass the check. Those that are there already need not: they did.
    pub(super) fn share(
        &mut self,
        own: Option<&mut Arc<Params>>,
        check: Check,
    ) -> Result<Set, Failure> {
        let set = match own {
            Some(own) => self.known_as(own, check)?,
            None => Set::TABLE_1,
        };
        self.spare.truncate(SPARE);
        while self.spare.len() < SPARE {
            self.spare.push(Arc::new(TABLE_1));
        }
        Ok(set)
    }

    fn known_as(&mut self, own: &mut Arc<Params>, check: Check) -> Result<Set, Failure> {
        self.known.retain(|(_, known)| Arc::strong_count(known) > 1);
        for (set, known) in &self.known {
            if Arc::ptr_eq(known, own) || **known == **own {
                let other = std::mem::replace(own, Arc::clone(known));
                if Arc::strong_count(&other) == 1 {
                    self.spare.push(other);
                }
                return Ok(*set);
            }
        }
        check(own)?;
        self.last.0 += 1;
        self.known.push((self.last, Arc::clone(own)));
        Ok(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::{Sets, TABLE_1};
    use dct_driveline::Params;
    use fmi2_cosim::Failure;
    use std::sync::Arc;

    fn with_stiffness(k_o: f64) -> Arc<Params> {
        Arc::new(Params { k_o, ..TABLE_1 })
    }

    fn stiff_enough(p: &Params) -> Result<(), Failure> {
        let (variable, value, remedy) = ("driveShaft.stiffness", p.k_o, "");
        let failure = Failure::Invalid {
            variable,
            value,
            remedy,
        };
        (p.k_o > 1e3).then_some(()).ok_or(failure)
    }

    #[test]
    fn a_number_stands_for_the_same_parameters_only() {
        let mut sets = Sets::EMPTY;
        let mut number = |own: Option<&mut Arc<Params>>| sets.share(own, stiff_enough).unwrap();
        let (mut one, mut two) = (with_stiffness(5e3), with_stiffness(5e3));
        let first = number(Some(&mut one));
        assert_eq!(
            (number(Some(&mut two)), number(Some(&mut one))),
            (first, first)
        );
        assert!(Arc::ptr_eq(&one, &two));
        let others = [number(Some(&mut with_stiffness(6e3))), number(None)];
        assert!(!others.contains(&first) && others[0] != others[1]);
        drop((one, two));
        assert_ne!(number(Some(&mut with_stiffness(7e3))), first);
    }

    #[test]
    fn parameters_that_do_not_fit_together_are_refused_whoever_else_has_them() {
        let mut sets = Sets::EMPTY;
        let mut refused = [with_stiffness(1.0), with_stiffness(1.0)];
        for own in &mut refused {
            assert!(sets.share(Some(own), stiff_enough).is_err());
        }
        assert!(!Arc::ptr_eq(&refused[0], &refused[1]));
    }
}
