//! Where the variables of a model lie, found by the compiler: every exchange sets and gets through here.
//!
//! An accessor is a function, and to call one costs more than to move the value. So [`known`] is a
//! `match` with an arm per row. An arm calls the accessor on the very model it is asked about and
//! measures how far from its start the field lies. Where the accessor does no more than point at a
//! field, that is a constant, and the compiler turns the whole `match` into a table of numbers. A field
//! that does not lie in the model itself (in a `Box`, say), parameters and rows beyond the arms have no place
//! here; they go the ordinary way. [`place`] is the same for Integers and Booleans.

mod other;

pub use other::Other;

use crate::saved::Saved;
use crate::value::Field;
use crate::{Access, Causality, Model, Variable};
use core::mem::{offset_of, size_of};
use core::ptr::{from_mut, from_ref};

/// Rows that have an arm: those whose reference is a byte.
const ARMS: u32 = 256;
/// Bits of a word that a row shares with few others: from the lowest one on.
const OWN: u32 = 24;
/// Bit of what has no place, or is no Real.
const ELSEWHERE: u32 = 1 << OWN;
/// Bit of what the model computes.
const COMPUTED: u32 = 2 << OWN;
/// Bit of what is computed on demand.
const ON_DEMAND: u32 = 4 << OWN;
/// Bits of what cannot be set at a communication point.
const FIXED: u32 = ELSEWHERE | COMPUTED;

/// Bits of the place of another type than Real: how far it lies from the start of [`Saved`], in bytes.
const NEAR: u32 = (1 << 28) - 1;
/// Bit of the place of what is computed on demand.
const LATE: u32 = 1 << 28;

/// Reals that are read side by side, where there are so many.
const FOUR: usize = 4;
const MANY: usize = 12;

