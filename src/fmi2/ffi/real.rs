//! Where the Reals of a model lie, found by the compiler: every exchange sets and gets through here.
//!
//! An accessor is a function, and to call one costs more than to move the value. So [`real`] is a
//! `match` with an arm per row. An arm calls the accessor on the very model it is asked about and
//! measures how far from its start the field lies. Where the accessor does no more than point at a
//! field, that is a constant, and the compiler turns the whole `match` into a table of numbers. A field
//! that does not lie in the model itself (in a `Box`, say), parameters and rows beyond the arms have no place
//! here; they go the ordinary way.

use crate::saved::Saved;
use crate::{Access, Causality, Model, Variable};
use core::mem::{offset_of, size_of};
use core::ptr::{from_mut, from_ref};

/// Rows that have an arm: those whose reference is a byte.
const ARMS: u32 = 256;
/// Bits of a word that a row shares with few others: from the lowest one on.
const OWN: u32 = 24;
/// Bit of what has no place, or is no Real.
const ELSEWHERE: u64 = 1 << 28;
/// Bit of what the model computes.
const COMPUTED: u64 = 1 << 29;
/// Bit of what is computed on demand.
const ON_DEMAND: u64 = 1 << 30;
/// Bits of what cannot be set at a communication point.
const FIXED: u64 = ELSEWHERE | COMPUTED;
/// Where in a word the distance from the start of [`Saved`] begins: above what the bits of [`OWN`] rows add up to.
const DISTANCE: u32 = 36;
/// The largest distance that fits above it.
const FARTHEST: u64 = u64::MAX >> DISTANCE;
const _: () = assert!((OWN as u64 + 1) * (ELSEWHERE | COMPUTED | ON_DEMAND) < 1 << DISTANCE);

/// What is known of a Real.
#[derive(Clone, Copy)]
struct Real {
    /// Its own bit, those of its role, and its distance from the start of [`Saved`].
    word: u64,
    /// Smallest legal value; finite.
    low: f64,
    /// Largest legal value; finite.
    high: f64,
}

/// Reals that may be plain to set in one call: more of them cannot differ in their bits.
pub(crate) const fn most<M: Model>() -> usize {
    let rows = M::VARIABLES.len();
    if rows < OWN as usize {
        rows
    } else {
        OWN as usize
    }
}

/// Whether a model has outputs that are computed on demand.
const fn some_on_demand<M: Model>() -> bool {
    let mut row = 0;
    while row < M::VARIABLES.len() && !M::VARIABLES[row].on_demand {
        row += 1;
    }
    row < M::VARIABLES.len()
}

/// Reads Reals if all references are Reals that have a place, none waits to be computed by a model that has to
/// be watched at that, and what is computed on demand is a number; else it returns false.
#[inline(always)]
pub(crate) fn get<M: Model>(saved: &mut Saved<M>, references: &[u32], values: &mut [f64]) -> bool {
    let mut words = 0;
    for &reference in references.iter().rev() {
        if reference >= ARMS {
            return false;
        }
        words |= real(saved, reference).word;
    }
    let on_demand = const { some_on_demand::<M>() } && words & ON_DEMAND != 0;
    let plain = words & ELSEWHERE == 0 && (!(on_demand && saved.late) || computed(saved));
    if plain {
        for (&reference, value) in references.iter().zip(values.iter_mut()).rev() {
            *value = *field(saved, reference);
        }
    }
    plain && (!on_demand || are_numbers(values))
}

/// Whether values are numbers; else the ordinary way tells what is none.
#[inline(never)]
fn are_numbers(values: &[f64]) -> bool {
    values
        .iter()
        .fold(true, |all, value| all & value.is_finite())
}

/// Computes what waits for it; false where the model has to be watched at that.
#[inline(never)]
fn computed<M: Model>(saved: &mut Saved<M>) -> bool {
    M::STEPS_STAY_FINITE && saved.catch_up()
}

/// Writes values, [`most`] at most, if it is plain that these Reals may be set to them at a communication
/// point; else it does nothing and returns false, and the ordinary way finds out why.
#[inline(always)]
pub(crate) fn set<M: Model>(saved: &mut Saved<M>, references: &[u32], values: &[f64]) -> bool {
    if references.len() != values.len() {
        return false;
    }
    let mut value = values.as_ptr_range().end;
    // Bits that are there once add up to what they are together; those that may not be there are there before.
    let (mut words, mut sum) = (FIXED, FIXED);
    for &reference in references.iter().rev() {
        if reference >= ARMS {
            return false;
        }
        let known = real(saved, reference);
        value = value.wrapping_sub(1);
        // SAFETY: it is the value of the reference; there are as many of both.
        if !(known.low..=known.high).contains(unsafe { &*value }) {
            return false;
        }
        words |= known.word;
        sum = sum.wrapping_add(known.word);
    }
    let plain = (words ^ sum) << (u64::BITS - DISTANCE) == 0;
    if plain {
        for (&reference, &value) in references.iter().zip(values).rev() {
            *field(saved, reference) = value;
        }
    }
    plain
}

