//! Numbers in sentences.

use core::fmt;

/// A number as people read it: 0.25, 6500, 1e-9; never a row of zeros.
///
/// With a power of ten it has seven digits. The formatter of `core` that writes powers of ten would make
/// a library 4 KiB larger.
pub(crate) struct Number(pub f64);

/// Below and above these, zeros are hard to count.
const PLAIN: core::ops::Range<f64> = 1e-5..1e9;
/// Of seven digits, those behind the point: so many of the last one are 1.
const LAST: f64 = 1e6;
/// Half of the last digit.
const HALF: f64 = 0.5 / LAST;

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || !size.is_finite() || PLAIN.contains(&size) {
            return self.0.fmt(f);
        }
        let (digits, power) = with_power(size);
        write!(f, "{}e{power}", digits.copysign(self.0))
    }
}

/// Digits from 1 to below 10, and their power of ten.
fn with_power(size: f64) -> (f64, i32) {
    const WHOLE: f64 = 1.0 / f64::EPSILON; // added and taken off again it rounds to a whole number
    let (mut digits, mut power) = (size, 0);
    while digits >= 10.0 - HALF {
        (digits, power) = (digits / 10.0, power + 1);
    }
    while digits < 1.0 - HALF {
        (digits, power) = (digits * 10.0, power - 1);
    }
    (((digits * LAST + WHOLE) - WHOLE) / LAST, power)
}

/// A time [s] as sentences tell it: rounded to 1 ns, so that sums of steps show no rounding, as
/// 9.411999999999999 does.
#[derive(Debug, Clone, Copy)]
pub struct Seconds(pub f64);

/// Of a second [1/s].
const NANOSECONDS: f64 = 1e9;
/// Up to here [s] numbers have room for nanoseconds.
const FINE: f64 = 1e6;

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = (self.0 * NANOSECONDS).round() / NANOSECONDS + 0.0; // no -0
        Number(if self.0.abs() < FINE { rounded } else { self.0 }).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::{Number, Seconds};

    #[test]
    fn a_time_shows_no_rounding_of_its_sum() {
        let cases = [
            (0.0, "0"),
            (-1e-12, "0"),
            (9.411_999_999_999_999, "9.412"),
            (0.1 + 0.2, "0.3"),
            (1.234_567_890_4, "1.23456789"),
            (2e-9, "2e-9"),
            (12_345_678.25, "12345678.25"),
            (f64::INFINITY, "inf"),
        ];
        for (time, text) in cases {
            assert_eq!(Seconds(time).to_string(), text);
        }
    }

    #[test]
    fn no_number_is_a_row_of_zeros() {
        let cases = [
            (0.0, "0"),
            (-3.0, "-3"),
            (0.25, "0.25"),
            (6.5e8, "650000000"),
            (1e-9, "1e-9"),
            (-1.5e300, "-1.5e300"),
            (5e-324, "4.940656e-324"),
            (9.999_999_9e-10, "1e-9"),
            (f64::MAX, "1.797693e308"),
            (f64::NAN, "NaN"),
            (f64::NEG_INFINITY, "-inf"),
        ];
        for (value, text) in cases {
            assert_eq!(Number(value).to_string(), text);
        }
    }
}
