//! An instance of an FMI 2.0 co-simulation FMU on the raw binding of the [`fmi`] crate 0.8.
//!
//! All unsafe code of the master is in this crate: each block is one call, or one look into memory
//! ([`Places`], [`prefetch`]). The calls are here because the safe instance of the `fmi` crate hides
//! its component, and with it cannot
//! - set input derivatives or get output derivatives;
//! - give a message's category, or survive a message without one, or a status Pending;
//! - say that an FMU lacks a function other than by a panic.
//!
//! What the code relies on. FMI 2.0.4, 2.1 and 4.2, promises of the FMU: functions have the types of
//! the standard's headers; they read and write as many array elements as they are told to and keep no pointer to
//! them; an instance is used until fmi2FreeInstance. Ours: an [`Instance`] cannot be shared between
//! threads, its library is unloaded after it is freed, and the files of the FMU are the caller's to keep.

mod calls;
mod log;
mod memory;
mod status;

pub use calls::Calls;
pub use log::{Log, MESSAGES, Message};
pub use memory::{Places, prefetch};
pub use status::Status;

use calls::number;
use fmi::fmi2::binding::{
    Fmi2Binding, fmi2CallbackFunctions, fmi2Component, fmi2Status,
    fmi2StatusKind_fmi2LastSuccessfulTime, fmi2StatusKind_fmi2Terminated,
    fmi2Type_fmi2CoSimulation,
};
use fmi::fmi2::import::Fmi2Import;
use fmi::traits::FmiImport;
use std::ffi::{CString, c_char, c_void};
use std::sync::Arc;

/// The generationTool of FMUs that this project built starts with this.
const OURS: &str = "fmu-build ";

/// What a call came to; an fmi2Warning is none.
pub type Called = Result<(), Status>;

