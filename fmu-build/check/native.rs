//! The C interface of an FMU's library, as far as the check calls it. All unsafe code is here.
#![allow(unsafe_code)]

mod abilities;
mod asynchronous;

pub(super) use abilities::Saved;
pub(super) use asynchronous::{Begun, finished};

use super::trace;
use crate::{Error, Result};
use libloading::{Library, Symbol};
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::path::{Path, PathBuf};
use std::ptr::NonNull;

/// All functions of FMI 2.0 for co-simulation.
pub(super) const FUNCTIONS: [&str; 34] = [
    "fmi2GetTypesPlatform",
    "fmi2GetVersion",
    "fmi2SetDebugLogging",
    "fmi2Instantiate",
    "fmi2FreeInstance",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2Reset",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2GetString",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2SetString",
    "fmi2GetFMUstate",
    "fmi2SetFMUstate",
    "fmi2FreeFMUstate",
    "fmi2SerializedFMUstateSize",
    "fmi2SerializeFMUstate",
    "fmi2DeSerializeFMUstate",
    "fmi2GetDirectionalDerivative",
    "fmi2SetRealInputDerivatives",
    "fmi2GetRealOutputDerivatives",
    "fmi2DoStep",
    "fmi2CancelStep",
    "fmi2GetStatus",
    "fmi2GetRealStatus",
    "fmi2GetIntegerStatus",
    "fmi2GetBooleanStatus",
    "fmi2GetStringStatus",
];

type Component = *mut c_void;
type Status = c_int;
/// `fmi2OK`; `fmi2Warning` is 1 and still means that the call was carried out.
const OK: Status = 0;
const WARNING: Status = 1;
/// `fmi2CoSimulation` of `fmi2Type`.
const CO_SIMULATION: c_int = 1;

/// A call that the FMU did not carry out.
#[derive(Debug)]
pub(super) struct Refused {
    /// The function.
    pub function: &'static str,
    /// The `fmi2Status` it returned.
    pub status: i32,
}

type Called<T = ()> = std::result::Result<T, Refused>;

type Logger = extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char);

/// `fmi2CallbackFunctions`. The logger of C has further arguments, which ours does not look at.
#[repr(C)]
struct Callbacks {
    logger: Logger,
    allocate_memory: Option<extern "C" fn(usize, usize) -> *mut c_void>,
    free_memory: Option<extern "C" fn(*mut c_void)>,
    step_finished: extern "C" fn(*mut c_void, Status),
    component_environment: *mut c_void,
}

