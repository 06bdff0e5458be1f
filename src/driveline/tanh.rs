//! tanh in one division: the nearest one of a table, and the addition theorem from there.
//!
//! Between two places b apart, with the Padé approximant n/d of tanh b,
//!
//! tanh (a + b) = (tanh a + n/d)/(1 + tanh a n/d) = (d tanh a + n)/(d + n tanh a).
//!
//! The table is made when this is compiled.

/// Argument beyond which tanh is 1 to the last bit: 2/(1 + exp 2x) is less than half a unit of it from 55/2 ln 2 on.
pub(crate) const SATURATED: f64 = 19.0625;
/// Distance of two places of the table, no rounding in its multiples.
const STEP: f64 = 0.25;
/// Change of an argument up to which the approximant of tanh of it is exact to round-off: its error is x¹⁰/10⁷ of it.
pub(crate) const NEAR: f64 = 0.5 * STEP;
/// tanh at 0, STEP, 2 STEP ... up to the one that is nearest to [`SATURATED`].
const TABLE: [f64; 78] = table();
/// More than the table has, a power of 2.
const PLACES: u64 = 128;
/// Added to a small number it leaves a whole number in the last bits.
const ROUND: f64 = 1.5 / f64::EPSILON;

/// A fraction that is a tanh.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fraction {
    pub(crate) above: f64,
    pub(crate) below: f64,
}

impl Fraction {
    #[inline(always)]
    pub(crate) const fn value(&self) -> f64 {
        self.above / self.below
    }
}

/// tanh (a + b) of tanh a and b, |b| ≤ [`NEAR`]; b (945 + 105 b² + b⁴) over 945 + 420 b² + 15 b⁴ is tanh b.
#[inline(always)]
pub(crate) const fn of_sum(tanh_a: f64, b: f64) -> Fraction {
    let square = b * b;
    let above = b * (945.0 + square * (105.0 + square));
    let below = 945.0 + square * (420.0 + square * 15.0);
    Fraction {
        above: tanh_a * below + above,
        below: below + tanh_a * above,
    }
}

/// tanh x, to three units of the last place.
#[inline(always)]
pub(crate) fn tanh(x: f64) -> f64 {
    let size = x.abs();
    if size >= SATURATED {
        return 1.0_f64.copysign(x);
    }
    let rounded = size * (1.0 / STEP) + ROUND;
    let place = (rounded.to_bits() % PLACES) as usize;
    let here = TABLE[place.min(TABLE.len() - 1)];
    of_sum(here, size - (rounded - ROUND) * STEP)
        .value()
        .copysign(x)
}

/// From m = 1 − exp(−2x), which grows by the same part of what is left: tanh x = m/(2 − m).
const fn table() -> [f64; 78] {
    let half = of_sum(0.0, NEAR).value();
    let step = of_sum(half, NEAR).value();
    let (share, mut m) = (2.0 * step / (1.0 + step), 0.0);
    let (mut table, mut k) = ([0.0; 78], 1);
    while k < table.len() {
        m += (1.0 - m) * share;
        table[k] = m / (2.0 - m);
        k += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::{NEAR, SATURATED, TABLE, of_sum, tanh};
    use nalgebra::ComplexField;

    /// Units in the last place of 1.
    const ROUND_OFF: f64 = 4.0 * f64::EPSILON;

    #[test]
    fn it_is_tanh_to_round_off_with_its_sign() {
        for k in -30_000..=30_000_i32 {
            let x = f64::from(k) * 1e-3 + 1e-7;
            let wanted: f64 = ComplexField::tanh(x);
            assert!((tanh(x) - wanted).abs() <= ROUND_OFF * wanted.abs(), "{x}");
            assert_eq!(tanh(-x).to_bits(), (-tanh(x)).to_bits());
        }
    }

    #[test]
    fn it_is_1_where_it_is_said_to_be_and_odd_numbers_do_no_harm() {
        assert!((1.0 - TABLE[TABLE.len() - 1]).abs() < f64::EPSILON);
        for x in [SATURATED, 22.0, 1e9, f64::INFINITY] {
            let wanted: f64 = ComplexField::tanh(x);
            assert_eq!((tanh(x), tanh(-x)), (wanted, -1.0));
        }
        assert!(tanh(f64::NAN).is_nan());
        assert_eq!(tanh(-0.0).to_bits(), (-0.0_f64).to_bits());
        assert_eq!(tanh(f64::MIN_POSITIVE), f64::MIN_POSITIVE);
    }

    #[test]
    fn a_sum_is_the_tanh_of_it() {
        for a in [-3.0, -0.4, 0.0, 0.1, 1.0, 18.0_f64] {
            for b in [-NEAR, -1e-3, 0.0, 1e-9, 0.07, NEAR] {
                let wanted: f64 = ComplexField::tanh(a + b);
                let found = of_sum(tanh(a), b).value();
                assert!((found - wanted).abs() <= ROUND_OFF, "{a} {b}");
            }
        }
    }
}
