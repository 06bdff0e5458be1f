//! The calls of a run as text, one a line, for a program that makes them again on another machine and
//! compares every value that it reads: `xtask/platforms/calls.c`.
//!
//! ```text
//! new PART GUID · init PART TIME · start PART · step PART TIME STEP · end PART
//! set PART TYPE REFERENCE VALUE · get PART TYPE REFERENCE VALUE
//! ```
//!
//! Numbers are bit patterns of doubles in hexadecimal.

use super::{Kind, Part, Place, Signal};
use crate::Result;
use std::cell::RefCell;
use std::fmt::Write as _;
use std::rc::Rc;

/// Where all components of a run write their calls.
pub(crate) type Calls = Rc<RefCell<String>>;

/// A component whose calls are written down.
pub(crate) struct Recorded<'a> {
    part: Box<dyn Part + 'a>,
    at: usize,
    calls: Calls,
}

impl<'a> Recorded<'a> {
    /// Component number `at`, which an importer makes by `guid`.
    pub(crate) fn boxed(
        part: Box<dyn Part + 'a>,
        at: usize,
        guid: &str,
        calls: &Calls,
    ) -> Box<Self> {
        let calls = Rc::clone(calls);
        let recorded = Self { part, at, calls };
        recorded.note(format_args!("new {at} {guid}"));
        Box::new(recorded)
    }

    fn note(&self, call: std::fmt::Arguments<'_>) {
        let _ = writeln!(self.calls.borrow_mut(), "{call}");
    }

    fn value(&self, verb: &str, Place { kind, reference }: Place, value: f64) {
        let kind = match kind {
            Kind::Real => 'r',
            Kind::Integer => 'i',
            Kind::Boolean => 'b',
        };
        let (at, bits) = (self.at, value.to_bits());
        self.note(format_args!("{verb} {at} {kind} {reference} {bits:x}"));
    }
}

impl Part for Recorded<'_> {
    fn name(&self) -> &str {
        self.part.name()
    }

    fn signals(&self) -> &[Signal] {
        self.part.signals()
    }

    fn set(&mut self, place: Place, value: f64) -> Result<()> {
        self.value("set", place, value);
        self.part.set(place, value)
    }

    fn get(&mut self, place: Place) -> Result<f64> {
        let value = self.part.get(place)?;
        self.value("get", place, value);
        Ok(value)
    }

    fn initialize(&mut self, time: f64) -> Result<()> {
        self.note(format_args!("init {} {:x}", self.at, time.to_bits()));
        self.part.initialize(time)
    }

    fn start(&mut self) -> Result<()> {
        self.note(format_args!("start {}", self.at));
        self.part.start()
    }

    fn step(&mut self, time: f64, step: f64) -> Result<()> {
        let (from, over) = (time.to_bits(), step.to_bits());
        self.note(format_args!("step {} {from:x} {over:x}", self.at));
        self.part.step(time, step)
    }

    fn terminate(&mut self) -> Result<()> {
        self.note(format_args!("end {}", self.at));
        self.part.terminate()
    }
}
