//! Parameters of plants: those that are equal lie in memory once, until somebody touches them.
//!
//! A plant begins with Table 1, which is part of the library. To set a parameter, or to read one, gives it a
//! copy of its own; when it is initialised it takes the copy of another plant instead, if that is equal. They
//! are found by value, so no run can tell whether they were shared. A few copies are kept ready for
//! those who tune or read a parameter in the middle of a run, which may not allocate.

use super::sets::TABLE_1;
use super::shelf;
use dct_driveline::Params;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

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
            let was = std::mem::take(self);
            let copy = Arc::make_mut(self.0.insert(shelf::spare()));
            *copy = *was;
            return copy;
        }
        Arc::make_mut(self.0.get_or_insert_with(|| Arc::new(TABLE_1)))
    }
}

impl Shared {
    /// The parameters, where they are not those of the paper.
    pub(super) fn held(&mut self) -> Option<&mut Arc<Params>> {
        self.0.as_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::super::shelf::{User, alone};
    use super::Shared;
    use dct_driveline::Params;
    use dct_driveline::coupling::Coupling;

    fn share(shared: &mut Shared, user: &mut Option<User>) {
        let gears = Coupling::from([1, 2]);
        User::begin(user, shared.held(), |_| Ok(()), gears, 1e-3).unwrap();
    }

    fn with_stiffness(user: &mut Option<User>, k_o: f64) -> Shared {
        let mut shared = Shared(None);
        shared.k_o = k_o;
        share(&mut shared, user);
        shared
    }

    fn same(one: &Shared, other: &Shared) -> bool {
        std::ptr::eq::<Params>(&**one, &**other)
    }

    #[test]
    fn equal_parameters_are_the_same_until_one_of_them_is_touched() {
        let (_guard, mut user) = (alone(), None);
        let (one, mut two) = (
            with_stiffness(&mut user, 5e3),
            with_stiffness(&mut user, 5e3),
        );
        assert!(same(&one, &two) && !same(&one, &with_stiffness(&mut user, 6e3)));
        two.clutch[0].mu_k = 0.1;
        assert!(!same(&one, &two));
        assert_eq!(
            (one.k_o, one.clutch[0].mu_k),
            (5e3, Params::TABLE_1.clutch[0].mu_k)
        );
        assert_eq!((two.k_o, two.clutch[0].mu_k), (5e3, 0.1));
        two.clutch[0].mu_k = one.clutch[0].mu_k;
        share(&mut two, &mut user);
        assert!(same(&one, &two));
    }

    #[test]
    fn a_copy_of_a_plant_keeps_what_the_plant_had() {
        let (_guard, mut user) = (alone(), None);
        let mut one = with_stiffness(&mut user, 5e3);
        let saved = one.clone();
        one.k_o = 7e3;
        assert_eq!((saved.k_o, one.k_o), (5e3, 7e3));
        assert_eq!(*Shared::default(), Params::TABLE_1);
    }
}
