//! Numbers side by side, and the sums that a rung is made of.

use core::ops::{Deref, DerefMut};

/// Numbers side by side, aligned so that a pair of them is at hand at once.
#[derive(Debug, Clone, Copy)]
#[repr(align(16))]
pub(crate) struct Lanes<const N: usize>(pub(crate) [f64; N]);

impl<const N: usize> Lanes<N> {
    pub(crate) const ZERO: Self = Self([0.0; N]);

    /// The first of them.
    #[inline(always)]
    pub(crate) fn first<const M: usize>(&self) -> Lanes<M> {
        let Self(all) = *self;
        Lanes(core::array::from_fn(|k| all[k]))
    }
}

impl<const N: usize> Deref for Lanes<N> {
    type Target = [f64; N];

    #[inline(always)]
    fn deref(&self) -> &[f64; N] {
        &self.0
    }
}

impl<const N: usize> DerefMut for Lanes<N> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64; N] {
        &mut self.0
    }
}

/// `sum` + `scale` · `column`, which may be shorter or longer; inlined, so that a chain of these keeps the sum in
/// registers.
#[inline(always)]
pub(crate) fn add<const N: usize, const M: usize>(
    sum: &mut [f64; N],
    column: &Lanes<M>,
    scale: f64,
) {
    let Lanes(column) = *column; // as a whole it keeps its alignment
    for (sum, entry) in sum.iter_mut().zip(column) {
        *sum += entry * scale;
    }
}

/// [`dot`] by itself: of several that lie side by side the compiler would make one with more moves than sums.
#[inline(never)]
pub(crate) fn dot_apart<const N: usize, const M: usize>(a: &Lanes<N>, b: &Lanes<M>) -> f64 {
    dot(a, b)
}

/// Σ a b of an even number of entries, the shorter one's, in two lanes.
#[inline(always)]
pub(crate) fn dot<const N: usize, const M: usize>(a: &Lanes<N>, b: &Lanes<M>) -> f64 {
    let (Lanes(a), Lanes(b)) = (*a, *b);
    let mut lanes = [-0.0; 2]; // what a first sum leaves as it is
    for ([a0, a1], [b0, b1]) in a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0) {
        lanes[0] += a0 * b0;
        lanes[1] += a1 * b1;
    }
    lanes[0] + lanes[1]
}
