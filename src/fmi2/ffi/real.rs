//! Where the variables of a model lie, found by the compiler: every exchange sets and gets through here.
//!
//! An accessor is a function, and to call one costs more than to move the value. So [`known`] is a
//! `match` with an arm per row. An arm calls the accessor on the very model it is asked about and
//! measures how far from its start the field lies. Where the accessor does no more than point at a
//! field, that is a constant, and the compiler turns the whole `match` into a table of numbers. A field
//! that does not lie in the model itself (in a `Box`, say), parameters and rows beyond the arms have no place
//! here; they go the ordinary way.

use crate::saved::Saved;
use crate::value::Value;
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
/// Bit of an Integer or an Enumeration that has a place.
const INTEGER: u32 = 8 << OWN;
/// Bit of a Boolean that has a place.
const BOOLEAN: u32 = 16 << OWN;
/// Bits of what cannot be set at a communication point.
const FIXED: u32 = ELSEWHERE | COMPUTED;

/// A type other than Real whose values have places.
pub trait Other: Value {
    /// Bit of its rows.
    const BIT: u32;
}

impl Other for i32 {
    const BIT: u32 = INTEGER;
}

impl Other for bool {
    const BIT: u32 = BOOLEAN;
}

/// What is known of a variable.
#[derive(Clone, Copy)]
struct Known {
    /// Its own bit, those of its role and type.
    word: u32,
    /// Bytes from the start of [`Saved`] to it.
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
/// be watched at that, and what is computed on demand is a number; else it returns false.
#[inline(always)]
pub(crate) fn get<M: Model>(saved: &mut Saved<M>, references: &[u32], values: &mut [f64]) -> bool {
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
            // SAFETY: it is below `ARMS`, and a Real: no word has the bit `ELSEWHERE`, as all others do.
            *value = *unsafe { field::<M, f64>(saved, reference) };
        }
    }
    plain && (!on_demand || are_numbers(values))
}

/// Reads values of another type if all references are of that type and have a place, and none waits to be computed;
/// else it does nothing and returns false.
#[inline(always)]
pub(crate) fn get_others<M: Model, T: Other, A: From<T>>(
    saved: &mut Saved<M>,
    references: &[u32],
    values: &mut [A],
) -> bool {
    let mut words = 0;
    for &reference in references.iter().rev() {
        let word = known(saved, reference).word;
        if reference >= ARMS || word & T::BIT == 0 {
            return false;
        }
        words |= word;
    }
    if const { some_on_demand::<M>() } && words & ON_DEMAND != 0 && saved.late {
        return false;
    }
    for (&reference, value) in references.iter().zip(values).rev() {
        // SAFETY: it is below `ARMS`, and its word has the bit of the type.
        *value = (*unsafe { field::<M, T>(saved, reference) }).into();
    }
    true
}

/// Whether values are numbers; else, or where they are too large for a sum, the ordinary way tells what is none.
#[inline(never)]
fn are_numbers(values: &[f64]) -> bool {
    let (lanes, rest) = values.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for lane in lanes {
        sums.iter_mut()
            .zip(lane)
            .for_each(|(sum, value)| *sum += value);
    }
    let sum: f64 = sums.iter().chain(rest).sum();
    sum.is_finite()
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
            // SAFETY: it is below `ARMS`, and a Real: no word has the bit `ELSEWHERE`, or the sum would exceed `words`.
            *unsafe { field::<M, f64>(saved, reference) } = value;
        }
    }
    plain
}

/// The field of a reference that is below [`ARMS`].
///
/// # Safety
/// It is one, and a variable of type `T`.
#[inline(always)]
unsafe fn field<M: Model, T>(saved: &mut Saved<M>, reference: u32) -> &mut T {
    let distance = known(saved, reference).distance;
    // SAFETY: just now and on this very `saved`, `arm` measured the distance to a T that lies in it; that of `nowhere`
    // leads to what can be read as one. The result borrows all of `saved`.
    unsafe { &mut *from_mut(saved).byte_add(distance as usize).cast::<T>() }
}

impl Known {
    /// What has no place; its distance leads to something of the same type.
    #[inline(always)]
    fn nowhere<M>(access: Option<Access<M>>) -> Self {
        const { assert!(size_of::<Saved<M>>() as u64 <= u32::MAX as u64) };
        let distance = match access {
            Some(Access::Boolean(_)) => offset_of!(Saved<M>, stale),
            _ => offset_of!(Saved<M>, time), // what an f64 consists of is an i32, too
        };
        Self {
            word: ELSEWHERE,
            distance: u32::try_from(distance).unwrap_or_default(),
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
        let kind = match row.access {
            Access::Real(_) => 0,
            Access::Integer(_) | Access::Enumeration(..) => ELSEWHERE | INTEGER,
            Access::Boolean(_) => ELSEWHERE | BOOLEAN,
            Access::String(_) => ELSEWHERE,
        };
        let (low, high) = (row.min, row.max);
        Self {
            word: role | kind | 1 << (index % OWN as usize),
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

/// Accessor and role of a row that is no parameter.
const fn row<M: Model>(index: usize) -> Option<(Access<M>, Known)> {
    if index >= M::VARIABLES.len() {
        return None;
    }
    let row = &M::VARIABLES[index];
    match row.causality {
        // To reach a parameter a model may have to do more than to point at it.
        Causality::Parameter => None,
        _ => Some((row.access, Known::of(row, index))),
    }
}

/// Index of a row that is counted from -128 on.
const fn index(row: i8) -> usize {
    row.cast_unsigned().wrapping_add(128) as usize
}

/// Address and size of the field that an accessor leads to.
#[inline(always)]
fn place<M>(access: Access<M>, model: &mut M) -> (usize, usize) {
    match access {
        Access::Real(field) => (from_ref(field(model)).addr(), size_of::<f64>()),
        Access::Boolean(field) => (from_ref(field(model)).addr(), size_of::<bool>()),
        Access::String(field) => (from_ref(field(model)).addr(), size_of::<String>()),
        Access::Integer(field) | Access::Enumeration(field, _) => {
            (from_ref(field(model)).addr(), size_of::<i32>())
        }
    }
}

#[inline(always)]
fn arm<M: Model, const ROW: i8>(saved: &mut Saved<M>) -> Known {
    let Some((access, known)) = (const { row::<M>(index(ROW)) }) else {
        return Known::nowhere::<M>(None);
    };
    let start = from_ref(saved).addr();
    let (address, size) = place(access, &mut saved.model);
    let distance = address.wrapping_sub(start);
    match u32::try_from(distance) {
        Ok(near) if distance <= size_of::<Saved<M>>() - size => Known {
            distance: near,
            ..known
        },
        _ => Known::nowhere(Some(access)),
    }
}

/// A macro, as an arm per row is written out: the compiler makes a table of a `match` on literals, and no generic
/// function has a number of arms.
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
fn known<M: Model>(saved: &mut Saved<M>, reference: u32) -> Known {
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
mod tests;
