//! The date of a build: that of `SOURCE_DATE_EPOCH`, none otherwise, so that builds can be repeated.

use crate::{Error, Result};
use std::env;

const VARIABLE: &str = "SOURCE_DATE_EPOCH";

/// The date to state, e.g. `2026-11-27T04:45:00Z`.
///
/// # Errors
/// When the variable is set and is no number of seconds since 1970.
pub(crate) fn given() -> Result<Option<String>> {
    let Some(value) = env::var_os(VARIABLE) else {
        return Ok(None);
    };
    let value = value.to_string_lossy().into_owned();
    match value.parse::<u32>() {
        Ok(seconds) => Ok(Some(iso(seconds))),
        Err(_) => Err(Error::Epoch { value }),
    }
}

/// Seconds since 1970 as ISO 8601 in UTC.
fn iso(seconds: u32) -> String {
    let (day, second) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil(day);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

/// Year, month and day of a day counted from 1970-01-01, by counting years and months off.
fn civil(mut day: u32) -> (u32, u32, u32) {
    let leap = |year: u32| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while day >= 365 + u32::from(leap(year)) {
        day -= 365 + u32::from(leap(year));
        year += 1;
    }
    let mut month = 1;
    for length in [
        31,
        28 + u32::from(leap(year)),
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
        31,
    ] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    (year, month, day + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, date) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (u32::MAX, "2106-02-07T06:28:15Z"),
        ] {
            assert_eq!(iso(seconds), date);
        }
    }
}
