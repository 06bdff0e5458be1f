//! Tokens in place of pointers: what an importer holds is looked up, never followed.
//!
//! ```text
//! token = stamp | index | 0        places[index] = the one token that opens it, or TAKEN
//! ```
//!
//! A place counts up its stamp when its value is given back, and every table begins with another one,
//! so a token that was freed, that another table made, or that never was one opens no place. To enter,
//! one atomic operation turns the place from its token to [`TAKEN`]: a second caller, be it another thread
//! or the importer's logger calling back, is refused until the first one leaves.
//!
//! Places never move and are not freed while the library is loaded. The first ones lie in the
//! library itself, so that nothing of them stays behind when it is unloaded.

use core::ptr::null_mut;
use core::sync::atomic::{AtomicPtr, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Places in the library itself; each further block doubles the number of all places.
const FIRST: usize = 64;
/// Blocks: there is room for 4 million values.
const BLOCKS: usize = 16;
/// Bits of a token below its index, all of them 0: those of the distance between two places.
const INDEX: u32 = size_of::<Place<()>>().ilog2();
/// Bits of a token below its stamp.
const STAMP: u32 = if usize::BITS > 32 { 32 } else { 22 };
/// What is above all indices.
const MOST: usize = 1 << (STAMP - INDEX - 1);
/// The word of a place that nobody may enter. As a token it leads to [`NOBODY`], or to no place at all.
const TAKEN: usize = usize::MAX;
/// A place that is never given out, and that no token opens: its word is not [`TAKEN`] either.
const NOBODY: usize = FIRST - 1;
/// A number with which multiplication shuffles the bits of an address: odd, near the golden ratio.
const SHUFFLE: usize = (usize::MAX / 1000 * 618) | 1;

/// Where a value lives; on a cache line of its own, so that threads with an instance each do not
/// slow each other down.
#[repr(align(64))]
struct Place<T> {
    /// The token that opens it; [`TAKEN`] while it is vacant or somebody is in.
    word: AtomicUsize,
    value: AtomicPtr<T>,
    /// Stamp of the next token; not 0, so that no token is NULL.
    stamp: AtomicUsize,
    /// While vacant: index of the next vacant place plus 1, or 0.
    next: AtomicUsize,
}

impl<T> Place<T> {
    const fn new() -> Self {
        Self {
            word: AtomicUsize::new(TAKEN),
            value: AtomicPtr::new(null_mut()),
            stamp: AtomicUsize::new(0),
            next: AtomicUsize::new(0),
        }
    }
}

/// Which places may be given out.
struct Vacant {
    /// Index of the place that was given back last plus 1, or 0.
    first: usize,
    /// Index of the next place that was never given out.
    used: usize,
}

/// Values of one kind behind tokens.
pub(crate) struct Table<T> {
    first: [Place<T>; FIRST],
    blocks: [OnceLock<Box<[Place<T>]>>; BLOCKS],
    vacant: Mutex<Vacant>,
}

/// A value that nobody else may touch until this is dropped.
pub(crate) struct Entered<'a, T> {
    place: &'a Place<T>,
    token: usize,
    /// Came from a `Box` that [`Table::insert`] was given.
    pub(crate) value: *mut T,
}

impl<T> Drop for Entered<'_, T> {
    fn drop(&mut self) {
        self.place.word.store(self.token, Ordering::Release);
    }
}

impl<T> Table<T> {
    pub(crate) const fn new() -> Self {
        let mut first = [const { Place::new() }; FIRST];
        first[NOBODY].word = AtomicUsize::new(0);
        Self {
            first,
            blocks: [const { OnceLock::new() }; BLOCKS],
            vacant: Mutex::new(Vacant { first: 0, used: 0 }),
        }
    }

    /// Keeps a value; its token is not 0. `None`, and the value is dropped, when there is no room.
    pub(crate) fn insert(&self, value: Box<T>) -> Option<usize> {
        let (index, place) = self.vacant_place()?;
        let token = place.stamp.load(Ordering::Relaxed) << STAMP | index << INDEX;
        place.value.store(Box::into_raw(value), Ordering::Relaxed);
        place.word.store(token, Ordering::Release);
        Some(token)
    }

