//! Everything that makes up an instance: a saved FMU state, in memory and as bytes.
//!
//! ```text
//! magic 8 | version 4 | GUID 16 | length of the payload 8 | checksum of the payload 16 | payload
//! ```
//!
//! All little-endian. The payload holds life cycle, times, all variables of the table but constants, with their
//! rates, and the model's hidden state.

use crate::guid::kept_hash;
use crate::hash::Hash;
use crate::row::{Row, has_constants, has_strings, rows};
use crate::value::{Sealed as _, finite};
use crate::{Access, Causality, Error, Model, State, StateFields, Variability};

const MAGIC: &[u8; 8] = b"FMI2SAVE";
const VERSION: u32 = 2;
/// Bytes before the payload.
const HEADER: usize = 8 + 4 + 16 + 8 + 16;

/// A saved FMU state: the model with its place in the life cycle.
#[derive(Clone, PartialEq)]
pub struct Saved<M> {
    pub(crate) model: M,
    pub(crate) state: State,
    /// End of the last step [s].
    pub(crate) time: f64,
    /// Start time [s].
    pub(crate) start: f64,
    /// Stop time [s]; the largest number when there is none, so that what lies before it is finite.
    pub(crate) stop: f64,
    /// Something was set since the outputs were computed.
    pub(crate) stale: bool,
    /// A step left outputs on demand to be computed.
    pub(crate) late: bool,
}

impl<M: Model> Saved<M> {
    pub(crate) fn new() -> Self {
        Self {
            model: M::default(),
            state: State::Instantiated,
            time: 0.0,
            start: 0.0,
            stop: f64::MAX,
            stale: true,
            late: false,
        }
    }

    /// The state as bytes; their number is the same for every state of a model, but for that of its texts.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        self.to_bytes_under(kept_hash::<M>())
    }

    /// As [`Self::to_bytes`], with the table's hash known.
    pub(crate) fn to_bytes_under(&self, guid: u128) -> Vec<u8> {
        let mut payload = Writer::default();
        let mut all = self.clone();
        all.catch_up();
        all.visit(&mut payload);
        let payload = payload.bytes;
        let mut bytes = header(guid, &payload);
        bytes.extend(payload);
        bytes
    }

    /// Whether a state of this model can have that many bytes.
    pub(crate) fn can_have_size(size: usize) -> bool {
        let mut payload = Writer::default();
        Self::new().visit(&mut payload);
        let least = HEADER + payload.bytes.len() - payload.of_texts.unwrap_or(0);
        size == least || (size > least && payload.of_texts.is_some())
    }

    /// Reads what [`Self::to_bytes`] wrote, of a model without files of its own.
    ///
    /// # Errors
    /// [`Error::Serialised`] when the bytes are of another FMU or version, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        Ok(*Self::from_bytes_under(kept_hash::<M>(), bytes, None)?)
    }

    /// As [`Self::from_bytes`], with the table's hash known; not on the stack, where a model may be large.
    /// `fresh`: a model that has loaded its files.
    pub(crate) fn from_bytes_under(
        guid: u128,
        bytes: &[u8],
        fresh: Option<&M>,
    ) -> Result<Box<Self>, Error> {
        let payload = checked_payload(guid, bytes)?;
        let mut reader = Reader {
            rest: payload,
            intact: true,
        };
        let mut saved = Box::new(Self::new());
        if let Some(fresh) = fresh {
            saved.model.clone_from(fresh);
        }
        saved.visit(&mut reader);
        if !reader.intact || !reader.rest.is_empty() {
            return Err(Error::Serialised("does not hold the fields of this model"));
        }
        saved.check()?;
        saved.model.restored();
        Ok(saved)
    }

    /// Computes the outputs on demand that a step left; returns whether there were any.
    pub(crate) fn catch_up(&mut self) -> bool {
        let runs = matches!(self.state, State::StepComplete | State::Terminated);
        let late = self.late && runs;
        if late {
            self.model.update_outputs();
            self.late = false;
        }
        late
    }

    /// Refuses what no run can leave behind, however well its checksum fits: a model need not stand it.
    fn check(&mut self) -> Result<(), Error> {
        let times = self.time.is_finite() && self.start.is_finite() && !self.stop.is_nan();
        if !times {
            return Err(Error::Serialised("holds times that are none"));
        }
        self.stop = self.stop.min(f64::MAX);
        let begun = self.has_begun();
        for row in rows::<M>() {
            check_row(row, &mut self.model, begun)?;
        }
        let fits = !begun || self.model.consistent().is_ok();
        fits.then_some(()).ok_or(Error::Serialised(
            "holds parameters that contradict each other",
        ))
    }

    /// Whether the model has been initialised, and has not failed.
    const fn has_begun(&self) -> bool {
        match self.state {
            State::StepComplete | State::Terminated => true,
            State::Initialization => !self.stale,
            State::Instantiated | State::Error => false,
        }
    }

    /// Refuses what is not all numbers, by the name of the first variable that is none.
    pub(crate) fn check_numbers(&mut self) -> Result<(), Error> {
        for row in rows::<M>().filter(|row| row.computed) {
            if let (true, Access::Real(field)) = (self.has_begun(), row.access) {
                finite(row.name, *field(&mut self.model))?;
            }
        }
        Ok(())
    }

    /// Every field, in the order of the payload.
    fn visit(&mut self, fields: &mut dyn Fields) {
        fields.state(&mut self.state);
        fields.boolean(&mut self.stale);
        for time in [&mut self.time, &mut self.start, &mut self.stop] {
            fields.real(time);
        }
        for row in rows::<M>() {
            if const { has_constants::<M>() } && row.variability == Variability::Constant {
                continue;
            }
            match row.access {
                Access::Real(field) => fields.real(field(&mut self.model)),
                Access::Boolean(field) => fields.boolean(field(&mut self.model)),
                Access::Integer(field) | Access::Enumeration(field, _) => {
                    fields.integer(field(&mut self.model));
                }
                Access::String(field) if const { has_strings::<M>() } => {
                    fields.text(field(&mut self.model));
                }
                Access::String(_) => {}
            }
            if let Some(rate) = row.rate {
                fields.real(rate(&mut self.model));
            }
        }
        self.model.hidden_state(fields);
    }
}

