//! Propagators shared by all plants of a library: whoever has the same driveline and step finds them here.
//! So are parameters (`shared.rs`, `sets.rs`).
//!
//! They are derived data, immutable while anybody holds them, and found by value, so no run can tell
//! whether they were shared. The shelf holds those in use and a few others: the last ones that were
//! used, or room for a step size that is new in the middle of a run, which may not allocate. With the
//! last plant that uses it the shelf is emptied.

use super::sets::{Check, Set, Sets, TABLE_1};
use dct_driveline::Params;
use dct_driveline::coupling::Coupling;
use dct_driveline::integrate::Propagators;
use fmi2_cosim::Failure;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Propagators that nobody uses: those of four step sizes that a plant takes in turn.
const SPARE: usize = 4;
/// Most entries a step adds without a new allocation of their list.
const ROOM: usize = 64;

static SHELF: Mutex<Shelf> = Mutex::new(Shelf {
    users: 0,
    clock: 0,
    entries: Vec::new(),
    sets: Sets::EMPTY,
});

struct Shelf {
    /// Plants and saved states that count on the shelf.
    users: usize,
    /// Counts what was asked for.
    clock: u64,
    entries: Vec<Entry>,
    /// The parameters that plants have.
    sets: Sets,
}

struct Entry {
    /// What the propagators were built for, friction and road aside.
    p: Params,
    /// A set of parameters with this driveline: the last one that was found to have it.
    set: Option<Set>,
    propagators: Arc<Propagators>,
    /// Time of the last use on the shelf's clock; 0: not built yet.
    used: u64,
}

/// Keeps the shelf filled as long as it lives.
pub(super) struct User {
    /// Where its parameters came from when its run began; their driveline is still the same.
    set: Option<Set>,
}

impl User {
    /// Joins the users of the shelf and sees that there is room for new step sizes.
    pub(super) fn new() -> Self {
        let mut shelf = lock();
        shelf.make_room();
        shelf.joined()
    }
}

impl Clone for User {
    fn clone(&self) -> Self {
        lock().users += 1;
        Self { set: self.set }
    }
}

impl Drop for User {
    fn drop(&mut self) {
        let mut shelf = lock();
        shelf.users -= 1;
        if shelf.users == 0 {
            (shelf.entries, shelf.sets) = (Vec::new(), Sets::EMPTY);
        }
    }
}

impl User {
    /// For the start of a run: makes parameters those of another plant, if they are equal; finds propagators for a
    /// step `h` [s]; sees that there is room for others. All that with the shelf in hand once.
    ///
    /// # Errors
    /// When the parameters do not pass the check.
    pub(super) fn begin(
        user: &mut Option<Self>,
        mut own: Option<&mut Arc<Params>>,
        check: Check,
        coupling: Coupling,
        h: f64,
    ) -> Result<Arc<Propagators>, Failure> {
        let mut shelf = lock();
        let user = user.get_or_insert_with(|| shelf.joined());
        user.set = None;
        user.set = Some(shelf.sets.share(own.as_deref_mut(), check)?);
        let p = own.map_or(&TABLE_1, |own| &**own);
        let found = shelf.find(user.set, p, coupling, h);
        shelf.make_room();
        Ok(found)
    }

    /// The propagators of a driveline for a step `h` [s].
    ///
    /// Allocates when more than four step sizes or couplings came up in the middle of runs and stay in use.
    #[cold]
    pub(super) fn find(&self, p: &Params, coupling: Coupling, h: f64) -> Arc<Propagators> {
        lock().find(self.set, p, coupling, h)
    }

    /// Sees again that there is room for new step sizes; not for the middle of a run: it allocates.
    pub(super) fn make_room(&self) {
        lock().make_room();
    }
}

impl Shelf {
    fn joined(&mut self) -> User {
        self.users += 1;
        User { set: None }
    }

    fn find(
        &mut self,
        set: Option<Set>,
        p: &Params,
        coupling: Coupling,
        h: f64,
    ) -> Arc<Propagators> {
        self.clock += 1;
        let now = self.clock;
        let fits = |entry: &&mut Entry| entry.propagators.fits(coupling, h) && entry.is_of(set, p);
        if let Some(entry) = self.entries.iter_mut().find(fits) {
            (entry.set, entry.used) = (set.or(entry.set), now);
            return Arc::clone(&entry.propagators);
        }
        let idle = |entry: &&mut Entry| Arc::strong_count(&entry.propagators) == 1;
        let oldest = self.entries.iter_mut().filter(idle);
        if let Some(entry) = oldest.min_by_key(|entry| entry.used) {
            (entry.set, entry.used) = (set, now);
            return entry.built(p, coupling, h);
        }
        let mut entry = Entry::new();
        (entry.set, entry.used) = (set, now);
        let found = entry.built(p, coupling, h);
        self.entries.push(entry);
        found
    }

    fn make_room(&mut self) {
        self.entries
            .reserve(ROOM.saturating_sub(self.entries.len()));
        let in_use = |entry: &&Entry| Arc::strong_count(&entry.propagators) > 1;
        let wanted = self.entries.iter().filter(in_use).count() + SPARE;
        while self.entries.len() < wanted {
            self.entries.push(Entry::new());
        }
    }
}