/// What is known of a variable.
#[derive(Clone, Copy)]
struct Known {
    /// Its own bit, those of its role and whether it is a Real that has a place.
    word: u32,
    /// Bytes from the start of [`Saved`] to it; of what is no Real that has a place, to the time.
    distance: u32,
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
/// be watched at that, and what is computed on demand is a number; else it returns false, and what it wrote is void.
///
/// `wanted`: many of which some are computed on demand were asked for after the last step.
#[inline(always)]
pub(crate) fn get<M: Model>(
    saved: &mut Saved<M>,
    wanted: &mut bool,
    references: &[u32],
    values: &mut [f64],
) -> bool {
    if cfg!(not(fmi2_small)) && references.len() >= MANY {
        return get_many(saved, wanted, references, values);
    }
    let mut words = 0;
    for &reference in references.iter().rev() {
        if reference >= ARMS {
            return false;
        }
        words |= known(saved, reference).word;
    }
    let on_demand = const { some_on_demand::<M>() } && words & ON_DEMAND != 0;
    let plain = words & ELSEWHERE == 0 && (!(on_demand && saved.late) || computed(saved));
    if plain {
        for (&reference, value) in references.iter().zip(values.iter_mut()).rev() {
            *value = *field(saved, reference);
        }
    }
    plain && (!on_demand || values.iter().sum::<f64>().is_finite())
}

/// [`get`] in one pass. What is computed on demand is computed before it, where it was `wanted` last time; where that
/// changes, the answer is false once.
#[inline(always)]
fn get_many<M: Model>(
    saved: &mut Saved<M>,
    wanted: &mut bool,
    references: &[u32],
    values: &mut [f64],
) -> bool {
    if !const { some_on_demand::<M>() } {
        let (words, _) = read(saved, references, values);
        return words & ELSEWHERE == 0;
    }
    let was_late = saved.late;
    if was_late && *wanted && !computed(saved) {
        return false;
    }
    let (words, sum) = read(saved, references, values);
    let on_demand = words & ON_DEMAND != 0;
    *wanted = if was_late { on_demand } else { *wanted };
    // What is no number, or too large for a sum, the ordinary way tells.
    words & ELSEWHERE == 0 && (!on_demand || (!saved.late && sum.is_finite()))
}

/// All bits of the words and of the references of Reals that were read, and sums side by side.
#[derive(Default)]
struct Seen {
    words: u32,
    references: u32,
    sums: [f64; FOUR],
}

/// Reads Reals; returns all bits of their words, [`ELSEWHERE`] where one is no Real that has a place, and their sum.
///
/// Four at a time, as a loop around each takes half as long again.
#[inline(never)] // it saves registers, which few values are not worth; and as all bits go out, `known` is a table
fn read<M: Model>(saved: &mut Saved<M>, references: &[u32], values: &mut [f64]) -> (u32, f64) {
    let mut seen = Seen::default();
    let (references, few) = references.as_chunks::<FOUR>();
    let (values, few_values) = values.as_chunks_mut::<FOUR>();
    for ([a, b, c, d], [to_a, to_b, to_c, to_d]) in references.iter().zip(values) {
        read_one::<M, 0>(saved, *a, to_a, &mut seen);
        read_one::<M, 1>(saved, *b, to_b, &mut seen);
        read_one::<M, 2>(saved, *c, to_c, &mut seen);
        read_one::<M, 3>(saved, *d, to_d, &mut seen);
    }
    for (reference, value) in few.iter().zip(few_values) {
        read_one::<M, 0>(saved, *reference, value, &mut seen);
    }
    let beyond = u32::from(seen.references >= ARMS) << OWN; // ELSEWHERE
    (seen.words | beyond, seen.sums.iter().sum())
}

#[inline(always)]
fn read_one<M: Model, const SUM: usize>(
    saved: &mut Saved<M>,
    reference: u32,
    value: &mut f64,
    seen: &mut Seen,
) {
    seen.references |= reference;
    seen.words |= known(saved, reference).word;
    *value = *field(saved, reference);
    if const { some_on_demand::<M>() } {
        seen.sums[SUM] += *value;
    }
}

/// Reads values of another type if all references are of that type and have a place, and none waits to be computed;
/// else it does nothing and returns false.
#[inline(always)]
pub(crate) fn get_others<M: Model, T: Other, A: From<T>>(
    saved: &mut Saved<M>,
    references: &[u32],
    values: &mut [A],
) -> bool {
    for &reference in references {
        let place = place(saved, reference);
        let waits = const { some_on_demand::<M>() } && place & LATE != 0 && saved.late;
        if reference >= ARMS || place & T::BIT == 0 || waits {
            return false;
        }
    }
    for (&reference, value) in references.iter().zip(values).rev() {
        let distance = place(saved, reference) & NEAR;
        // SAFETY: just now and on this very `saved`, `other_arm` measured the distance to a T that lies in it; should an
        // accessor lead elsewhere when it is asked again, that to the time.
        let told = unsafe { T::at(from_ref(saved).byte_add(distance as usize).cast()) };
        *value = told.into();
    }
    true
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
    let (mut words, mut sum) = (FIXED, u64::from(FIXED));
    for &reference in references.iter().rev() {
        if reference >= ARMS {
            return false;
        }
        let known = known(saved, reference);
        value = value.wrapping_sub(1);
        // SAFETY: it is within `values`: one step back from its end for each of as many references.
        if !(known.low..=known.high).contains(unsafe { &*value }) {
            return false;
        }
        words |= known.word;
        sum = sum.wrapping_add(known.word.into());
    }
    let plain = sum == words.into();
    if plain {
        for (&reference, &value) in references.iter().zip(values).rev() {
            // It is a Real that has a place: no word has the bit `ELSEWHERE`, or the sum would exceed `words`.
            *field(saved, reference) = value;
        }
    }
    plain
}

/// The Real of a reference; of what is no Real that has a place, the time.
#[inline(always)]
fn field<M: Model>(saved: &mut Saved<M>, reference: u32) -> &mut f64 {
    let distance = known(saved, reference).distance;
    // SAFETY: just now and on this very `saved`, `arm` measured the distance to an f64 that lies in it; that of `nowhere`
    // leads to one, too. The result borrows all of `saved`.
    unsafe { &mut *from_mut(saved).byte_add(distance as usize).cast::<f64>() }
}

impl Known {
    /// What is no Real that has a place.
    #[inline(always)]
    fn nowhere<M>() -> Self {
        Self {
            word: ELSEWHERE,
            distance: to_time::<M>(),
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
            distance: 0,
            low: if let Some(low) = low { low } else { f64::MIN },
            high: if let Some(high) = high {
                high
            } else {
                f64::MAX
            },
        }
    }
}

/// Accessor and role of a Real that is no parameter.
const fn row<M: Model>(index: usize) -> Option<(Field<M, f64>, Known)> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    match (row.causality, row.access) {
        // To reach a parameter a model may have to do more than to point at it.
        (Causality::Parameter, _) => None,
        (_, Access::Real(field)) => Some((field, Known::of(row, index))),
        _ => None,
    }
}

