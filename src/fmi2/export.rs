//! The list of exported functions: 34 symbols, one line each where it can be.

/// Makes a library an FMU of one model: exports the 34 functions of FMI 2.0 for co-simulation.
///
/// Call it once in a crate of type `cdylib`. A table with a fault does not compile.
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        const _: () = $crate::check(<$model as $crate::Model>::VARIABLES);

        /// What the FMU is described from.
        #[doc(hidden)]
        pub type FmuModel = $model;

        mod fmi2_functions {
            use super::*;
            use ::core::ffi::{c_char, c_int, c_void};
            use $crate::Call;
            use $crate::ffi::{self, Status};

            type M = $model;
            static FMU: ffi::Library<M> = ffi::Library::empty();

            #[unsafe(no_mangle)]
            pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
                c"default".as_ptr()
            }

            #[unsafe(no_mangle)]
            pub extern "C" fn fmi2GetVersion() -> *const c_char {
                c"2.0".as_ptr()
            }

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2Instantiate(
                name: *const c_char,
                kind: c_int,
                guid: *const c_char,
                resources: *const c_char,
                callbacks: *const ffi::Callbacks,
                _visible: c_int,
                logging_on: c_int,
            ) -> *mut c_void {
                ffi::silence_panics();
                unsafe { FMU.instantiate(name, kind, guid, resources, callbacks, logging_on != 0) }
            }

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
                unsafe { FMU.free_instance(c) }
            }

            $crate::export_functions! {
                fmi2SetDebugLogging(on: c_int, n: usize, categories: *const *const c_char)
                    = |c| FMU.set_debug_logging(c, on != 0, n, categories);
                fmi2GetReal(vr: *const u32, n: usize, value: *mut f64)
                    = |c| FMU.get_reals(c, vr, n, value);
                fmi2GetInteger(vr: *const u32, n: usize, value: *mut c_int)
                    = |c| FMU.get_others::<i32, c_int>(c, vr, n, value);
                fmi2GetBoolean(vr: *const u32, n: usize, value: *mut c_int)
                    = |c| FMU.get_others::<bool, c_int>(c, vr, n, value);
                fmi2GetString(vr: *const u32, n: usize, value: *mut *const c_char)
                    = |c| FMU.get_strings(c, vr, n, value);
                fmi2SetReal(vr: *const u32, n: usize, value: *const f64)
                    = |c| FMU.set_reals(c, vr, n, value);
                fmi2SetInteger(vr: *const u32, n: usize, value: *const c_int)
                    = |c| FMU.set::<i32, c_int>(c, vr, n, value, |value| value);
                fmi2SetBoolean(vr: *const u32, n: usize, value: *const c_int)
                    = |c| FMU.set::<bool, c_int>(c, vr, n, value, |value| value != 0);
                fmi2SetString(vr: *const u32, n: usize, value: *const *const c_char)
                    = |c| FMU.set_strings(c, vr, n, value);
                fmi2GetFMUstate(state: *mut *mut c_void) = |c| FMU.get_state(c, state);
                fmi2FreeFMUstate(state: *mut *mut c_void) = |c| FMU.free_state(c, state);
                fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize)
                    = |c| FMU.state_size(c, state, size);
                fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut u8, size: usize)
                    = |c| FMU.serialize_state(c, state, bytes, size);
                fmi2DeSerializeFMUstate(bytes: *const u8, size: usize, state: *mut *mut c_void)
                    = |c| FMU.deserialize_state(c, bytes, size, state);
                fmi2SetRealInputDerivatives(
                    vr: *const u32, n: usize, order: *const c_int, value: *const f64
                ) = |c| FMU.set_input_derivatives(c, vr, n, order, value);
                fmi2GetRealOutputDerivatives(
                    vr: *const u32, n: usize, order: *const c_int, value: *mut f64
                ) = |c| FMU.get_output_derivatives(c, vr, n, order, value);
                fmi2GetDirectionalDerivative(
                    unknown: *const u32, unknowns: usize, known: *const u32, knowns: usize,
                    dv_known: *const f64, dv_unknown: *mut f64
                ) = |c| FMU.directional_derivative(
                    c, (unknown, known), [unknowns, knowns], dv_known, dv_unknown);
                fmi2GetRealStatus(kind: c_int, value: *mut f64)
                    = |c| FMU.real_status(c, kind, value);
            }

            $crate::export_safe_functions! {
                fmi2SetupExperiment(
                    _tolerance_defined: c_int, _tolerance: f64,
                    start: f64, stop_defined: c_int, stop: f64
                ) = |c| FMU.enter(c, Call::SetupExperiment, |instance, _| {
                    instance.setup_experiment(start, (stop_defined != 0).then_some(stop))
                });
                fmi2EnterInitializationMode() = |c| FMU.enter(
                    c, Call::EnterInitializationMode, |i, _| i.enter_initialization());
                fmi2ExitInitializationMode() = |c| FMU.enter(
                    c, Call::ExitInitializationMode, |i, log| i.exit_initialization(log));
                fmi2Terminate() = |c| FMU.enter(c, Call::Terminate, |i, _| i.terminate());
                fmi2Reset() = |c| FMU.enter(c, Call::Reset, |i, _| i.reset());
                fmi2DoStep(time: f64, step: f64, _no_set_state: c_int)
                    = |c| FMU.step(c, time, step);
                fmi2SetFMUstate(state: *mut c_void) = |c| FMU.set_state(c, state);
                fmi2CancelStep() = |c| FMU.not_offered(c, Call::CancelStep, "asynchronous steps");
                fmi2GetStatus(kind: c_int, _value: *mut c_int)
                    = |c| FMU.status(c, Call::GetStatus, kind);
                fmi2GetIntegerStatus(kind: c_int, _value: *mut c_int)
                    = |c| FMU.status(c, Call::GetIntegerStatus, kind);
                fmi2GetBooleanStatus(kind: c_int, _value: *mut c_int)
                    = |c| FMU.status(c, Call::GetBooleanStatus, kind);
                fmi2GetStringStatus(kind: c_int, _value: *mut *const c_char)
                    = |c| FMU.status(c, Call::GetStringStatus, kind);
            }
        }
    };
}

/// The exported functions that take a component first, return a status, and follow pointers.
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    ($($name:ident($($argument:ident: $kind:ty),*) = |$c:ident| $call:expr;)*) => {
        $(
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($c: *mut c_void $(, $argument: $kind)*) -> Status {
                unsafe { $call }
            }
        )*
    };
}

/// The exported functions that take a component first, return a status, and follow no pointer.
#[doc(hidden)]
#[macro_export]
macro_rules! export_safe_functions {
    ($($name:ident($($argument:ident: $kind:ty),*) = |$c:ident| $call:expr;)*) => {
        $(
            #[unsafe(no_mangle)]
            pub extern "C" fn $name($c: *mut c_void $(, $argument: $kind)*) -> Status {
                $call
            }
        )*
    };
}