impl Entry {
    fn new() -> Self {
        Self {
            p: driveline(&Params::TABLE_1),
            set: None,
            propagators: Arc::new(Propagators::EMPTY),
            used: 0,
        }
    }

    /// Whether they are those of a driveline; equal numbers save the comparison.
    fn is_of(&self, set: Option<Set>, p: &Params) -> bool {
        set.is_some() && set == self.set || same_driveline(&self.p, p)
    }

    /// Turns idle propagators into others.
    fn built(&mut self, p: &Params, coupling: Coupling, h: f64) -> Arc<Propagators> {
        self.p = driveline(p);
        if let Some(propagators) = Arc::get_mut(&mut self.propagators) {
            propagators.rebuild(&self.p, coupling, h);
        }
        Arc::clone(&self.propagators)
    }
}

/// Some parameters that nobody else has.
pub(super) fn spare() -> Arc<Params> {
    lock().sets.spare()
}

/// The parameters that propagators depend on; friction and road are the same in all.
fn driveline(p: &Params) -> Params {
    let Params {
        clutch, road, t_s, ..
    } = Params::TABLE_1;
    Params {
        clutch,
        road,
        t_s,
        ..*p
    }
}

/// Whether two drivelines have the same propagators, whatever their friction and road.
fn same_driveline(one: &Params, other: &Params) -> bool {
    let Params {
        j_e,
        j_d,
        k_d,
        c_d,
        j_ct,
        k_t,
        c_t,
        i_t,
        i_r,
        j_gear,
        j_r,
        eta,
        eta_r,
        t_s: _,
        i_f,
        j_o,
        k_o,
        c_o,
        j_v,
        clutch: _,
        road: _,
        rigid,
    } = one;
    [*j_e, *j_d, *k_d, *c_d, *j_o, *k_o, *c_o, *j_v]
        == [
            other.j_e, other.j_d, other.k_d, other.c_d, other.j_o, other.k_o, other.c_o, other.j_v,
        ]
        && [*j_ct, *k_t, *c_t, *i_r, *j_r, *eta_r, *i_f]
            == [
                other.j_ct,
                other.k_t,
                other.c_t,
                other.i_r,
                other.j_r,
                other.eta_r,
                other.i_f,
            ]
        && [*i_t, *j_gear, *eta] == [other.i_t, other.j_gear, other.eta]
        && *rigid == other.rigid
}

fn lock() -> MutexGuard<'static, Shelf> {
    SHELF.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Held by each test that uses the shelf, which is one for all.
#[cfg(test)]
pub(super) fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::{SPARE, User, alone, lock};
    use dct_driveline::Params;
    use dct_driveline::coupling::Coupling;
    use std::sync::Arc;

    #[test]
    fn equal_drivelines_share_and_the_last_user_empties_the_shelf() {
        let _guard = alone();
        let (one, two) = (User::new(), User::new());
        let (gears, mut p) = (Coupling::from([1, 2]), Params::TABLE_1);
        let first = one.find(&p, gears, 1e-3);
        p.clutch[0].mu_k = 0.1;
        assert!(Arc::ptr_eq(
            &first,
            &two.find(&p, gears, 1e-3 * (1.0 + 1e-12))
        ));
        p.k_o *= 1.1;
        let other = two.find(&p, gears, 1e-3);
        assert!(!Arc::ptr_eq(&first, &other));
        assert!(!Arc::ptr_eq(&other, &two.find(&p, gears, 2e-3)));
        for h in [3e-3, 4e-3, 5e-3, 6e-3, 7e-3] {
            assert!(one.find(&p, gears, h).fits(gears, h));
        }
        assert!(lock().entries.len() <= 2 + SPARE);
        assert!(first.fits(gears, 1e-3) && other.fits(gears, 1e-3));
        drop((first, other, one));
        assert!(!lock().entries.is_empty());
        drop(two);
        assert!(lock().entries.is_empty());
    }

    #[test]
    fn runs_begin_with_the_propagators_of_their_driveline_whatever_parameters_came_between() {
        let _guard = alone();
        let gears = Coupling::from([1, 2]);
        let runs = [
            (0.2, 5e3),
            (0.2, 5e3),
            (0.3, 5e3),
            (0.2, 5e3),
            (0.2, 6e3),
            (0.3, 5e3),
        ];
        let runs = runs.map(|(mu_k, k_o)| {
            let (mut user, mut p) = (None, Params::TABLE_1);
            (p.clutch[0].mu_k, p.k_o) = (mu_k, k_o);
            let mut p = Arc::new(p);
            let found = User::begin(&mut user, Some(&mut p), |_| Ok(()), gears, 1e-3).unwrap();
            (k_o, found, user, p)
        });
        for (k_o, found, ..) in &runs {
            assert!(found.fits(gears, 1e-3));
            for (other, theirs, ..) in &runs {
                assert_eq!(Arc::ptr_eq(found, theirs), k_o == other);
            }
        }
    }
}