/// Accessor of an Integer or a Boolean that is no parameter, and the bits of its place.
const fn other_row<M: Model>(index: usize) -> Option<(Access<M>, u32)> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    let kind = match (row.causality, row.access) {
        (Causality::Parameter, _) => return None,
        (_, Access::Integer(_) | Access::Enumeration(..)) => i32::BIT,
        (_, Access::Boolean(_)) => bool::BIT,
        _ => return None,
    };
    Some((row.access, if row.on_demand { kind | LATE } else { kind }))
}

/// Index of a row that is counted from -128 on.
const fn index(row: i8) -> usize {
    row.cast_unsigned().wrapping_add(128) as usize
}

/// How far from the start of [`Saved`] its time lies [B].
#[inline(always)]
fn to_time<M>() -> u32 {
    u32::try_from(offset_of!(Saved<M>, time)).unwrap_or_default()
}

/// How far from the start of `saved` a field of its model lies [B], if it lies in there.
#[inline(always)]
fn distance<M: Model, T>(saved: &mut Saved<M>, field: Field<M, T>) -> Option<u32> {
    const { assert!(size_of::<Saved<M>>() <= NEAR as usize) };
    let start = from_ref(saved).addr();
    let distance = from_ref(field(&mut saved.model)).addr().wrapping_sub(start);
    let inside = distance <= size_of::<Saved<M>>() - size_of::<T>();
    u32::try_from(distance).ok().filter(|_| inside)
}

#[inline(always)]
fn arm<M: Model, const ROW: i8>(saved: &mut Saved<M>) -> Known {
    let Some((field, known)) = (const { row::<M>(index(ROW)) }) else {
        return Known::nowhere::<M>();
    };
    match distance(saved, field) {
        Some(distance) => Known { distance, ..known },
        None => Known::nowhere::<M>(),
    }
}

#[inline(always)]
fn other_arm<M: Model, const ROW: i8>(saved: &mut Saved<M>) -> u32 {
    let Some((access, bits)) = (const { other_row::<M>(index(ROW)) }) else {
        return to_time::<M>();
    };
    let distance = match access {
        Access::Integer(field) | Access::Enumeration(field, _) => distance(saved, field),
        Access::Boolean(field) => distance(saved, field),
        Access::Real(_) | Access::String(_) => None,
    };
    distance.map_or(to_time::<M>(), |distance| bits | distance)
}

/// A macro, as an arm per row is written out: the compiler makes a table of a `match` on literals, and no generic
/// function has a number of arms.
///
/// The rows are counted from -128 on, as the compiler counts them when it makes the table: so it need not
/// convert.
#[rustfmt::skip] // a list
macro_rules! match_rows {
    ($arm:ident, $reference:ident, $saved:ident: $($row:literal)*) => {
        match ($reference % ARMS).to_le_bytes()[0].wrapping_sub(128).cast_signed() {
            $($row => $arm::<M, $row>($saved),)*
        }
    };
    ($arm:ident, $reference:ident, $saved:ident) => {
        match_rows!($arm, $reference, $saved:
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
    };
}

/// What is known of a reference's row; of references beyond the arms, another one's.
#[inline(always)]
fn known<M: Model>(saved: &mut Saved<M>, reference: u32) -> Known {
    match_rows!(arm, reference, saved)
}

/// Place and type of an Integer or a Boolean; that of the time, and no type, of what is none, is a parameter, or does not
/// lie in `saved`; of references beyond the arms, another one's.
#[inline(always)]
fn place<M: Model>(saved: &mut Saved<M>, reference: u32) -> u32 {
    match_rows!(other_arm, reference, saved)
}

#[cfg(test)]
mod tests;