/// Limits hold always; what is computed is finite once a model has begun, unless it failed.
fn check_row<M>(row: &Row<M>, model: &mut M, begun: bool) -> Result<(), Error> {
    let set = matches!(row.causality, Causality::Input | Causality::Parameter);
    let sound = match row.access {
        Access::Real(field) if set => field(model).check(row).is_ok(),
        Access::Real(field) => !begun || field(model).is_finite(),
        Access::Integer(field) | Access::Enumeration(field, _) if set => {
            field(model).check(row).is_ok()
        }
        _ => true,
    };
    let rate = row.rate.is_none_or(|field| field(model).is_finite());
    if sound && rate {
        Ok(())
    } else {
        Err(Error::Serialised(
            "holds a value that its variable cannot have",
        ))
    }
}

fn header(guid: u128, payload: &[u8]) -> Vec<u8> {
    let length = u64::try_from(payload.len()).unwrap_or(u64::MAX);
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(guid.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(checksum(payload).to_le_bytes());
    bytes
}

/// The payload, once its header proves that it is one of this model.
fn checked_payload(wanted: u128, bytes: &[u8]) -> Result<&[u8], Error> {
    let cut = Error::Serialised("is cut short");
    let (magic, rest) = take::<8>(bytes).ok_or(cut.clone())?;
    let (version, rest) = take::<4>(rest).ok_or(cut.clone())?;
    let (guid, rest) = take::<16>(rest).ok_or(cut.clone())?;
    let (length, rest) = take::<8>(rest).ok_or(cut.clone())?;
    let (sum, payload) = take::<16>(rest).ok_or(cut)?;
    let fault = if magic != *MAGIC {
        "does not begin like one"
    } else if u32::from_le_bytes(version) != VERSION {
        "is of another version of its format"
    } else if u128::from_le_bytes(guid) != wanted {
        "is of a model with another GUID"
    } else if usize::try_from(u64::from_le_bytes(length)) != Ok(payload.len()) {
        "has another length than it says"
    } else if u128::from_le_bytes(sum) != checksum(payload) {
        "is damaged: its checksum differs"
    } else {
        return Ok(payload);
    };
    Err(Error::Serialised(fault))
}

fn checksum(payload: &[u8]) -> u128 {
    let mut hash = Hash::new();
    hash.bytes(payload);
    hash.value()
}

fn take<const N: usize>(bytes: &[u8]) -> Option<([u8; N], &[u8])> {
    bytes
        .split_first_chunk()
        .map(|(first, rest)| (*first, rest))
}

/// The fields of a model, and the life-cycle state before them.
trait Fields: StateFields {
    fn state(&mut self, state: &mut State);
}

#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    /// How many of them are characters of texts, if there are texts.
    of_texts: Option<usize>,
}