    /// The value of a token, unless somebody is in, it was given back, or there never was one.
    pub(crate) fn enter(&self, token: usize) -> Option<Entered<'_, T>> {
        Self::enter_place(self.place(index(token))?, token)
    }

    /// [`Self::enter`] of the places in the library itself, which are at hand; the others open to none.
    #[inline(always)]
    pub(crate) fn enter_first(&self, token: usize) -> Option<Entered<'_, T>> {
        Self::enter_place(self.first.get(index(token) % FIRST)?, token)
    }

    #[inline(always)]
    fn enter_place(place: &Place<T>, token: usize) -> Option<Entered<'_, T>> {
        place
            .word
            .compare_exchange(token, TAKEN, Ordering::Acquire, Ordering::Relaxed)
            .ok()?;
        Some(Entered {
            place,
            token,
            value: place.value.load(Ordering::Relaxed),
        })
    }

    /// Makes the token void and its place vacant; the value is the caller's to drop.
    pub(crate) fn give_back(&self, entered: Entered<'_, T>) -> *mut T {
        let (place, token, value) = (entered.place, entered.token, entered.value);
        core::mem::forget(entered);
        place.value.store(null_mut(), Ordering::Relaxed);
        place
            .stamp
            .store(following(token >> STAMP), Ordering::Relaxed);
        let mut vacant = self.vacant.lock().unwrap_or_else(PoisonError::into_inner);
        place.next.store(vacant.first, Ordering::Relaxed);
        vacant.first = index(token) + 1;
        value
    }

    fn vacant_place(&self) -> Option<(usize, &Place<T>)> {
        let mut vacant = self.vacant.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = vacant.first.checked_sub(1) {
            let place = self.place(index)?;
            vacant.first = place.next.load(Ordering::Relaxed);
            return Some((index, place));
        }
        let index = vacant.used;
        let place = self.new_place(index)?;
        place.stamp.store(following(self.salt()), Ordering::Relaxed);
        vacant.used = index + 1;
        Some((index, place))
    }

    /// A place that was never given out; its block is made with its first one.
    fn new_place(&self, index: usize) -> Option<&Place<T>> {
        if let Some((block, _)) = beyond_first(index).filter(|_| index < MOST) {
            let places = || (0..FIRST << block).map(|_| Place::new()).collect();
            self.blocks.get(block)?.get_or_init(places);
        }
        self.place(index)
    }

    fn place(&self, index: usize) -> Option<&Place<T>> {
        match self.first.get(index) {
            Some(place) => Some(place),
            None => self.place_beyond(index),
        }
    }

    fn place_beyond(&self, index: usize) -> Option<&Place<T>> {
        let (block, offset) = beyond_first(index)?;
        self.blocks.get(block)?.get()?.get(offset)
    }

    /// A stamp that no other table begins with, in this library or another one.
    fn salt(&self) -> usize {
        core::ptr::from_ref(self).addr().wrapping_mul(SHUFFLE) >> STAMP
    }
}

/// Index of a token's place.
#[inline(always)]
const fn index(token: usize) -> usize {
    (token & ((1 << STAMP) - 1)) >> INDEX
}

/// The stamp after another one: from 1 on again after the last one.
const fn following(stamp: usize) -> usize {
    if stamp >= usize::MAX >> STAMP {
        1
    } else {
        stamp + 1
    }
}

/// Block, and offset in it, of a place that does not lie in the library itself.
fn beyond_first(index: usize) -> Option<(usize, usize)> {
    let block = usize::try_from((index / FIRST).checked_ilog2()?).ok()?;
    Some((block, index - (FIRST << block)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> &'static Table<u32> {
        Box::leak(Box::new(Table::new()))
    }

    /// The address behind a token; at the places in the library itself both ways in lead there.
    fn entered(table: &Table<u32>, token: usize) -> Option<usize> {
        let first = table.enter_first(token).map(|entered| entered.value.addr());
        let any = table.enter(token).map(|entered| entered.value.addr());
        assert_eq!(first, any.filter(|_| index(token) < FIRST), "{token:x}");
        any
    }

    #[test]
    fn every_token_opens_its_own_value_however_many_there_are() {
        let table = table();
        let count = 5 * FIRST;
        let boxes = (0..count).map(|_| Box::new(0));
        let kept: Vec<_> = boxes
            .map(|value| (core::ptr::from_ref(&*value).addr(), table.insert(value)))
            .collect();
        for (value, token) in kept {
            assert_ne!(token, Some(0));
            assert_eq!(entered(table, token.unwrap()), Some(value));
        }
    }

    #[test]
    fn a_token_that_was_given_back_opens_nothing_even_when_its_place_is_used_again() {
        let table = table();
        let old = table.insert(Box::new(1)).unwrap();
        table.give_back(table.enter(old).unwrap());
        for _ in 0..1000 {
            assert_eq!(entered(table, old), None);
            let new = table.insert(Box::new(2)).unwrap();
            assert_ne!(new, old);
            assert_eq!(entered(table, old), None);
            table.give_back(table.enter(new).unwrap());
        }
    }

    #[test]
    fn nobody_enters_where_somebody_is() {
        let table = table();
        let token = table.insert(Box::new(1)).unwrap();
        let inside = table.enter(token);
        assert!(inside.is_some());
        assert_eq!(entered(table, token), None);
        drop(inside);
        assert!(entered(table, token).is_some());
    }

    #[test]
    fn one_thread_of_many_is_let_in() {
        let table = table();
        let token = table.insert(Box::new(1)).unwrap();
        let barrier = std::sync::Barrier::new(8);
        let attempt = || {
            barrier.wait();
            let inside = table.enter(token);
            barrier.wait();
            inside.is_some()
        };
        let inside = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(attempt)).collect();
            let inside = threads.into_iter().map(|thread| thread.join().unwrap());
            inside.filter(|inside| *inside).count()
        });
        assert_eq!(inside, 1);
    }

    #[test]
    fn tokens_of_another_table_and_addresses_open_nothing() {
        let (table, other) = (table(), table());
        let token = table.insert(Box::new(1)).unwrap();
        let near = (0..usize::BITS).map(|bit| token ^ (1 << bit));
        let foreign = [0, 1, usize::MAX, core::ptr::from_ref(table).addr()];
        let foreign = foreign
            .into_iter()
            .chain(near)
            .chain(other.insert(Box::new(1)));
        for token in foreign {
            assert_eq!(entered(table, token), None, "{token:x}");
        }
        let all = (0..2 * FIRST).map(|index| index << INDEX);
        for token in all.clone().chain(all.map(|token| TAKEN ^ token)) {
            assert_eq!(entered(table, token), None, "{token:x}");
        }
    }
}
