//! The C boundary: all unsafe code is here and in `ffi/`. 34 functions, one way in.
//!
//! No part of the API: it is public for what `export!` expands to in a crate of an FMU, and may change with every
//! version. Authors of models need nothing of it.
//!
//! Every function on an instance goes through [`Library::enter`]: look-up of the token, poison
//! check, unwind barrier, error to log line and status.
//!
//! # What is checked, and what is taken on trust
//!
//! Components and FMU states are tokens (`handle.rs`), so one that was freed, is in use by another
//! thread, or never was ours is refused. Pointers that are NULL or misaligned are refused (`pointer.rs`), and so are
//! counts above the number of variables. The rest cannot be seen from here; the functions are sound for an importer
//! that keeps to this, and every SAFETY line names what it needs of it:
//!
//! | | what an importer promises | FMI 2.0.4 |
//! | --- | --- | --- |
//! | Arrays | a pointer with a count points at so many values | 2.1.7 variables, 2.1.8 states, 2.1.9 and 4.2.1 derivatives, 2.1.5 log categories |
//! | Places | a pointer to one result points at room for it | 2.1.8 `FMUstate` and `size`, 4.2.3 status |
//! | Strings | end with NUL | 2.1.2 |
//! | Callbacks | the struct is there during `fmi2Instantiate`, its functions until `fmi2FreeInstance` returns | 2.1.5 |
//! | Stillness | during a call nobody else writes to what its arguments point at or reads its results, and results do not lie within other arguments | not in words; without it a call has no meaning in C either |

#![allow(unsafe_code)]
#![allow(clippy::missing_safety_doc)] // one contract for all: the module documentation

use crate::handle::{Entered, Table};
use crate::logger::{Filter, Text};
use crate::saved::Saved;
use crate::{Call, Category, Error, Instance, Log, Model, guid, request};
use core::ffi::{CStr, c_char, c_int, c_void};
use core::fmt;
use core::ptr::{null_mut, without_provenance_mut};
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Once, OnceLock};

mod pointer;
pub(crate) mod real;
mod resources;
mod states;
mod strings;
mod variables;

use pointer::{slice, text};

pub use crate::error::Status;

