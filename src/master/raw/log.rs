//! What an FMU says through its logger, with the time at which it says it.

use crate::calls::{Calls, of};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Messages of one instance that are kept; one more tells that there were more.
pub const MESSAGES: usize = 1000;

/// fmi2Warning.
const WARNING: i32 = 1;

/// fmi2Discard; from there on so many messages are kept of a flood, too: why a call was refused.
const SEVERE: i32 = 2;
const ERRORS: usize = 100;

/// A message of an FMU, or of the master about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Communication point at which it came [s].
    pub time: f64,
    /// fmi2Status as a number, 0 for OK.
    pub status: i32,
    /// The FMU's name for this kind of message; `harness` for the master's own.
    pub category: String,
    /// The message.
    pub text: String,
}

/// The messages of one instance so far; the FMU may add to it from any thread.
#[derive(Debug, Default)]
pub struct Log {
    /// Bits of the communication point [s].
    now: AtomicU64,
    messages: Mutex<Vec<Message>>,
    /// Where the calls of its run are told, and the word of its instance there.
    calls: Arc<Calls>,
    word: u64,
    /// FMUs of others are asked to log, too.
    asks: bool,
    /// The instance was not asked to.
    off: AtomicBool,
}

impl Log {
    /// The log of the instance of this number; `asks` those who may tell of every call to log, too.
    pub fn new(calls: Arc<Calls>, number: u32, asks: bool) -> Self {
        Self {
            calls,
            word: of(number),
            asks,
            ..Self::default()
        }
    }

    #[inline]
    pub(crate) fn enter(&self, function: u64) {
        self.calls.enter(self.word, function);
    }

    /// Whether an instance is to log; one that is `ours` is in any case.
    pub(crate) fn turn_on(&self, ours: bool) -> bool {
        self.off.store(!(ours || self.asks), Ordering::Relaxed);
        ours || self.asks
    }

    /// Whether its instance was not asked to log.
    pub fn is_off(&self) -> bool {
        self.off.load(Ordering::Relaxed)
    }

    /// Gives the messages to come their time [s].
    pub fn at(&self, time: f64) {
        self.now.store(time.to_bits(), Ordering::Relaxed);
    }

    /// Adds what the master has to say of the FMU.
    pub fn warn(&self, text: String) {
        self.push(WARNING, "harness".into(), text);
    }

    /// All messages so far.
    pub fn messages(&self) -> Vec<Message> {
        let messages = self.messages.lock();
        messages.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn push(&self, status: i32, category: String, text: String) {
        let messages = self.messages.lock();
        let mut messages = messages.unwrap_or_else(PoisonError::into_inner);
        let time = f64::from_bits(self.now.load(Ordering::Relaxed));
        let message = |status, category, text| Message {
            time,
            status,
            category,
            text,
        };
        if messages.len() < MESSAGES {
            messages.push(message(status, category, text));
            return;
        }
        if messages.len() == MESSAGES {
            let flood = "floods its log: further messages are dropped".to_owned();
            messages.push(message(WARNING, "harness".into(), flood));
        }
        if status >= SEVERE && (MESSAGES + 1..=MESSAGES + ERRORS).contains(&messages.len()) {
            messages.push(message(status, category, text));
        }
    }
}

/// Takes a message from `logger.c`; `log` is the component environment of `Callbacks`.
#[unsafe(no_mangle)]
extern "C" fn cosim_log(
    log: *const c_void,
    status: c_int,
    category: *const c_char,
    text: *const c_char,
) {
    // SAFETY: FMI 2.0.4, 2.1.5: an FMU hands back the componentEnvironment that it was given, which
    // is the Log that its Instance keeps until after fmi2FreeInstance; null is no reference.
    let Some(log) = (unsafe { log.cast::<Log>().as_ref() }) else {
        return;
    };
    // SAFETY: logger.c passes a text that ends with a null character, never a null pointer.
    let category = unsafe { CStr::from_ptr(category) }.to_string_lossy();
    // SAFETY: as before.
    let text = unsafe { CStr::from_ptr(text) }.to_string_lossy();
    // FMI 2.0.4, 2.1.5: '#' has a meaning in messages and is doubled where it has none.
    log.push(status, category.into_owned(), text.replace("##", "#"));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::{from_ref, null};

    fn tell(log: &Log, text: &CStr) {
        let category = c"logEvents".as_ptr();
        cosim_log(from_ref(log).cast(), 0, category, text.as_ptr());
    }

    #[test]
    fn a_message_has_the_time_of_its_step() {
        let log = Log::default();
        log.at(0.25);
        tell(&log, c"gear ##1");
        let [message] = log.messages().try_into().unwrap();
        assert_eq!((message.time, message.status), (0.25, 0));
        assert_eq!(
            (&*message.category, &*message.text),
            ("logEvents", "gear #1")
        );
    }

    #[test]
    fn a_flood_is_cut_and_told() {
        let log = Log::default();
        (0..MESSAGES + 9).for_each(|_| tell(&log, c"again"));
        let messages = log.messages();
        assert_eq!(messages.len(), MESSAGES + 1);
        assert!(messages[MESSAGES].text.contains("floods its log"));
        assert_eq!(messages[MESSAGES].status, WARNING);
    }

    #[test]
    fn why_a_call_was_refused_is_kept_of_a_flood() {
        let log = Log::default();
        (0..MESSAGES + 9).for_each(|_| tell(&log, c"again"));
        for _ in 0..2 * ERRORS {
            cosim_log(from_ref(&log).cast(), 3, c"".as_ptr(), c"why".as_ptr());
        }
        let messages = log.messages();
        assert_eq!(messages.len(), MESSAGES + 1 + ERRORS);
        assert_eq!(
            messages.last().map(|m| (m.status, &*m.text)),
            Some((3, "why"))
        );
    }

    #[test]
    fn others_log_only_when_they_are_asked_to() {
        for (asks, ours, expected) in [
            (false, false, false),
            (false, true, true),
            (true, false, true),
            (true, true, true),
        ] {
            let log = Log::new(Arc::default(), 0, asks);
            assert_eq!((log.turn_on(ours), log.is_off()), (expected, !expected));
        }
    }

    #[test]
    fn a_message_for_nobody_is_dropped() {
        cosim_log(null(), 0, c"".as_ptr(), c"".as_ptr());
    }
}