unsafe extern "C" {
    fn cosim_logger(
        log: *mut c_void,
        instance: *const c_char,
        status: fmi2Status,
        category: *const c_char,
        message: *const c_char,
        ...
    );
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

/// The library of an FMU, which stays loaded: instances that are made meanwhile need not load it.
pub struct Loaded {
    _binding: Fmi2Binding,
}

impl Loaded {
    /// Loads the library of an FMU that this project built; none of others, which may keep something of
    /// one run for the next where nothing unloads them.
    pub fn new(import: &Fmi2Import) -> Option<Self> {
        let description = import.model_description();
        let kind = description.co_simulation.as_ref()?;
        ours(import).then_some(())?;
        let _binding = import.binding(&kind.model_identifier).ok()?;
        Some(Self { _binding })
    }
}

/// This project built the FMU.
fn ours(import: &Fmi2Import) -> bool {
    let tool = import.model_description().generation_tool.as_deref();
    tool.is_some_and(|tool| tool.starts_with(OURS))
}

/// A living instance; freed and unloaded when dropped, not terminated.
pub struct Instance {
    component: fmi2Component,
    access: Access,
    binding: Fmi2Binding,
    /// Until the FMU is freed it may call these, and they add to the log.
    _callbacks: Box<fmi2CallbackFunctions>,
    log: Arc<Log>,
}

impl Instance {
    /// Loads the library of an unpacked FMU and makes an instance; what it says goes to `log`. FMUs
    /// that this project built have debug logging on: they tell why they refuse a call, what they
    /// warn of, and their events. Others may tell of every call: of them only what they say unasked is heard, unless
    /// the log asks for more.
    ///
    /// # Errors
    ///
    /// It does not load, lacks a function, has a name or GUID with a zero byte, or refuses.
    pub fn new(import: &Fmi2Import, name: &str, log: Arc<Log>) -> Result<Self, fmi::Error> {
        let description = import.model_description();
        let kind = description.co_simulation.as_ref();
        let kind = kind.ok_or_else(|| fmi::Error::UnsupportedFmuType("CS".into()))?;
        log.enter(const { number("the loading of its library") });
        let binding = import.binding(&kind.model_identifier)?;
        lacks(&binding).map_or(Ok(()), |function| {
            let what = format!("its library has no {function}");
            Err(fmi::Error::ArchiveStructure(what))
        })?;
        let texts = [
            name.to_owned(),
            description.guid.clone(),
            import.canonical_resource_path_string(),
        ];
        let speaks = log.turn_on(ours(import));
        Self::instantiate(binding, texts.map(CString::new), speaks, log)
    }

    /// `texts`: name, GUID, place of the resources.
    fn instantiate(
        binding: Fmi2Binding,
        texts: [Result<CString, std::ffi::NulError>; 3],
        speaks: bool,
        log: Arc<Log>,
    ) -> Result<Self, fmi::Error> {
        let [Ok(name), Ok(guid), Ok(place)] = &texts else {
            let what = "its name, GUID or folder has a zero byte";
            return Err(fmi::Error::ArchiveStructure(what.into()));
        };
        let callbacks = Box::new(fmi2CallbackFunctions {
            logger: Some(cosim_logger),
            allocateMemory: Some(calloc),
            freeMemory: Some(free),
            stepFinished: None,
            componentEnvironment: Arc::as_ptr(&log).cast_mut().cast(),
        });
        log.enter(const { number("fmi2Instantiate") });
        // SAFETY: texts end with a null character; the callbacks and what they point at live as long as
        // the instance.
        let component = unsafe {
            binding.fmi2Instantiate(
                name.as_ptr(),
                fmi2Type_fmi2CoSimulation,
                guid.as_ptr(),
                place.as_ptr(),
                &raw const *callbacks,
                0,
                speaks.into(),
            )
        };
        if component.is_null() {
            return Err(fmi::Error::Instantiation);
        }
        Ok(Self {
            component,
            access: Access::of(&binding),
            binding,
            _callbacks: callbacks,
            log,
        })
    }

    /// fmi2SetupExperiment from 0 to `stop` [s], without a tolerance.
    pub fn setup_experiment(&mut self, stop: f64) -> Called {
        self.log.enter(const { number("fmi2SetupExperiment") });
        // SAFETY: the instance lives.
        let status = unsafe {
            self.binding
                .fmi2SetupExperiment(self.component, 0, 0.0, 0.0, 1, stop)
        };
        Status::check(status)
    }

    /// fmi2EnterInitializationMode.
    pub fn enter_initialization_mode(&mut self) -> Called {
        self.log
            .enter(const { number("fmi2EnterInitializationMode") });
        // SAFETY: the instance lives.
        Status::check(unsafe { self.binding.fmi2EnterInitializationMode(self.component) })
    }

    /// fmi2ExitInitializationMode.
    pub fn exit_initialization_mode(&mut self) -> Called {
        self.log
            .enter(const { number("fmi2ExitInitializationMode") });
        // SAFETY: the instance lives.
        Status::check(unsafe { self.binding.fmi2ExitInitializationMode(self.component) })
    }

    /// fmi2Terminate.
    pub fn terminate(&mut self) -> Called {
        self.log.enter(const { number("fmi2Terminate") });
        // SAFETY: the instance lives.
        Status::check(unsafe { self.binding.fmi2Terminate(self.component) })
    }

    /// fmi2DoStep from `time` by `step` [s].
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Called {
        self.log.enter(const { number("fmi2DoStep") });
        // SAFETY: the instance lives.
        Status::check(unsafe { self.binding.fmi2DoStep(self.component, time, step, 1) })
    }

    /// fmi2LastSuccessfulTime [s] after a discarded step; none when the FMU does not tell it.
    pub fn last_successful_time(&mut self) -> Option<f64> {
        let kind = fmi2StatusKind_fmi2LastSuccessfulTime;
        let mut time = f64::NAN;
        self.binding.fmi2GetRealStatus.is_ok().then_some(())?;
        self.log.enter(const { number("fmi2GetRealStatus") });
        // SAFETY: the instance lives, and so does the one number that is written.
        let status = unsafe {
            self.binding
                .fmi2GetRealStatus(self.component, kind, &raw mut time)
        };
        Status::check(status).ok().map(|()| time)
    }

    /// fmi2Terminated after a discarded step: the FMU wants the simulation to end; false when it does not tell.
    pub fn is_terminated(&mut self) -> bool {
        let mut terminated = 0;
        if self.binding.fmi2GetBooleanStatus.is_err() {
            return false;
        }
        self.log.enter(const { number("fmi2GetBooleanStatus") });
        // SAFETY: the instance lives, and so does the one number that is written.
        let status = unsafe {
            self.binding.fmi2GetBooleanStatus(
                self.component,
                fmi2StatusKind_fmi2Terminated,
                &raw mut terminated,
            )
        };
        Status::check(status).is_ok() && terminated != 0
    }

    /// fmi2SetRealInputDerivatives of first order; `orders` has a 1 for each.
    pub fn set_slopes(&mut self, references: &[u32], orders: &[i32], slopes: &[f64]) -> Called {
        let count = references.len().min(orders.len()).min(slopes.len());
        if self.binding.fmi2SetRealInputDerivatives.is_err() {
            return Err(Status::Missing);
        }
        self.log
            .enter(const { number("fmi2SetRealInputDerivatives") });
        // SAFETY: the instance lives, and the arrays have `count` elements at least.
        let status = unsafe {
            self.binding.fmi2SetRealInputDerivatives(
                self.component,
                references.as_ptr(),
                count,
                orders.as_ptr(),
                slopes.as_ptr(),
            )
        };
        Status::check(status)
    }

    /// fmi2GetRealOutputDerivatives of first order; `orders` has a 1 for each.
    pub fn get_slopes(&mut self, references: &[u32], orders: &[i32], slopes: &mut [f64]) -> Called {
        let count = references.len().min(orders.len()).min(slopes.len());
        if self.binding.fmi2GetRealOutputDerivatives.is_err() {
            return Err(Status::Missing);
        }
        self.log
            .enter(const { number("fmi2GetRealOutputDerivatives") });
        // SAFETY: the instance lives, and the arrays have `count` elements at least.
        let status = unsafe {
            self.binding.fmi2GetRealOutputDerivatives(
                self.component,
                references.as_ptr(),
                count,
                orders.as_ptr(),
                slopes.as_mut_ptr(),
            )
        };
        Status::check(status)
    }
}

/// Functions of one type: as many values as both slices have.
macro_rules! access {
    ($($name:ident $function:ident $kind:ty, $pointer:ident $to:tt $($mutable:ident)?;)*) => {
        /// Functions that every step calls, of those of the binding that are there.
        struct Access {$(
            $name: Option<unsafe extern "C" fn(fmi2Component, *const u32, usize, *$to $kind) -> fmi2Status>,
        )*}

        impl Access {
            fn of(binding: &Fmi2Binding) -> Self {
                Self {$(
                    $name: binding.$function.as_ref().ok().copied(),
                )*}
            }
        }

        impl Instance {$(
            #[doc = concat!(stringify!($function), ".")]
            #[inline]
            pub fn $name(&mut self, references: &[u32], values: &$($mutable)? [$kind]) -> Called {
                let count = references.len().min(values.len());
                let (references, values) = (references.as_ptr(), values.$pointer());
                let function = self.access.$name.ok_or(Status::Missing)?;
                self.log.enter(const { number(stringify!($function)) });
                // SAFETY: the instance lives, and both arrays have `count` elements at least.
                let status = unsafe { function(self.component, references, count, values) };
                Status::check(status)
            }
        )*}
    };
}

access! {
    set_real fmi2SetReal f64, as_ptr const;
    set_integer fmi2SetInteger i32, as_ptr const;
    set_boolean fmi2SetBoolean i32, as_ptr const;
    get_real fmi2GetReal f64, as_mut_ptr mut mut;
    get_integer fmi2GetInteger i32, as_mut_ptr mut mut;
    get_boolean fmi2GetBoolean i32, as_mut_ptr mut mut;
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.log.enter(const { number("fmi2FreeInstance") });
        // SAFETY: the instance lives and is not used again; its library is unloaded after this.
        unsafe { self.binding.fmi2FreeInstance(self.component) }
    }
}

/// The first of the functions that every run calls that is not there.
fn lacks(binding: &Fmi2Binding) -> Option<&'static str> {
    macro_rules! first {
        ($($function:ident)*) => {
            [$((stringify!($function), binding.$function.is_ok())),*]
        };
    }
    let functions = first![
        fmi2Instantiate fmi2FreeInstance fmi2SetupExperiment fmi2EnterInitializationMode
        fmi2ExitInitializationMode fmi2Terminate fmi2DoStep
    ];
    let missing = functions.iter().find(|(_, there)| !there);
    missing.map(|(function, _)| *function)
}
