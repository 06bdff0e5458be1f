//! The C boundary: the only unsafe file. 34 functions, one way in.
//!
//! Every function on an instance goes through `enter`: null check, poison check, unwind barrier,
//! error to log line and status. An FMU library is one line:
//!
//! ```text
//! fmi2_cosim::export!(my_models::Tank);
//! ```
//!
//! What the importer promises (FMI 2.0.4, 2.1.2 and 4.2) and the code relies on: a component or FMU
//! state passed in came from this library and was not freed; arrays have the length that is passed
//! with them; strings are NUL-terminated; one instance is used by one thread at a time. The callback
//! functions are copied, so the importer's struct need not outlive `fmi2Instantiate`.

#![allow(unsafe_code)]
#![allow(clippy::missing_safety_doc)] // one contract for all: the module documentation

use crate::logger::{Filter, Text};
use crate::saved::Saved;
use crate::value::Value;
use crate::{Call, Category, Error, Instance, Log, Model, guid};
use core::ffi::{CStr, c_char, c_int, c_void};
use core::fmt;
use core::ptr::null_mut;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Once, OnceLock};

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

/// What `fmi2Component` points at.
struct Component<M: Model> {
    instance: Instance<M>,
    reporter: Reporter,
    /// Rust panicked in this instance: nothing in it can be trusted.
    poisoned: bool,
}

/// What the importer holds a pointer to. The mark in front tells a component from an FMU state, and
/// either from what was given back or never was ours.
#[repr(C)]
struct Held<T> {
    mark: u64,
    value: T,
}

const COMPONENT: u64 = u64::from_le_bytes(*b"fmi2comp");
const STATE: u64 = u64::from_le_bytes(*b"fmi2stat");

impl<T> Held<T> {
    fn hand_out(mark: u64, value: T) -> *mut c_void {
        Box::into_raw(Box::new(Self { mark, value })).cast()
    }

    /// The value behind the importer's pointer, if the mark is right.
    unsafe fn look<'a>(pointer: *mut c_void, mark: u64) -> Option<&'a mut T> {
        // SAFETY: the promise of this function.
        let held = unsafe { Self::checked(pointer, mark)?.as_mut()? };
        Some(&mut held.value)
    }

    /// Ends what `hand_out` began; the mark goes first, so a second time finds none.
    unsafe fn take_back(pointer: *mut c_void, mark: u64) -> Option<Box<Self>> {
        // SAFETY: the mark proves a pointer of `hand_out` that was not given back yet.
        unsafe {
            let held = Self::checked(pointer, mark)?;
            (&raw mut (*held).mark).write_volatile(0);
            Some(Box::from_raw(held))
        }
    }

    unsafe fn checked(pointer: *mut c_void, mark: u64) -> Option<*mut Self> {
        let held = pointer.cast::<Self>();
        if unusable(held) {
            return None;
        }
        // SAFETY: not NULL and aligned; by the importer's promise ours, and the mark comes first.
        (unsafe { pointer.cast::<u64>().read() } == mark).then_some(held)
    }
}

/// Brings messages to the importer's logger.
struct Reporter {
    name: Box<CStr>,
    logger: Option<Logger>,
    environment: *mut c_void,
    filter: Filter,
}

impl Reporter {
    fn send(&self, category: Category, message: fmt::Arguments<'_>) {
        let Some(logger) = self.logger.filter(|_| self.filter.passes(category)) else {
            return;
        };
        let (text, name) = (Text::new(message), category.c_name());
        let status = match category {
            Category::Warning => Status::Ok,
            other => other.status(),
        };
        // SAFETY: the logger is the importer's and is called as its headers say; every pointer is
        // NUL-terminated and lives until the call returns. The text is an argument, not the format.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status as c_int,
                name.as_ptr(),
                c"%s".as_ptr(),
                text.as_c_str().as_ptr(),
            );
        }
    }
}

