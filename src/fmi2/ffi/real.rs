//! Where the Reals of a model lie, found by the compiler: every exchange sets and gets through here.
//!
//! An accessor is a function, and to call one costs more than to move the value. So [`real`] is a
//! `match` with an arm per row. An arm calls the accessor on the very model it is asked about and
//! measures how far from its start the field lies. Where the accessor does no more than point at a
//! field, that is a constant, and the compiler turns the whole `match` into a table of numbers. A field
//! that does not lie in the model itself (in a `Box`, say) and rows beyond the arms have no place here;
//! they go the ordinary way.

use crate::saved::Saved;
use crate::{Access, Causality, Model, State, Variability, Variable};
use core::mem::{offset_of, size_of};
use core::ptr::{from_mut, from_ref};

/// Bit that every row has.
const ANY: usize = 1 << 31;
/// Bit of what has no place, or is no Real.
const ELSEWHERE: usize = 1 << 30;
/// Bit of what the model computes.
const COMPUTED: usize = 1 << 29;
/// Bit of parameters that do not change after initialisation.
const FIXED: usize = 1 << 28;
/// The bits that are the distance from the start of [`Saved`].
const DISTANCE: usize = FIXED - 1;
/// Rows that have an arm.
const ARMS: u32 = 128;

/// What is known of a Real.
#[derive(Clone, Copy)]
struct Real {
    /// Bits of its role, and its distance from the start of [`Saved`].
    place: usize,
    /// Smallest legal value; finite.
    low: f64,
    /// Largest legal value; finite.
    high: f64,
    /// A bit that is its own, or shared with few others; far below the bits of u64, so that sums fit.
    bit: u64,
}

/// Whether all references are Reals that have a place.
#[inline(always)]
pub(crate) fn readable<M: Model>(saved: &mut Saved<M>, references: &[u32]) -> bool {
    let mut places = 0;
    for &reference in references {
        if reference >= ARMS {
            return false;
        }
        places |= real(saved, reference).place;
    }
    places & ELSEWHERE == 0
}

/// Whether it is plain that these values may be set now. If it is not, the ordinary way finds out.
#[inline(always)]
pub(crate) fn settable<M: Model>(saved: &mut Saved<M>, references: &[u32], values: &[f64]) -> bool {
    let barred = barred(saved.state);
    let (mut places, mut seen, mut sum) = (ANY, 0, 0_u64);
    for (&reference, &value) in references.iter().zip(values) {
        let known = real(saved, reference);
        if reference >= ARMS || !(known.low..=known.high).contains(&value) {
            return false;
        }
        places |= known.place;
        seen |= known.bit;
        sum += known.bit;
    }
    // Bits that are there once add up to what they are together.
    places & barred == 0 && seen == sum
}

/// Bits of rows that may not be set in a state.
const fn barred(state: State) -> usize {
    match state {
        State::Instantiated | State::Initialization => ELSEWHERE | COMPUTED,
        State::StepComplete => ELSEWHERE | COMPUTED | FIXED,
        State::Terminated | State::Error => ANY,
    }
}

/// The Real of a reference that is [`readable`] or [`settable`]; of any other one, none or another.
#[inline(always)]
pub(crate) fn field<M: Model>(saved: &mut Saved<M>, reference: u32) -> Option<&mut f64> {
    if reference >= ARMS {
        return None;
    }
    let distance = real(saved, reference).place & DISTANCE;
    // SAFETY: just now and on this very `saved`, `arm` measured the distance to an f64 that lies in it;
    // that of `nowhere` leads to an f64 as well. The result borrows all of `saved`.
    Some(unsafe { &mut *from_mut(saved).byte_add(distance).cast::<f64>() })
}

impl Real {
    const fn nowhere<M>() -> Self {
        Self {
            place: ELSEWHERE | offset_of!(Saved<M>, time),
            low: f64::MIN,
            high: f64::MAX,
            bit: 0,
        }
    }

    /// The row, with a distance still to be measured.
    const fn of<M>(row: &Variable<M>, index: usize) -> Self {
        let role = match (row.causality, row.variability) {
            (Causality::Output | Causality::Local, _) => COMPUTED,
            (Causality::Parameter, Variability::Fixed) => FIXED,
            _ => 0,
        };
        let (low, high) = (row.min, row.max);
        Self {
            place: role,
            low: if let Some(low) = low { low } else { f64::MIN },
            high: if let Some(high) = high {
                high
            } else {
                f64::MAX
            },
            bit: 1 << (index % 32),
        }
    }
}

type Field<M> = fn(&mut M) -> &mut f64;

/// Accessor and role of a row that is a Real.
const fn row<M: Model>(index: usize) -> Option<(Field<M>, Real)> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    match row.access {
        Access::Real(field) => Some((field, Real::of(row, index))),
        _ => None,
    }
}

#[inline(always)]
fn arm<M: Model, const ROW: usize>(saved: &mut Saved<M>) -> Real {
    let Some((field, real)) = (const { row::<M>(ROW) }) else {
        return Real::nowhere::<M>();
    };
    let start = from_ref(saved).addr();
    let distance = from_ref(field(&mut saved.model)).addr().wrapping_sub(start);
    if distance <= size_of::<Saved<M>>() - size_of::<f64>() && distance <= DISTANCE {
        let place = real.place | distance;
        Real { place, ..real }
    } else {
        Real::nowhere::<M>()
    }
}

macro_rules! match_rows {
    ($reference:ident, $saved:ident: $($row:literal)*) => {
        match $reference % ARMS {
            $($row => arm::<M, $row>($saved),)*
            _ => Real::nowhere::<M>(),
        }
    };
}