/// The Real of a reference that is below [`ARMS`] and has a place; of any other one, another one.
#[inline(always)]
fn field<M: Model>(saved: &mut Saved<M>, reference: u32) -> &mut f64 {
    let distance = real(saved, reference).word >> DISTANCE;
    // SAFETY: just now and on this very `saved`, `arm` measured the distance to an f64 that lies in it;
    // that of `nowhere` leads to an f64 as well. The result borrows all of `saved`.
    unsafe { &mut *from_mut(saved).byte_add(distance as usize).cast::<f64>() }
}

impl Real {
    const fn nowhere<M>() -> Self {
        const { assert!(size_of::<Saved<M>>() as u64 <= FARTHEST) };
        Self {
            word: ELSEWHERE | (offset_of!(Saved<M>, time) as u64) << DISTANCE,
            low: f64::MIN,
            high: f64::MAX,
        }
    }

    /// The row, with a distance still to be measured.
    const fn of<M>(row: &Variable<M>, index: usize) -> Self {
        let role = match row.causality {
            Causality::Output | Causality::Local if row.on_demand => COMPUTED | ON_DEMAND,
            Causality::Output | Causality::Local => COMPUTED,
            _ => 0,
        };
        let (low, high) = (row.min, row.max);
        Self {
            word: role | 1 << (index % OWN as usize),
            low: if let Some(low) = low { low } else { f64::MIN },
            high: if let Some(high) = high {
                high
            } else {
                f64::MAX
            },
        }
    }
}

type Field<M> = fn(&mut M) -> &mut f64;

/// Accessor and role of a row that is a Real, but no parameter.
const fn row<M: Model>(index: usize) -> Option<(Field<M>, Real)> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    match (row.access, row.causality) {
        // To reach a parameter a model may have to do more than to point at it.
        (_, Causality::Parameter) => None,
        (Access::Real(field), _) => Some((field, Real::of(row, index))),
        _ => None,
    }
}

/// Index of a row that is counted from -128 on.
const fn index(row: i8) -> usize {
    row.cast_unsigned().wrapping_add(128) as usize
}

#[inline(always)]
fn arm<M: Model, const ROW: i8>(saved: &mut Saved<M>) -> Real {
    let Some((field, real)) = (const { row::<M>(index(ROW)) }) else {
        return Real::nowhere::<M>();
    };
    let start = from_ref(saved).addr();
    let distance = from_ref(field(&mut saved.model)).addr().wrapping_sub(start);
    if distance <= size_of::<Saved<M>>() - size_of::<f64>() && distance as u64 <= FARTHEST {
        let word = real.word | (distance as u64) << DISTANCE;
        Real { word, ..real }
    } else {
        Real::nowhere::<M>()
    }
}

macro_rules! match_rows {
    ($reference:ident, $saved:ident: $($row:literal)*) => {
        match ($reference % ARMS).to_le_bytes()[0].wrapping_sub(128).cast_signed() {
            $($row => arm::<M, $row>($saved),)*
        }
    };
}

/// What is known of a reference's row; of references beyond the arms, another one's.
///
/// The rows are counted from -128 on, as the compiler counts them when it makes the table: so it need not
/// convert.
#[rustfmt::skip] // a list
#[inline(always)]
fn real<M: Model>(saved: &mut Saved<M>, reference: u32) -> Real {
    match_rows!(reference, saved:
        -128 -127 -126 -125 -124 -123 -122 -121 -120 -119 -118 -117 -116 -115 -114 -113 -112 -111
        -110 -109 -108 -107 -106 -105 -104 -103 -102 -101 -100 -99 -98 -97 -96 -95 -94 -93 -92 -91
        -90 -89 -88 -87 -86 -85 -84 -83 -82 -81 -80 -79 -78 -77 -76 -75 -74 -73 -72 -71 -70 -69 -68
        -67 -66 -65 -64 -63 -62 -61 -60 -59 -58 -57 -56 -55 -54 -53 -52 -51 -50 -49 -48 -47 -46 -45
        -44 -43 -42 -41 -40 -39 -38 -37 -36 -35 -34 -33 -32 -31 -30 -29 -28 -27 -26 -25 -24 -23 -22
        -21 -20 -19 -18 -17 -16 -15 -14 -13 -12 -11 -10 -9 -8 -7 -6 -5 -4 -3 -2 -1 0 1 2 3 4 5 6 7 8
        9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37 38 39
        40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64 65 66 67 68 69 70
        71 72 73 74 75 76 77 78 79 80 81 82 83 84 85 86 87 88 89 90 91 92 93 94 95 96 97 98 99 100
        101 102 103 104 105 106 107 108 109 110 111 112 113 114 115 116 117 118 119 120 121 122 123
        124 125 126 127
    )
}

