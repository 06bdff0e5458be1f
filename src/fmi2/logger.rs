//! Log messages: which ones the importer wants, and their text in a fixed buffer.

use crate::{Category, Error, Status};
use core::ffi::CStr;
use core::fmt::{self, Write};

/// Bytes of a message with its closing NUL: what C importers commonly reserve for one.
const CAPACITY: usize = 1000;

impl Category {
    /// All categories, in the order of the model description.
    pub const ALL: [Self; 5] = [
        Self::Event,
        Self::Warning,
        Self::Discard,
        Self::Error,
        Self::Fatal,
    ];

    /// Its name in `LogCategories`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.c_name().to_str().unwrap_or_default()
    }

    pub(crate) const fn c_name(self) -> &'static CStr {
        match self {
            Self::Event => c"logEvents",
            Self::Warning => c"logStatusWarning",
            Self::Discard => c"logStatusDiscard",
            Self::Error => c"logStatusError",
            Self::Fatal => c"logStatusFatal",
        }
    }

    /// The status a message of this category is logged with.
    pub(crate) const fn status(self) -> Status {
        match self {
            Self::Event => Status::Ok,
            Self::Warning => Status::Warning,
            Self::Discard => Status::Discard,
            Self::Error => Status::Error,
            Self::Fatal => Status::Fatal,
        }
    }

    pub(crate) const fn of(status: Status) -> Self {
        match status {
            Status::Ok => Self::Event,
            Status::Warning => Self::Warning,
            Status::Discard => Self::Discard,
            Status::Error => Self::Error,
            Status::Fatal => Self::Fatal,
        }
    }
}

/// Which categories the importer has enabled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Filter([bool; Category::ALL.len()]);

impl Filter {
    /// All categories, or none.
    pub(crate) const fn all(on: bool) -> Self {
        Self([on; Category::ALL.len()])
    }

    /// What `fmi2SetDebugLogging` asks for: on with the named categories only, or off with them;
    /// all of them when none is named.
    pub(crate) fn requested<'a>(
        self,
        on: bool,
        names: impl Iterator<Item = &'a CStr>,
    ) -> Result<Self, Error> {
        let named = Self::named(names)?;
        if named == Self::all(false) {
            return Ok(Self::all(on));
        }
        let mut filter = if on { Self::all(false) } else { self };
        for (enabled, named) in filter.0.iter_mut().zip(named.0) {
            if named {
                *enabled = on;
            }
        }
        Ok(filter)
    }

    fn named<'a>(names: impl Iterator<Item = &'a CStr>) -> Result<Self, Error> {
        let mut filter = Self::all(false);
        for name in names {
            let mut known = filter.0.iter_mut().zip(Category::ALL);
            let (named, _) = known
                .find(|(_, category)| category.c_name() == name)
                .ok_or(Error::UnknownCategory)?;
            *named = true;
        }
        Ok(filter)
    }

    pub(crate) fn passes(&self, category: Category) -> bool {
        self.0
            .iter()
            .zip(Category::ALL)
            .any(|(&enabled, known)| enabled && known == category)
    }
}

/// A finished message: `%` and `#`, which have a meaning for importers, are doubled, so that it is a
/// format string that prints itself; what does not fit is cut off between characters.
pub(crate) struct Text {
    bytes: [u8; CAPACITY],
    length: usize,
    full: bool,
}

impl Text {
    pub(crate) fn new(message: fmt::Arguments<'_>) -> Self {
        let mut text = Self {
            bytes: [0; CAPACITY],
            length: 0,
            full: false,
        };
        // A Display that fails leaves what it has written so far.
        let _ = text.write_fmt(message);
        text
    }

    pub(crate) fn as_c_str(&self) -> &CStr {
        CStr::from_bytes_until_nul(&self.bytes).unwrap_or_default()
    }

    fn push(&mut self, character: char) {
        let mut buffer = [0; 8];
        let one = character.encode_utf8(&mut buffer).len();
        let doubled = matches!(character, '%' | '#');
        if doubled {
            buffer.copy_within(..one, one);
        }
        let end = self.length + if doubled { 2 * one } else { one };
        // The last byte stays NUL.
        let room = self
            .bytes
            .get_mut(self.length..end)
            .filter(|_| end < CAPACITY && !self.full);
        match room {
            Some(room) => {
                room.iter_mut()
                    .zip(buffer)
                    .for_each(|(to, from)| *to = from);
                self.length = end;
            }
            None => self.full = true,
        }
    }
}

impl Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        // A NUL would hide the rest of the message.
        text.chars()
            .filter(|&character| character != '\0')
            .for_each(|c| self.push(c));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(message: &str) -> Vec<u8> {
        Text::new(format_args!("{message}"))
            .as_c_str()
            .to_bytes()
            .to_vec()
    }

    #[test]
    fn percent_and_hash_are_doubled_and_nul_is_left_out() {
        assert_eq!(text("50 % of #r1#\0!"), b"50 %% of ##r1##!");
    }

    #[test]
    fn long_text_is_cut_to_999_bytes_between_characters() {
        assert_eq!(text(&"x".repeat(2000)).len(), 999);
        assert_eq!(text(&"%".repeat(2000)).len(), 998);
        let cut = text(&"\u{e4}".repeat(2000));
        assert_eq!(cut.len(), 998);
        assert!(core::str::from_utf8(&cut).is_ok());
    }

    #[test]
    fn a_filter_passes_what_is_asked_for() {
        const ERROR: &CStr = c"logStatusError";
        let passed = |filter: Filter| -> Vec<_> {
            let passes = |category: &Category| filter.passes(*category);
            Category::ALL.into_iter().filter(passes).collect()
        };
        let asked = |filter: Filter, on, names: &[&CStr]| {
            passed(filter.requested(on, names.iter().copied()).unwrap())
        };
        let all = Category::ALL.len();
        assert_eq!(asked(Filter::all(true), true, &[ERROR]), [Category::Error]);
        assert_eq!(asked(Filter::all(false), true, &[]).len(), all);
        assert_eq!(asked(Filter::all(true), false, &[]), []);
        assert_eq!(asked(Filter::all(true), false, &[ERROR]).len(), all - 1);
        assert_eq!(asked(Filter::all(false), false, &[ERROR]), []);
        let unknown = Filter::all(true).requested(true, [c"logAll"].into_iter());
        assert_eq!(unknown, Err(Error::UnknownCategory));
    }
}