/// The way into an instance for every function.
fn enter<M: Model>(
    component: *mut c_void,
    call: Call,
    body: impl FnOnce(&mut Component<M>) -> Result<(), Error>,
) -> Status {
    // SAFETY: NULL or, by the importer's promise, a component of this library in use by this thread
    // alone; it was handed out by `instantiate`.
    let Some(component) = (unsafe { Held::<Component<M>>::look(component, COMPONENT) }) else {
        return Status::Error;
    };
    if component.poisoned {
        return Status::Fatal;
    }
    match catch_unwind(AssertUnwindSafe(|| body(component))) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(error)) => {
            let status = error.status();
            component
                .reporter
                .send(Category::of(status), format_args!("{call}: {error}"));
            status
        }
        Err(payload) => {
            component.poisoned = true;
            // Dropping what a model panicked with could panic again, outside the barrier.
            core::mem::forget(payload);
            let message = format_args!("{call}: the model panicked; free this instance");
            component.reporter.send(Category::Fatal, message);
            Status::Fatal
        }
    }
}

/// Like `enter`, with the log that a model writes to.
fn enter_logged<M: Model>(
    component: *mut c_void,
    call: Call,
    body: impl FnOnce(&mut Instance<M>, &mut Log<'_>) -> Result<(), Error>,
) -> Status {
    enter(component, call, |component: &mut Component<M>| {
        let reporter = &component.reporter;
        let mut sink = |category, message: fmt::Arguments<'_>| reporter.send(category, message);
        body(&mut component.instance, &mut Log::new(&mut sink))
    })
}

/// The importer's array of `count` values.
unsafe fn slice<'a, T>(
    argument: &'static str,
    values: *const T,
    count: usize,
) -> Result<&'a [T], Error> {
    match count {
        0 => Ok(&[]),
        _ if unusable(values) => Err(Error::Pointer(argument)),
        // SAFETY: not NULL, and by the importer's promise of that length.
        _ => Ok(unsafe { core::slice::from_raw_parts(values, count) }),
    }
}

/// A single value of the importer's, to be written.
unsafe fn place<'a, T>(argument: &'static str, value: *mut T) -> Result<&'a mut T, Error> {
    if unusable(value) {
        return Err(Error::Pointer(argument));
    }
    // SAFETY: not NULL and aligned, and by the importer's promise writable.
    unsafe { value.as_mut() }.ok_or(Error::Pointer(argument))
}

/// The importer's array of `count` values, to be written.
unsafe fn slice_mut<'a, T>(
    argument: &'static str,
    values: *mut T,
    count: usize,
) -> Result<&'a mut [T], Error> {
    match count {
        0 => Ok(&mut []),
        _ if unusable(values) => Err(Error::Pointer(argument)),
        // SAFETY: as above, and the importer reads it after the call only.
        _ => Ok(unsafe { core::slice::from_raw_parts_mut(values, count) }),
    }
}

fn unusable<T>(values: *const T) -> bool {
    values.is_null() || !values.is_aligned()
}

/// Refuses counts that no call without repetition can have.
fn plausible<M: Model>(count: usize) -> Result<(), Error> {
    if count > M::VARIABLES.len() {
        Err(Error::Pointer("nvr"))
    } else {
        Ok(())
    }
}

/// The GUID of the library's model, made once.
pub type GuidOnce = OnceLock<String>;

/// `fmi2Instantiate`: NULL, with a log line, when anything is not as it has to be.
pub unsafe fn instantiate<M: Model>(
    guid_once: &'static GuidOnce,
    name: *const c_char,
    kind: c_int,
    given_guid: *const c_char,
    callbacks: *const Callbacks,
    logging_on: bool,
) -> *mut c_void {
    let made = catch_unwind(|| {
        // SAFETY: NULL or, by the importer's promise, NUL-terminated strings and a callback struct.
        let (name, given_guid, callbacks) =
            unsafe { (text(name), text(given_guid), callbacks.as_ref()) };
        let reporter = Reporter {
            name: name.unwrap_or(c"").into(),
            logger: callbacks.and_then(|callbacks| callbacks.logger),
            environment: callbacks.map_or(null_mut(), |callbacks| callbacks.environment),
            filter: Filter::all(true),
        };
        let guid = guid_once.get_or_init(guid::<M>);
        if let Err(error) = acceptable(&reporter.name, kind, given_guid, guid) {
            let message = format_args!("fmi2Instantiate: {error}");
            reporter.send(Category::Error, message);
            return null_mut();
        }
        let reporter = Reporter {
            filter: Filter::all(logging_on),
            ..reporter
        };
        let instance = Instance::<M>::default();
        let component = Component {
            instance,
            reporter,
            poisoned: false,
        };
        Held::hand_out(COMPONENT, component)
    });
    made.unwrap_or_else(|payload| {
        core::mem::forget(payload);
        null_mut()
    })
}