#[rustfmt::skip] // a list
#[inline(always)]
fn real<M: Model>(saved: &mut Saved<M>, reference: u32) -> Real {
    match_rows!(reference, saved:
        0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33
        34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63
        64 65 66 67 68 69 70 71 72 73 74 75 76 77 78 79 80 81 82 83 84 85 86 87 88 89 90 91 92 93
        94 95 96 97 98 99 100 101 102 103 104 105 106 107 108 109 110 111 112 113 114 115 116 117
        118 119 120 121 122 123 124 125 126 127
    )
}

#[cfg(test)]
mod tests {
    use super::{ARMS, field, readable, settable};
    use crate::saved::Saved;
    use crate::{Experiment, Failure, Log, Model, State, StateFields, Unit, Variable};

    /// Reals in the model and outside of it, of every role.
    #[derive(Clone)]
    struct Shelf {
        near: [f64; 200],
        far: Box<f64>,
        count: i32,
    }

    impl Default for Shelf {
        fn default() -> Self {
            let near = core::array::from_fn(|index| f64::from(u8::try_from(index).unwrap()));
            Self {
                near,
                far: Box::new(-1.0),
                count: 0,
            }
        }
    }

    const fn near<const K: usize>() -> Variable<Shelf> {
        Variable::input("near", Unit::ONE, |m: &mut Shelf| &mut m.near[K], "")
    }

    const INPUT: u32 = 0;
    const TUNABLE: u32 = 1;
    const FIXED: u32 = 2;
    const OUTPUT: u32 = 3;
    const INTEGER: u32 = 4;
    const FAR: u32 = 5;
    const ONE_OF_MANY: u32 = 32; // shares its bit with INPUT
    const BEYOND: u32 = ARMS;

    impl Model for Shelf {
        const NAME: &'static str = "Shelf";
        const DESCRIPTION: &'static str = "";
        const EXPERIMENT: Experiment = Experiment {
            start: 0.0,
            stop: 1.0,
            step: 0.1,
        };
        const VARIABLES: &'static [Variable<Self>] = &{
            let mut rows = [near::<150>(); 130];
            rows[0] = near::<0>().min(-1.0).max(2.0);
            rows[1] =
                Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[1], "").tunable();
            rows[2] = Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[2], "");
            rows[3] = Variable::output("", Unit::ONE, |m: &mut Self| &mut m.near[3], "");
            rows[4] = Variable::integer_input("", |m: &mut Self| &mut m.count, "");
            rows[5] = Variable::input("", Unit::ONE, |m: &mut Self| &mut m.far, "");
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

    fn shelf(state: State) -> Saved<Shelf> {
        Saved {
            state,
            ..Saved::new()
        }
    }

    #[test]
    fn a_reference_leads_to_the_field_of_its_row() {
        let mut shelf = shelf(State::StepComplete);
        let expected = [
            (INPUT, 0.0),
            (TUNABLE, 1.0),
            (FIXED, 2.0),
            (OUTPUT, 3.0),
            (ONE_OF_MANY, 150.0),
        ];
        for (reference, value) in expected {
            assert!(readable(&mut shelf, &[reference]));
            assert_eq!(field(&mut shelf, reference).copied(), Some(value));
            *field(&mut shelf, reference).unwrap() += 0.5;
        }
        assert_eq!(shelf.model.near[..4], [0.5, 1.5, 2.5, 3.5]);
        assert_eq!(shelf.model.near[150], 150.5);
    }

    #[test]
    fn what_is_no_real_in_the_model_itself_goes_the_ordinary_way() {
        let mut shelf = shelf(State::StepComplete);
        for reference in [INTEGER, FAR, BEYOND, BEYOND + 1, BEYOND + 2, u32::MAX] {
            assert!(!readable(&mut shelf, &[INPUT, reference]), "{reference}");
            assert!(
                !settable(&mut shelf, &[INPUT, reference], &[0.0; 2]),
                "{reference}"
            );
        }
        assert_eq!((*shelf.model.far, shelf.model.count), (-1.0, 0));
    }

    #[test]
    fn roles_and_states_tell_what_is_settable() {
        use State::{Error, Initialization, Instantiated, StepComplete, Terminated};
        let (early, late) = (
            [Instantiated, Initialization].as_slice(),
            [StepComplete].as_slice(),
        );
        let cases = [
            (INPUT, early, late),
            (TUNABLE, early, late),
            (FIXED, early, &[]),
            (OUTPUT, &[], &[]),
        ];
        for (reference, early, late) in cases {
            for state in [
                Instantiated,
                Initialization,
                StepComplete,
                Terminated,
                Error,
            ] {
                let legal = early.contains(&state) || late.contains(&state);
                let found = settable(&mut shelf(state), &[reference], &[0.0]);
                assert_eq!(found, legal, "{reference} in {state}");
            }
        }
    }

    #[test]
    fn values_that_are_not_finite_or_out_of_range_and_repetitions_need_a_second_look() {
        let mut shelf = shelf(State::StepComplete);
        for (value, plain) in [(-1.0, true), (2.0, true), (-1.1, false), (2.1, false)] {
            assert_eq!(settable(&mut shelf, &[INPUT], &[value]), plain, "{value}");
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!settable(&mut shelf, &[INPUT], &[value]));
            assert!(!settable(&mut shelf, &[TUNABLE], &[value]));
        }
        assert!(settable(&mut shelf, &[TUNABLE], &[f64::MAX]));
        for twice in [[INPUT, INPUT], [TUNABLE, TUNABLE], [INPUT, ONE_OF_MANY]] {
            assert!(!settable(&mut shelf, &twice, &[0.0; 2]));
        }
    }
}