impl StateFields for Writer {
    fn real(&mut self, value: &mut f64) {
        self.bytes.extend(value.to_bits().to_le_bytes());
    }

    fn integer(&mut self, value: &mut i32) {
        self.bytes.extend(value.to_le_bytes());
    }

    fn boolean(&mut self, value: &mut bool) {
        self.bytes.push(u8::from(*value));
    }

    fn text(&mut self, value: &mut String) {
        let length = u64::try_from(value.len()).unwrap_or(u64::MAX);
        self.bytes.extend(length.to_le_bytes());
        self.bytes.extend(value.as_bytes());
        self.of_texts = Some(self.of_texts.unwrap_or(0) + value.len());
    }
}

impl Fields for Writer {
    fn state(&mut self, state: &mut State) {
        let number = (0..).zip(State::ALL).find(|(_, known)| known == state);
        self.bytes.extend(number.map(|(number, _): (u8, _)| number));
    }
}

/// Reads fields until one is missing or senseless; that one and all others keep their values.
struct Reader<'a> {
    rest: &'a [u8],
    intact: bool,
}

impl Reader<'_> {
    fn read<const N: usize, T>(&mut self, value: &mut T, convert: fn([u8; N]) -> Option<T>) {
        let read = take(self.rest).and_then(|(bytes, rest)| Some((convert(bytes)?, rest)));
        match read {
            Some((new, rest)) if self.intact => (*value, self.rest) = (new, rest),
            _ => self.intact = false,
        }
    }
}

impl StateFields for Reader<'_> {
    fn real(&mut self, value: &mut f64) {
        self.read(value, |bytes| {
            Some(f64::from_bits(u64::from_le_bytes(bytes)))
        });
    }

    fn integer(&mut self, value: &mut i32) {
        self.read(value, |bytes| Some(i32::from_le_bytes(bytes)));
    }

    fn boolean(&mut self, value: &mut bool) {
        self.read(value, |[byte]| match byte {
            0 => Some(false),
            1 => Some(true),
            _ => None,
        });
    }

    fn text(&mut self, value: &mut String) {
        let read = take(self.rest).and_then(|(length, rest)| {
            let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
            let (text, rest) = rest.split_at_checked(length)?;
            Some((core::str::from_utf8(text).ok()?, rest))
        });
        match read {
            Some((new, rest)) if self.intact => {
                new.clone_into(value);
                self.rest = rest;
            }
            _ => self.intact = false,
        }
    }
}

impl Fields for Reader<'_> {
    fn state(&mut self, state: &mut State) {
        self.read(state, |[number]| {
            State::ALL.get(usize::from(number)).copied()
        });
    }
}

#[cfg(test)]
mod tests {
    use super::{Reader, StateFields as _};

    /// What is read where a text was to be; `None`: it was refused.
    fn read(length: u64, characters: &[u8]) -> Option<String> {
        let bytes = [&length.to_le_bytes(), characters].concat();
        let (rest, intact) = (bytes.as_slice(), true);
        let (mut reader, mut value) = (Reader { rest, intact }, String::from("kept"));
        reader.text(&mut value);
        assert!(reader.intact || value == "kept");
        reader.intact.then_some(value)
    }

    #[test]
    fn a_text_that_is_cut_short_or_not_utf8_is_not_read() {
        assert_eq!(read(2, b"ab"), Some("ab".into()));
        assert_eq!(read(1, b"ab"), Some("a".into()));
        assert_eq!(read(0, b""), Some(String::new()));
        for length in [3, 1 << 32, u64::MAX] {
            assert_eq!(read(length, b"ab"), None, "{length}");
        }
        assert_eq!(read(2, b"a\xff"), None);
    }
}
