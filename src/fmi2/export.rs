//! The list of exported functions: 34 symbols, one line each where it can be.

/// Makes a library an FMU of one model: exports the 34 functions of FMI 2.0 for co-simulation.
///
/// Call it once in a crate of type `cdylib`. A table with a fault does not compile.
#[macro_export]
macro_rules! export {
    ($model:ty) => {
        const _: () = $crate::check(<$model as $crate::Model>::VARIABLES);

        mod fmi2_functions {
            use super::*;
            use ::core::ffi::{c_char, c_int, c_void};
            use $crate::Call;
            use $crate::ffi::{self, Status};

            type M = $model;
            static GUID: ffi::GuidOnce = ffi::GuidOnce::new();

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
                _resources: *const c_char,
                callbacks: *const ffi::Callbacks,
                _visible: c_int,
                logging_on: c_int,
            ) -> *mut c_void {
                ffi::silence_panics();
                unsafe {
                    ffi::instantiate::<M>(&GUID, name, kind, guid, callbacks, logging_on != 0)
                }
            }

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
                unsafe { ffi::free_instance::<M>(c) }
            }

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2SetupExperiment(
                c: *mut c_void,
                _tolerance_defined: c_int,
                _tolerance: f64,
                start: f64,
                stop_defined: c_int,
                stop: f64,
            ) -> Status {
                unsafe { ffi::setup_experiment::<M>(c, start, (stop_defined != 0).then_some(stop)) }
            }

            $crate::export_functions! {
                fmi2SetDebugLogging(on: c_int, n: usize, categories: *const *const c_char)
                    = |c| ffi::set_debug_logging::<M>(c, on != 0, n, categories);
                fmi2EnterInitializationMode() = |c| ffi::enter_initialization_mode::<M>(c);
                fmi2ExitInitializationMode() = |c| ffi::exit_initialization_mode::<M>(c);
                fmi2Terminate() = |c| ffi::terminate::<M>(c);
                fmi2Reset() = |c| ffi::reset::<M>(c);
                fmi2GetReal(vr: *const u32, n: usize, value: *mut f64)
                    = |c| ffi::get::<M, f64, f64>(c, vr, n, value);
                fmi2GetInteger(vr: *const u32, n: usize, value: *mut c_int)
                    = |c| ffi::get::<M, i32, c_int>(c, vr, n, value);
                fmi2GetBoolean(vr: *const u32, n: usize, value: *mut c_int)
                    = |c| ffi::get::<M, bool, c_int>(c, vr, n, value);
                fmi2GetString(vr: *const u32, n: usize, _value: *mut *const c_char)
                    = |c| ffi::strings::<M>(c, Call::GetString, vr, n);
                fmi2SetReal(vr: *const u32, n: usize, value: *const f64)
                    = |c| ffi::set::<M, f64, f64>(c, vr, n, value, |value| value);
                fmi2SetInteger(vr: *const u32, n: usize, value: *const c_int)
                    = |c| ffi::set::<M, i32, c_int>(c, vr, n, value, |value| value);
                fmi2SetBoolean(vr: *const u32, n: usize, value: *const c_int)
                    = |c| ffi::set::<M, bool, c_int>(c, vr, n, value, |value| value != 0);
                fmi2SetString(vr: *const u32, n: usize, _value: *const *const c_char)
                    = |c| ffi::strings::<M>(c, Call::SetString, vr, n);
                fmi2GetFMUstate(state: *mut *mut c_void) = |c| ffi::get_state::<M>(c, state);
                fmi2SetFMUstate(state: *mut c_void) = |c| ffi::set_state::<M>(c, state);
                fmi2FreeFMUstate(state: *mut *mut c_void) = |c| ffi::free_state::<M>(c, state);
                fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize)
                    = |c| ffi::state_size::<M>(c, state, size);
                fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut u8, size: usize)
                    = |c| ffi::serialize_state::<M>(c, state, bytes, size);
                fmi2DeSerializeFMUstate(bytes: *const u8, size: usize, state: *mut *mut c_void)
                    = |c| ffi::deserialize_state::<M>(c, bytes, size, state);
                fmi2GetDirectionalDerivative(
                    _unknown: *const u32, _unknowns: usize, _known: *const u32, _knowns: usize,
                    _dv_known: *const f64, _dv_unknown: *mut f64
                ) = |c| ffi::not_offered::<M>(
                    c, Call::GetDirectionalDerivative, "directional derivatives");
                fmi2SetRealInputDerivatives(
                    vr: *const u32, n: usize, order: *const c_int, value: *const f64
                ) = |c| ffi::set_input_derivatives::<M>(c, vr, n, order, value);
                fmi2GetRealOutputDerivatives(
                    vr: *const u32, n: usize, order: *const c_int, value: *mut f64
                ) = |c| ffi::get_output_derivatives::<M>(c, vr, n, order, value);
                fmi2DoStep(time: f64, step: f64, _no_set_state: c_int)
                    = |c| ffi::do_step::<M>(c, time, step);
                fmi2CancelStep() = |c| ffi::not_offered::<M>(
                    c, Call::CancelStep, "asynchronous steps");
                fmi2GetStatus(kind: c_int, _value: *mut c_int)
                    = |c| ffi::status::<M>(c, Call::GetStatus, kind);
                fmi2GetRealStatus(kind: c_int, value: *mut f64)
                    = |c| ffi::real_status::<M>(c, kind, value);
                fmi2GetIntegerStatus(kind: c_int, _value: *mut c_int)
                    = |c| ffi::status::<M>(c, Call::GetIntegerStatus, kind);
                fmi2GetBooleanStatus(kind: c_int, _value: *mut c_int)
                    = |c| ffi::status::<M>(c, Call::GetBooleanStatus, kind);
                fmi2GetStringStatus(kind: c_int, _value: *mut *const c_char)
                    = |c| ffi::status::<M>(c, Call::GetStringStatus, kind);
            }
        }
    };
}

/// The exported functions that take a component first and return a status.
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