type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`, as the FMI 2.0 headers lay it out.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Callbacks {
    logger: Option<Logger>,
    allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    environment: *mut c_void,
}

/// An FMU library of model `M`: its instances and saved states. One per library, made by `export!`.
pub struct Library<M: Model> {
    instances: Table<Component<M>>,
    states: Table<Saved<M>>,
    /// Hash that is the GUID, and how it is written; made once.
    guid: OnceLock<(u128, guid::Text)>,
}

/// What a `fmi2Component` stands for.
struct Component<M: Model> {
    instance: Instance<M>,
    reporter: Reporter,
    /// Rust panicked in this instance: nothing in it can be trusted.
    poisoned: bool,
    /// What the importer was handed for its last question for strings.
    texts: Box<[CString]>,
}

/// Brings messages to the importer's logger.
struct Reporter {
    name: Box<CStr>,
    logger: Option<Logger>,
    environment: *mut c_void,
    filter: Filter,
}

impl Reporter {
    /// For the importer's callbacks, all categories on; the struct need not outlive this call.
    unsafe fn new(name: *const c_char, callbacks: *const Callbacks) -> Self {
        // SAFETY: NULL, or a string that ends (Strings) and a struct that is there for this call (Callbacks).
        let (name, callbacks) = unsafe { (text(name), callbacks.as_ref()) };
        Self {
            name: name.unwrap_or(c"").into(),
            logger: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(null_mut(), |callbacks| callbacks.environment),
            filter: Filter::all(true),
        }
    }

    fn send(&self, category: Category, message: fmt::Arguments<'_>) {
        let Some(logger) = self.logger.filter(|_| self.filter.passes(category)) else {
            return;
        };
        let (text, name) = (Text::new(message), category.c_name());
        let status = match category {
            Category::Warning => Status::Ok,
            other => other.status(),
        };
        // SAFETY: the instance is not freed yet, so there is its logger (Callbacks), called as the headers of FMI say;
        // every pointer is NUL-terminated and lives until the call returns. The text is a format without conversions,
        // so that importers that cannot read further arguments show it too.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status as c_int,
                name.as_ptr(),
                text.as_c_str().as_ptr(),
            );
        }
    }
}

impl<M: Model> Component<M> {
    #[inline(never)] // a model on the caller's stack, for no longer than it takes to make it
    fn boxed(reporter: Reporter) -> Box<Self> {
        Box::new(Self {
            instance: Instance::default(),
            reporter,
            poisoned: false,
            texts: Box::default(),
        })
    }

    #[cold]
    #[inline(never)]
    fn refuse(&self, call: Call, error: &Error) -> Status {
        let status = error.status();
        self.reporter
            .send(Category::of(status), format_args!("{call}: {error}"));
        status
    }

    /// Does something to it behind the unwind barrier.
    #[inline(always)]
    fn shield(&mut self, call: Call, body: impl FnOnce(&mut Self) -> Result<(), Error>) -> Status {
        match catch_unwind(AssertUnwindSafe(|| body(self))) {
            Ok(Ok(())) => Status::Ok,
            Ok(Err(error)) => self.refuse(call, &error),
            Err(payload) => {
                // Dropping what a model panicked with could panic again, outside the barrier.
                core::mem::forget(payload);
                self.poison(call)
            }
        }
    }

    /// Does something to its instance, with a log for the model.
    #[inline(always)]
    fn with_log(
        &mut self,
        body: impl FnOnce(&mut Instance<M>, &mut Log<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let reporter = &self.reporter;
        let mut sink = |category, message: fmt::Arguments<'_>| reporter.send(category, message);
        body(&mut self.instance, &mut Log::new(&mut sink))
    }

    #[cold]
    #[inline(never)]
    fn poison(&mut self, call: Call) -> Status {
        self.poisoned = true;
        self.instance.condemn();
        let message = format_args!("{call}: the model panicked; free this instance");
        self.reporter.send(Category::Fatal, message);
        Status::Fatal
    }
}

impl<M: Model> Library<M> {
    /// A library without instances.
    #[must_use]
    pub const fn empty() -> Self {
        Self {
            instances: Table::new(),
            states: Table::new(),
            guid: OnceLock::new(),
        }
    }

    /// The number behind the GUID, which is also in every serialised state.
    fn table_hash(&self) -> u128 {
        self.guid().0
    }

    fn guid(&self) -> &(u128, guid::Text) {
        self.guid.get_or_init(|| {
            let hash = guid::table_hash::<M>();
            (hash, guid::text(hash))
        })
    }

    /// The way into an instance for every function.
    fn enter_component(
        &self,
        component: *mut c_void,
        call: Call,
        body: impl FnOnce(&mut Component<M>) -> Result<(), Error>,
    ) -> Status {
        let Some(entered) = self.instances.enter(component.addr()) else {
            return Status::Error;
        };
        // SAFETY: made from a `Box` by `instantiate`, and `entered` keeps everybody else out.
        let component = unsafe { &mut *entered.value };
        if component.poisoned {
            return Status::Fatal;
        }
        component.shield(call, body)
    }

    /// The way in for what is done at once or not at all: false, and nothing changed or logged, when
    /// there is anything out of the ordinary. The caller then takes the other way in. What is done must
    /// not be done in an instance that is condemned, so that there is no need to ask whether it is poisoned.
    #[inline(always)]
    fn plainly(
        entered: Option<Entered<'_, Component<M>>>,
        body: impl FnOnce(&mut Instance<M>) -> bool,
    ) -> bool {
        let Some(entered) = entered else {
            return false;
        };
        // SAFETY: made from a `Box` by `instantiate`, and `entered` keeps everybody else out.
        let component = unsafe { &mut *entered.value };
        let body = AssertUnwindSafe(|| body(&mut component.instance));
        matches!(catch_unwind(body), Ok(true))
    }

    /// The way in for functions that need no pointer but the instance: with the log that a model
    /// writes to.
    pub fn enter(
        &self,
        component: *mut c_void,
        call: Call,
        body: impl FnOnce(&mut Instance<M>, &mut Log<'_>) -> Result<(), Error>,
    ) -> Status {
        self.enter_component(component, call, |component| component.with_log(body))
    }

    /// `fmi2DoStep`: a plain one at once, everything else as other functions.
    #[inline(always)]
    pub fn step(&self, component: *mut c_void, time: f64, step: f64) -> Status {
        let Some(entered) = self.instances.enter_first(component.addr()) else {
            return Self::step_carefully(component, time, step, self);
        };
        // SAFETY: made from a `Box` by `instantiate`, and `entered` keeps everybody else out.
        let inside = unsafe { &mut *entered.value };
        let Some(end) = inside.instance.plain_step(time, step) else {
            drop(entered);
            return Self::step_carefully(component, time, step, self);
        };
        inside.shield(Call::DoStep, |component| {
            component.with_log(|instance, log| instance.advance(time, step, end, log))
        })
    }

    #[cold]
    #[inline(never)]
    extern "C" fn step_carefully(
        component: *mut c_void,
        time: f64,
        step: f64,
        library: &Self,
    ) -> Status {
        library.enter(component, Call::DoStep, |instance, log| {
            instance.step(time, step, log)
        })
    }

    /// Functions behind capability flags that are false.
    pub fn not_offered(&self, component: *mut c_void, call: Call, what: &'static str) -> Status {
        self.enter(component, call, |instance, _| {
            instance.permit(call)?;
            Err(Error::NotSupported(what))
        })
    }

    /// `fmi2GetStatus` and its typed kin: steps are synchronous, so nothing is ever pending.
    pub fn status(&self, component: *mut c_void, call: Call, kind: c_int) -> Status {
        self.enter(component, call, |instance, _| {
            instance.permit(call)?;
            Err(Error::NoStatus(kind))
        })
    }

    /// `fmi2Instantiate`: NULL, with a log line, when anything is not as it has to be.
    pub unsafe fn instantiate(
        &self,
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        callbacks: *const Callbacks,
        logging_on: bool,
    ) -> *mut c_void {
        let made = catch_unwind(AssertUnwindSafe(|| {
            // SAFETY: NULL or as promised (Strings, Callbacks).
            let (guid, mut reporter) = unsafe { (text(guid), Reporter::new(name, callbacks)) };
            let (_, own) = self.guid();
            if let Err(error) = request::check(&reporter.name, kind, guid, own) {
                reporter.send(Category::Error, format_args!("fmi2Instantiate: {error}"));
                return null_mut();
            }
            reporter.filter = Filter::all(logging_on);
            let mut component = Component::boxed(reporter);
            if const { M::RESOURCES } {
                // SAFETY: NULL or as promised (Strings).
                if !component.load(unsafe { text(resources) }) {
                    return null_mut();
                }
            }
            handed_out(self.instances.insert(component))
        }));
        made.unwrap_or_else(|payload| {
            core::mem::forget(payload);
            null_mut()
        })
    }

    /// `fmi2FreeInstance`.
    pub unsafe fn free_instance(&self, component: *mut c_void) {
        let Some(entered) = self.instances.enter(component.addr()) else {
            return;
        };
        // SAFETY: made from a `Box` by `instantiate`; nobody finds it any more.
        let component = unsafe { Box::from_raw(self.instances.give_back(entered)) };
        if let Err(payload) = catch_unwind(AssertUnwindSafe(|| drop(component))) {
            core::mem::forget(payload);
        }
    }

    /// `fmi2SetDebugLogging`; without categories it concerns all of them.
    pub unsafe fn set_debug_logging(
        &self,
        component: *mut c_void,
        on: bool,
        count: usize,
        categories: *const *const c_char,
    ) -> Status {
        self.enter_component(component, Call::SetDebugLogging, |component| {
            component.instance.permit(Call::SetDebugLogging)?;
            if count > Category::ALL.len() {
                return Err(Error::UnknownCategory);
            }
            // SAFETY: `count` pointers (Arrays, 2.1.5).
            let categories = unsafe { slice("categories", categories, count)? };
            if categories.iter().any(|category| category.is_null()) {
                return Err(Error::Pointer("categories"));
            }
            // SAFETY: none is NULL, as was just seen; they end (Strings).
            let names = categories.iter().filter_map(|name| unsafe { text(*name) });
            let filter = &mut component.reporter.filter;
            *filter = filter.requested(on, names)?;
            Ok(())
        })
    }
}

/// What the importer is given for a token; NULL for none.
fn handed_out(token: Option<usize>) -> *mut c_void {
    token.map_or(null_mut(), without_provenance_mut)
}

/// A panic is reported through the importer's logger; nothing may reach stderr.
///
/// Called by `export!` only: in a `cdylib` the hook belongs to the library's own copy of `std`, not
/// to the process.
pub fn silence_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}

#[cfg(test)]
mod tests;
