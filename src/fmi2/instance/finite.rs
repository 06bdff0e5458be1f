//! Whether all that a model computed are numbers: asked after every step.
//!
//! A sum is a number if all its terms are, or nearly: terms that are too large for one add up to an infinity.
//! So only a sum that is none gives a reason to look at the terms one by one. The compiler knows which rows
//! are meant, and makes one addition of each.

use super::Reals;
use crate::{Access, Causality, Model};

/// Rows of a block, and blocks.
const SIDE: usize = 16;
/// Rows that are in the sum.
const SUMMED: usize = SIDE * SIDE;

/// The field of a row that is a Real, and that the model computes.
const fn field<M: Model>(index: usize) -> Option<Reals<M>> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    match (row.access, row.causality) {
        (Access::Real(field), Causality::Output | Causality::Local) => Some(field),
        _ => None,
    }
}

/// The value of such a row; of another one what changes no sum.
#[inline(always)]
fn term<M: Model, const BLOCK: usize, const ROW: usize>(model: &mut M) -> f64 {
    match const { field::<M>(BLOCK * SIDE + ROW) } {
        Some(field) => *field(model),
        None => -0.0,
    }
}

/// The sum of `f::<0>()` to `f::<15>()`. A macro, as the row has to be a constant in each term: a generic function could
/// not count, for its next parameter would be an expression of a parameter (`generic_const_exprs`).
macro_rules! sixteen {
    ($k:ident => $term:expr) => {
        sixteen!($k => $term; 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15)
    };
    ($k:ident => $term:expr; $($number:literal)*) => {
        -0.0 $(+ { const $k: usize = $number; $term })*
    };
}

#[inline(always)]
fn block<M: Model, const BLOCK: usize>(model: &mut M) -> f64 {
    sixteen!(ROW => term::<M, BLOCK, ROW>(model))
}

/// All outputs and local variables of type Real are numbers; false where that takes a look at each.
#[inline(always)]
pub(super) fn surely<M: Model>(model: &mut M) -> bool {
    let sum: f64 = sixteen!(BLOCK => block::<M, BLOCK>(model));
    sum.is_finite() && const { M::VARIABLES.len() <= SUMMED }
}

#[cfg(test)]
mod tests {
    use super::surely;
    use crate::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

    /// Outputs on both sides of the end of a block, a local variable, and an input.
    #[derive(Clone, Default)]
    struct Row([f64; 4]);

    const fn output<const K: usize>() -> Variable<Row> {
        Variable::output("y", Unit::ONE, |m: &mut Row| &mut m.0[K], "")
    }

    impl Model for Row {
        const NAME: &'static str = "Row";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
        const VARIABLES: &'static [Variable<Self>] = &{
            let mut rows = [output::<0>(); 40];
            rows[15] = output::<1>();
            rows[16] = output::<2>().local();
            rows[39] = Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.0[3], "");
            rows
        };

        fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
            Ok(())
        }

        fn hidden_state(&mut self, _: &mut dyn StateFields) {}
    }

    #[test]
    fn what_is_computed_has_to_be_a_number() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for (place, sure) in [(0, false), (1, false), (2, false), (3, true)] {
                let mut row = Row([1.0; 4]);
                row.0[place] = bad;
                assert_eq!(surely(&mut row), sure, "{bad} at {place}");
            }
        }
        assert!(surely(&mut Row([0.0; 4])) && surely(&mut Row([1.0, -f64::MAX, f64::MAX, 0.0])));
    }

    #[test]
    fn infinities_that_cancel_and_numbers_too_large_for_a_sum_need_a_look_at_each() {
        assert!(!surely(&mut Row([
            0.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.0
        ])));
        assert!(!surely(&mut Row([0.0, f64::MAX, f64::MAX, 0.0])));
    }
}