fn acceptable(name: &CStr, kind: c_int, given: Option<&CStr>, guid: &str) -> Result<(), Error> {
    const CO_SIMULATION: c_int = 1;
    if name.is_empty() {
        return Err(Error::Instantiate("instanceName is NULL or empty"));
    }
    if kind != CO_SIMULATION {
        return Err(Error::Instantiate(
            "fmuType is not fmi2CoSimulation, the only type of this FMU",
        ));
    }
    let given = given.ok_or(Error::Instantiate("fmuGUID is NULL"))?;
    if given.to_bytes() == guid.as_bytes() {
        Ok(())
    } else {
        Err(Error::Guid)
    }
}

/// A panic is reported through the importer's logger; nothing may reach stderr.
///
/// Called by `export!` only: in a `cdylib` the hook belongs to the library's own copy of `std`, not
/// to the process.
pub fn silence_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}

unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL, and by the importer's promise NUL-terminated.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// `fmi2FreeInstance`.
pub unsafe fn free_instance<M: Model>(component: *mut c_void) {
    // SAFETY: NULL or, by the importer's promise, handed out by `instantiate`.
    let component = unsafe { Held::<Component<M>>::take_back(component, COMPONENT) };
    if let Err(payload) = catch_unwind(AssertUnwindSafe(|| drop(component))) {
        core::mem::forget(payload);
    }
}

/// `fmi2SetDebugLogging`; without categories it concerns all of them.
pub unsafe fn set_debug_logging<M: Model>(
    component: *mut c_void,
    on: bool,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    enter(
        component,
        Call::SetDebugLogging,
        |component: &mut Component<M>| {
            component.instance.permit(Call::SetDebugLogging)?;
            if count > Category::ALL.len() {
                return Err(Error::UnknownCategory);
            }
            // SAFETY: the importer's promise.
            let categories = unsafe { slice("categories", categories, count)? };
            if !categories.iter().all(|category| !category.is_null()) {
                return Err(Error::Pointer("categories"));
            }
            // SAFETY: the importer's promise.
            let names = categories
                .iter()
                .filter_map(|category| unsafe { text(*category) });
            component.reporter.filter = match (on, count) {
                (_, 0) => Filter::all(on),
                (true, _) => Filter::only(names)?,
                (false, _) => Filter::only(names)?.inverted(),
            };
            Ok(())
        },
    )
}

/// `fmi2SetupExperiment`; a tolerance is accepted and not needed.
pub unsafe fn setup_experiment<M: Model>(
    component: *mut c_void,
    start: f64,
    stop: Option<f64>,
) -> Status {
    enter_logged(
        component,
        Call::SetupExperiment,
        |instance: &mut Instance<M>, _| instance.setup_experiment(start, stop),
    )
}

/// `fmi2EnterInitializationMode`.
pub unsafe fn enter_initialization_mode<M: Model>(component: *mut c_void) -> Status {
    enter_logged(
        component,
        Call::EnterInitializationMode,
        |i: &mut Instance<M>, _| i.enter_initialization(),
    )
}

/// `fmi2ExitInitializationMode`.
pub unsafe fn exit_initialization_mode<M: Model>(component: *mut c_void) -> Status {
    enter_logged(
        component,
        Call::ExitInitializationMode,
        |i: &mut Instance<M>, log| i.exit_initialization(log),
    )
}

/// `fmi2Terminate`.
pub unsafe fn terminate<M: Model>(component: *mut c_void) -> Status {
    enter_logged(component, Call::Terminate, |i: &mut Instance<M>, _| {
        i.terminate()
    })
}

/// `fmi2Reset`.
pub unsafe fn reset<M: Model>(component: *mut c_void) -> Status {
    enter_logged(component, Call::Reset, |i: &mut Instance<M>, _| i.reset())
}

