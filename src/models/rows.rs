//! Joins pieces of a table of rows at compile time.

use fmi2_cosim::Variable;

/// Number of rows in all pieces.
pub(crate) const fn count<M>(pieces: &[&[Variable<M>]]) -> usize {
    let (mut total, mut piece) = (0, 0);
    while piece < pieces.len() {
        total += pieces[piece].len();
        piece += 1;
    }
    total
}

/// All rows of all pieces, in order; `N` is their [`count`].
pub(crate) const fn join<M, const N: usize>(pieces: &[&[Variable<M>]]) -> [Variable<M>; N] {
    let mut rows = [pieces[0][0]; N];
    let (mut next, mut piece) = (0, 0);
    while piece < pieces.len() {
        let mut row = 0;
        while row < pieces[piece].len() {
            rows[next] = pieces[piece][row];
            next += 1;
            row += 1;
        }
        piece += 1;
    }
    rows
}

/// A table made of pieces: `table!(Model: PIECE, PIECE, …)`.
macro_rules! table {
    ($model:ty: $($piece:expr),+ $(,)?) => {{
        const PIECES: &[&[fmi2_cosim::Variable<$model>]] = &[$(&$piece),+];
        const ROWS: [fmi2_cosim::Variable<$model>; $crate::rows::count(PIECES)] =
            $crate::rows::join(PIECES);
        &ROWS
    }};
}

pub(crate) use table;