#[cfg(test)]
mod tests {
    use super::{ARMS, get, set};
    use crate::saved::Saved;
    use crate::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

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
    const FREE: u32 = 6;
    const ONE_OF_MANY: u32 = 24; // shares its bit with INPUT
    const LAST: u32 = ARMS - 1;
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
            let mut rows = [near::<150>(); 260];
            rows[0] = near::<0>().min(-1.0).max(2.0);
            rows[1] =
                Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[1], "").tunable();
            rows[2] = Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[2], "");
            rows[3] = Variable::output("", Unit::ONE, |m: &mut Self| &mut m.near[3], "");
            rows[4] = Variable::integer_input("", |m: &mut Self| &mut m.count, "");
            rows[5] = Variable::input("", Unit::ONE, |m: &mut Self| &mut m.far, "");
            rows[6] = near::<4>();
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
    fn a_reference_leads_to_the_field_of_its_row() {
        let mut shelf = Saved::<Shelf>::new();
        let references = [INPUT, FREE, OUTPUT, ONE_OF_MANY, LAST];
        let mut values = [f64::NAN; 5];
        assert!(get(&mut shelf, &references, &mut values));
        assert_eq!(values, [0.0, 4.0, 3.0, 150.0, 150.0]);
        assert!(set(&mut shelf, &[FREE, LAST], &[-0.5, 7.0]));
        assert_eq!(shelf.model.near[..5], [0.0, 1.0, 2.0, 3.0, -0.5]);
        assert_eq!(shelf.model.near[150], 7.0);
    }

    #[test]
    fn what_is_no_real_in_the_model_itself_goes_the_ordinary_way() {
        let mut shelf = Saved::<Shelf>::new();
        let mut values = [f64::NAN; 2];
        for reference in [
            TUNABLE,
            FIXED,
            INTEGER,
            FAR,
            BEYOND,
            BEYOND + 1,
            BEYOND + 2,
            u32::MAX,
        ] {
            let references = [INPUT, reference];
            assert!(!get(&mut shelf, &references, &mut values), "{reference}");
            assert!(!set(&mut shelf, &references, &[1.0; 2]), "{reference}");
        }
        assert!(values.iter().all(|value| value.is_nan()));
        let Shelf { near, far, count } = shelf.model;
        assert_eq!((near[0], *far, count), (0.0, -1.0, 0));
    }

    /// Whether it is plain to set these; if it is not, nothing changes.
    fn plain(references: &[u32], values: &[f64]) -> bool {
        let mut shelf = Saved::<Shelf>::new();
        let before = shelf.model.near;
        let plain = set(&mut shelf, references, values);
        assert!(plain || shelf.model.near == before);
        plain
    }

    #[test]
    fn inputs_are_plain_to_set() {
        for (reference, expected) in [
            (INPUT, true),
            (FREE, true),
            (TUNABLE, false),
            (FIXED, false),
            (OUTPUT, false),
        ] {
            assert_eq!(plain(&[reference], &[0.5]), expected, "{reference}");
            assert_eq!(
                plain(&[LAST, reference], &[0.5; 2]),
                expected,
                "{reference}"
            );
        }
    }

    #[test]
    fn values_that_are_not_finite_or_out_of_range_and_repetitions_need_a_second_look() {
        for (value, expected) in [(-1.0, true), (2.0, true), (-1.1, false), (2.1, false)] {
            assert_eq!(plain(&[INPUT], &[value]), expected, "{value}");
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!plain(&[INPUT], &[value]));
            assert!(!plain(&[LAST, FREE], &[0.0, value]));
            assert!(!plain(&[FREE], &[value]));
        }
        assert!(plain(&[FREE], &[f64::MAX]));
        for twice in [[INPUT, INPUT], [FREE, FREE], [INPUT, ONE_OF_MANY]] {
            assert!(!plain(&twice, &[0.0; 2]));
        }
        for reference in [FREE, OUTPUT, FAR] {
            let many = [reference; super::OWN as usize];
            assert!((2..=many.len()).all(|count| !plain(&many[..count], &[0.0; 24][..count])));
        }
    }
}