/// `fmi2DoStep`.
pub unsafe fn do_step<M: Model>(component: *mut c_void, time: f64, step: f64) -> Status {
    enter_logged(component, Call::DoStep, |i: &mut Instance<M>, log| {
        i.step(time, step, log)
    })
}

/// `fmi2GetReal`, `fmi2GetInteger` and, with `A` an int, `fmi2GetBoolean`.
pub unsafe fn get<M: Model, T: Value, A: From<T>>(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut A,
) -> Status {
    enter_logged(component, T::GET, |instance: &mut Instance<M>, log| {
        plausible::<M>(count)?;
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (
                slice("vr", references, count)?,
                slice_mut("value", values, count)?,
            )
        };
        let read = instance.get::<T>(references, log)?;
        values
            .iter_mut()
            .zip(read)
            .for_each(|(to, from)| *to = from.into());
        Ok(())
    })
}

/// `fmi2SetReal`, `fmi2SetInteger` and, with `A` an int, `fmi2SetBoolean`.
pub unsafe fn set<M: Model, T: Value, A: Copy>(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const A,
    convert: fn(A) -> T,
) -> Status {
    enter_logged(component, T::SET, |instance: &mut Instance<M>, _| {
        plausible::<M>(count)?;
        // SAFETY: the importer's promise.
        let (references, values) = unsafe {
            (
                slice("vr", references, count)?,
                slice("value", values, count)?,
            )
        };
        instance.set(references, values.iter().map(|value| convert(*value)))
    })
}

/// `fmi2GetString` and `fmi2SetString`: there are no strings, so only empty calls are legal.
pub unsafe fn strings<M: Model>(
    component: *mut c_void,
    call: Call,
    references: *const u32,
    count: usize,
) -> Status {
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        plausible::<M>(count)?;
        // SAFETY: the importer's promise.
        let references = unsafe { slice("vr", references, count)? };
        match references.first() {
            Some(&reference) => Err(Error::UnknownReference {
                reference,
                kind: "String",
            }),
            None => Ok(()),
        }
    })
}

/// `fmi2SetRealInputDerivatives`.
pub unsafe fn set_input_derivatives<M: Model>(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> Status {
    let call = Call::SetRealInputDerivatives;
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        plausible::<M>(count)?;
        // SAFETY: the importer's promise.
        let (references, orders, values) = unsafe {
            (
                slice("vr", references, count)?,
                slice("order", orders, count)?,
                slice("value", values, count)?,
            )
        };
        instance.set_input_derivatives(references, orders, values)
    })
}

/// `fmi2GetRealOutputDerivatives`.
pub unsafe fn get_output_derivatives<M: Model>(
    component: *mut c_void,
    references: *const u32,
    count: usize,
    orders: *const c_int,
    values: *mut f64,
) -> Status {
    let call = Call::GetRealOutputDerivatives;
    enter_logged(component, call, |instance: &mut Instance<M>, log| {
        plausible::<M>(count)?;
        // SAFETY: the importer's promise.
        let (references, orders, values) = unsafe {
            (
                slice("vr", references, count)?,
                slice("order", orders, count)?,
                slice_mut("value", values, count)?,
            )
        };
        let read = instance.output_derivatives(references, orders, log)?;
        values
            .iter_mut()
            .zip(read)
            .for_each(|(to, from)| *to = from);
        Ok(())
    })
}

/// Functions behind capability flags that are false.
pub unsafe fn not_offered<M: Model>(
    component: *mut c_void,
    call: Call,
    what: &'static str,
) -> Status {
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        Err(Error::NotSupported(what))
    })
}

/// `fmi2GetStatus` and its typed kin: steps are synchronous, so nothing is ever pending.
pub unsafe fn status<M: Model>(component: *mut c_void, call: Call, kind: c_int) -> Status {
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        Err(Error::NoStatus(kind))
    })
}