unsafe extern "C" {
    safe fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

extern "C" fn allocate_memory(count: usize, size: usize) -> *mut c_void {
    calloc(count, size)
}

extern "C" fn free_memory(memory: *mut c_void) {
    // SAFETY: FMI 2.0.4, 2.1.5: the FMU hands back what `allocate_memory` gave it, or null.
    unsafe { free(memory) }
}

thread_local! {
    /// What the FMU logged during the check.
    static MESSAGES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

extern "C" fn logger(
    _: *mut c_void,
    _: *const c_char,
    _: Status,
    _: *const c_char,
    message: *const c_char,
) {
    if message.is_null() {
        return;
    }
    // SAFETY: FMI 2.0.4, 2.1.5: the message is a text ended by a null character.
    let text = unsafe { CStr::from_ptr(message) }
        .to_string_lossy()
        .into_owned();
    MESSAGES.with_borrow_mut(|messages| messages.push(text));
}

/// Takes what the FMU has logged since the last call.
pub(super) fn take_messages() -> Vec<String> {
    MESSAGES.with_borrow_mut(std::mem::take)
}

/// A loaded library.
pub(super) struct Binary {
    library: Library,
    path: PathBuf,
}

impl Binary {
    pub(super) fn load(path: &Path) -> Result<Self> {
        trace::announce("its loading");
        // SAFETY: runs the initialisers of the library; the caller of `check` knows its origin.
        let library = unsafe { Library::new(path) };
        let library = library.map_err(|source| Error::Load {
            path: path.into(),
            source,
        })?;
        Ok(Self {
            library,
            path: path.into(),
        })
    }

    /// Those of [`FUNCTIONS`] that the library lacks.
    pub(super) fn missing(&self) -> Vec<&'static str> {
        // SAFETY: the symbol is looked up, not used, so its type does not matter.
        let lacks = |name: &&str| unsafe { self.library.get::<*const c_void>(*name) }.is_err();
        FUNCTIONS.into_iter().filter(lacks).collect()
    }

    /// The text that `fmi2GetVersion` or `fmi2GetTypesPlatform` returns.
    pub(super) fn text(&self, function: &'static str) -> Result<String> {
        // SAFETY: both have this type in fmi2FunctionTypes.h.
        let call = unsafe { self.function::<extern "C" fn() -> *const c_char>(function)? };
        let text = call();
        if text.is_null() {
            return Ok(String::new());
        }
        // SAFETY: FMI 2.0.4, 2.1.4: a text ended by a null character that lives with the library.
        Ok(unsafe { CStr::from_ptr(text) }
            .to_string_lossy()
            .into_owned())
    }

    /// Instantiates, with the importer's functions for memory or without; `None` when the FMU refuses.
    pub(super) fn instantiate(
        &self,
        guid: &str,
        resources: &str,
        memory: bool,
    ) -> Result<Option<Instance<'_>>> {
        type Instantiate = extern "C" fn(
            *const c_char,
            c_int,
            *const c_char,
            *const c_char,
            *const Callbacks,
            c_int,
            c_int,
        ) -> Component;
        // SAFETY: the type of fmi2Instantiate in fmi2FunctionTypes.h.
        let call = unsafe { self.function::<Instantiate>("fmi2Instantiate")? };
        let callbacks = Box::new(Callbacks {
            logger,
            allocate_memory: memory.then_some(allocate_memory),
            free_memory: memory.then_some(free_memory),
            step_finished: asynchronous::step_finished,
            component_environment: std::ptr::null_mut(),
        });
        let (guid, resources) = (c_text(guid), c_text(resources));
        let component = call(
            c"check".as_ptr(),
            CO_SIMULATION,
            guid.as_ptr(),
            resources.as_ptr(),
            &raw const *callbacks,
            0,
            1,
        );
        let instance = |component| Instance {
            binary: self,
            component,
            _callbacks: callbacks,
        };
        Ok(NonNull::new(component).map(instance))
    }

    /// Looks up a function that is called next.
    ///
    /// # Safety
    /// `F` is the function pointer type that fmi2FunctionTypes.h gives for `name`.
    unsafe fn function<F>(&self, name: &'static str) -> Result<Symbol<'_, F>> {
        trace::announce(name);
        // SAFETY: promised by the caller.
        unsafe { self.look_up(name) }
    }

    /// Looks up a function.
    ///
    /// # Safety
    /// As that of [`Self::function`].
    unsafe fn look_up<F>(&self, name: &'static str) -> Result<Symbol<'_, F>> {
        // SAFETY: promised by the caller.
        let found = unsafe { self.library.get::<F>(name) };
        found.map_err(|source| Error::Load {
            path: self.path.clone(),
            source,
        })
    }
}

impl Drop for Binary {
    fn drop(&mut self) {
        trace::announce("its unloading");
    }
}

/// The text up to its first null character, which no legal text has.
fn c_text(text: &str) -> CString {
    let legal: Vec<u8> = text.bytes().take_while(|byte| *byte != 0).collect();
    CString::new(legal).unwrap_or_default()
}

/// An instance; freed on drop. The FMU may keep the pointer to the callbacks until then.
pub(super) struct Instance<'a> {
    binary: &'a Binary,
    component: NonNull<c_void>,
    _callbacks: Box<Callbacks>,
}

impl Instance<'_> {
    pub(super) fn setup_experiment(&self, start: f64) -> Result<Called> {
        type Setup = extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> Status;
        // SAFETY: the type of fmi2SetupExperiment in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Setup>("fmi2SetupExperiment")? };
        let status = call(self.component.as_ptr(), 0, 0.0, start, 0, 0.0);
        Ok(called("fmi2SetupExperiment", status, ()))
    }

    /// Calls one of the functions that take nothing but the instance.
    pub(super) fn call(&self, function: Transition) -> Result<Called> {
        let name = function.name();
        // SAFETY: every `Transition` has this type in fmi2FunctionTypes.h.
        let call = unsafe {
            self.binary
                .function::<extern "C" fn(Component) -> Status>(name)?
        };
        Ok(called(name, call(self.component.as_ptr()), ()))
    }

    pub(super) fn real(&self, reference: u32) -> Result<Called<f64>> {
        self.get("fmi2GetReal", reference, f64::NAN)
    }

    pub(super) fn integer(&self, reference: u32) -> Result<Called<i32>> {
        self.get("fmi2GetInteger", reference, 0)
    }

    pub(super) fn boolean(&self, reference: u32) -> Result<Called<bool>> {
        let value: Called<c_int> = self.get("fmi2GetBoolean", reference, 0)?;
        Ok(value.map(|value| value != 0))
    }

    pub(super) fn string(&self, reference: u32) -> Result<Called<String>> {
        let value = self.get("fmi2GetString", reference, std::ptr::null::<c_char>())?;
        let text = |value: *const c_char| {
            if value.is_null() {
                return String::new();
            }
            // SAFETY: FMI 2.0.4, 2.1.7: a text ended by a null character, valid until the next call.
            unsafe { CStr::from_ptr(value) }
                .to_string_lossy()
                .into_owned()
        };
        Ok(value.map(text))
    }

    pub(super) fn set_real(&self, reference: u32, value: f64) -> Result<Called> {
        self.set("fmi2SetReal", reference, value)
    }

    pub(super) fn set_integer(&self, reference: u32, value: i32) -> Result<Called> {
        self.set("fmi2SetInteger", reference, value)
    }

    pub(super) fn set_boolean(&self, reference: u32, value: bool) -> Result<Called> {
        self.set("fmi2SetBoolean", reference, c_int::from(value))
    }

    pub(super) fn set_string(&self, reference: u32, value: &str) -> Result<Called> {
        let text = c_text(value);
        self.set("fmi2SetString", reference, text.as_ptr())
    }

    fn set<T>(&self, name: &'static str, reference: u32, value: T) -> Result<Called> {
        type Set<T> = extern "C" fn(Component, *const c_uint, usize, *const T) -> Status;
        // SAFETY: the private callers pair each name with its type of fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Set<T>>(name)? };
        let status = call(
            self.component.as_ptr(),
            &raw const reference,
            1,
            &raw const value,
        );
        Ok(called(name, status, ()))
    }

    fn get<T>(&self, name: &'static str, reference: u32, mut value: T) -> Result<Called<T>> {
        type Get<T> = extern "C" fn(Component, *const c_uint, usize, *mut T) -> Status;
        // SAFETY: the private callers pair each name with its type of fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Get<T>>(name)? };
        let status = call(
            self.component.as_ptr(),
            &raw const reference,
            1,
            &raw mut value,
        );
        Ok(called(name, status, value))
    }
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        // SAFETY: the type of fmi2FreeInstance in fmi2FunctionTypes.h.
        let call = unsafe {
            self.binary
                .function::<extern "C" fn(Component)>("fmi2FreeInstance")
        };
        if let Ok(call) = call {
            call(self.component.as_ptr());
        }
    }
}

/// Functions that take nothing but the instance.
#[derive(Debug, Clone, Copy)]
pub(super) enum Transition {
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    CancelStep,
}

impl Transition {
    fn name(self) -> &'static str {
        match self {
            Self::EnterInitializationMode => "fmi2EnterInitializationMode",
            Self::ExitInitializationMode => "fmi2ExitInitializationMode",
            Self::Terminate => "fmi2Terminate",
            Self::Reset => "fmi2Reset",
            Self::CancelStep => "fmi2CancelStep",
        }
    }
}

fn called<T>(function: &'static str, status: Status, value: T) -> Called<T> {
    if matches!(status, OK | WARNING) {
        Ok(value)
    } else {
        Err(Refused { function, status })
    }
}
