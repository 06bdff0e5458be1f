//! Parameters of plants: those that are equal lie in memory once, until somebody touches them.
//!
//! A plant begins with Table 1, which is part of the library. To set a parameter, or to read one, gives it a
//! copy of its own; when it is initialised it takes the copy of another plant instead, if that is equal. They
//! are found by value, so no run can tell whether they were shared. A few copies are kept ready for
//! those who tune or read a parameter in the middle of a run, which may not allocate.

use super::shelf;
use dct_driveline::Params;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// Copies that are kept ready.
const SPARE: usize = 4;

static TABLE_1: Params = Params::TABLE_1;

/// The parameters of one plant; none: those of the paper.
#[derive(Clone, Default)]
pub(super) struct Shared(Option<Arc<Params>>);

impl Deref for Shared {
    type Target = Params;

    fn deref(&self) -> &Params {
        self.0.as_deref().unwrap_or(&TABLE_1)
    }
}

/// Gives a copy of one's own.
///
/// Allocates in the middle of a run when more than four plants that live take one.
impl DerefMut for Shared {
    fn deref_mut(&mut self) -> &mut Params {
        let own = |params: &Arc<Params>| Arc::strong_count(params) == 1;
        if !self.0.as_ref().is_some_and(own) {
            self.0 = Some(shelf::fresh(self));
        }
        Arc::make_mut(self.0.get_or_insert_with(|| Arc::new(TABLE_1)))
    }
}

/// The parameters of all plants of a library.
pub(super) struct Sets {
    known: Vec<Arc<Params>>,
    /// Copies of nobody.
    spare: Vec<Arc<Params>>,
}

impl Sets {
    pub(super) const EMPTY: Self = Self {
        known: Vec::new(),
        spare: Vec::new(),
    };

    /// A copy that nobody else has.
    pub(super) fn fresh(&mut self, params: &Params) -> Arc<Params> {
        let Some(mut spare) = self.spare.pop() else {
            return Arc::new(*params);
        };
        *Arc::make_mut(&mut spare) = *params;
        spare
    }

    /// Makes equal parameters the same, and copies ready; not for the middle of a run: it allocates.
    pub(super) fn share(&mut self, shared: &mut Shared) {
        if let Shared(Some(own)) = shared {
            self.known.retain(|known| Arc::strong_count(known) > 1);
            let equal = |known: &&Arc<Params>| Arc::ptr_eq(known, own) || ***known == **own;
            match self.known.iter().find(equal) {
                Some(known) => {
                    let other = std::mem::replace(own, Arc::clone(known));
                    if Arc::strong_count(&other) == 1 {
                        self.spare.push(other);
                    }
                }
                None => self.known.push(Arc::clone(own)),
            }
        }
        self.spare.truncate(SPARE);
        while self.spare.len() < SPARE {
            self.spare.push(Arc::new(TABLE_1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shelf::{User, alone};
    use super::Shared;
    use dct_driveline::Params;

    fn with_stiffness(user: &User, k_o: f64) -> Shared {
        let mut shared = Shared(None);
        shared.k_o = k_o;
        user.share(&mut shared);
        shared
    }

    fn same(one: &Shared, other: &Shared) -> bool {
        std::ptr::eq::<Params>(&**one, &**other)
    }

    #[test]
    fn equal_parameters_are_the_same_until_one_of_them_is_touched() {
        let (_guard, user) = (alone(), User::new());
        let (one, mut two) = (with_stiffness(&user, 5e3), with_stiffness(&user, 5e3));
        assert!(same(&one, &two) && !same(&one, &with_stiffness(&user, 6e3)));
        two.clutch[0].mu_k = 0.1;
        assert!(!same(&one, &two));
        assert_eq!(
            (one.k_o, one.clutch[0].mu_k),
            (5e3, Params::TABLE_1.clutch[0].mu_k)
        );
        assert_eq!((two.k_o, two.clutch[0].mu_k), (5e3, 0.1));
        two.clutch[0].mu_k = one.clutch[0].mu_k;
        user.share(&mut two);
        assert!(same(&one, &two));
    }

    #[test]
    fn a_copy_of_a_plant_keeps_what_the_plant_had() {
        let (_guard, user) = (alone(), User::new());
        let mut one = with_stiffness(&user, 5e3);
        let saved = one.clone();
        one.k_o = 7e3;
        assert_eq!((saved.k_o, one.k_o), (5e3, 7e3));
        assert_eq!(*Shared::default(), Params::TABLE_1);
    }
}