/// `fmi2GetRealStatus(fmi2LastSuccessfulTime)`; the other kinds are not known.
pub unsafe fn real_status<M: Model>(
    component: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> Status {
    const LAST_SUCCESSFUL_TIME: c_int = 2;
    enter_logged(
        component,
        Call::GetRealStatus,
        |instance: &mut Instance<M>, _| {
            instance.permit(Call::GetRealStatus)?;
            if kind != LAST_SUCCESSFUL_TIME {
                return Err(Error::NoStatus(kind));
            }
            // SAFETY: the importer's promise.
            *unsafe { place("value", value)? } = instance.time();
            Ok(())
        },
    )
}

/// `fmi2GetFMUstate`: makes a state, or overwrites the one that `*state` holds.
pub unsafe fn get_state<M: Model>(component: *mut c_void, state: *mut *mut c_void) -> Status {
    enter_logged(
        component,
        Call::GetFMUstate,
        |instance: &mut Instance<M>, _| {
            // SAFETY: the importer's promise; `*state` is NULL or one of our states.
            unsafe { hand_out(place("FMUstate", state)?, instance.save()?) }
        },
    )
}

/// Puts a saved state behind an importer's pointer: NULL, or one of our states.
unsafe fn hand_out<M: Model>(target: &mut *mut c_void, new: Saved<M>) -> Result<(), Error> {
    if target.is_null() {
        *target = Held::hand_out(STATE, new);
    } else {
        // SAFETY: by the importer's promise one of our states that was not freed.
        *unsafe { saved(*target)? } = new;
    }
    Ok(())
}

/// The state behind an importer's pointer.
unsafe fn saved<'a, M: Model>(state: *mut c_void) -> Result<&'a mut Saved<M>, Error> {
    // SAFETY: NULL, or one of our states that was not freed, by the importer's promise.
    unsafe { Held::look(state, STATE) }.ok_or(Error::Pointer("FMUstate"))
}

/// `fmi2SetFMUstate`.
pub unsafe fn set_state<M: Model>(component: *mut c_void, state: *mut c_void) -> Status {
    enter_logged(
        component,
        Call::SetFMUstate,
        |instance: &mut Instance<M>, _| {
            // SAFETY: the importer's promise.
            instance.restore(unsafe { saved(state)? })
        },
    )
}

/// `fmi2FreeFMUstate`: a NULL state is none.
pub unsafe fn free_state<M: Model>(component: *mut c_void, state: *mut *mut c_void) -> Status {
    enter_logged(
        component,
        Call::FreeFMUstate,
        |instance: &mut Instance<M>, _| {
            instance.permit(Call::FreeFMUstate)?;
            // SAFETY: the importer's promise.
            let state = unsafe { place("FMUstate", state)? };
            if !state.is_null() {
                // SAFETY: by the importer's promise handed out by `hand_out`.
                let held = unsafe { Held::<Saved<M>>::take_back(*state, STATE) };
                drop(held.ok_or(Error::Pointer("FMUstate"))?);
                *state = null_mut();
            }
            Ok(())
        },
    )
}

/// `fmi2SerializedFMUstateSize`.
pub unsafe fn state_size<M: Model>(
    component: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    let call = Call::SerializedFMUstateSize;
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        // SAFETY: the importer's promise.
        unsafe { *place("size", size)? = saved::<M>(state)?.to_bytes().len() };
        Ok(())
    })
}

/// `fmi2SerializeFMUstate`.
pub unsafe fn serialize_state<M: Model>(
    component: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    let call = Call::SerializeFMUstate;
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        // SAFETY: the importer's promise.
        let state = unsafe { saved::<M>(state)? }.to_bytes();
        if size < state.len() {
            return Err(Error::Pointer("size"));
        }
        // SAFETY: the importer's promise; no more than the state's size is touched.
        unsafe { slice_mut("serializedState", bytes, state.len())? }.copy_from_slice(&state);
        Ok(())
    })
}

/// `fmi2DeSerializeFMUstate`.
pub unsafe fn deserialize_state<M: Model>(
    component: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    let call = Call::DeSerializeFMUstate;
    enter_logged(component, call, |instance: &mut Instance<M>, _| {
        instance.permit(call)?;
        // A size that no state of this model has is refused before a byte is read.
        if size != instance.save()?.to_bytes().len() {
            return Err(Error::Serialised(
                "has another length than those of this model",
            ));
        }
        // SAFETY: the importer's promise.
        let saved = Saved::<M>::from_bytes(unsafe { slice("serializedState", bytes, size)? })?;
        // SAFETY: the importer's promise.
        unsafe { hand_out(place("FMUstate", state)?, saved) }
    })
}

#[cfg(test)]
mod tests;
