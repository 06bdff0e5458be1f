//! The functions that an FMU need not have: states, derivatives, log categories.

use super::{Called, Component, Instance, Status, c_text, called};
use crate::Result;
use std::ffi::{c_char, c_int, c_uint, c_void};

/// No FMU state that people exchange is larger [bytes].
const LARGEST: usize = 1 << 30;
/// Bytes behind a serialised state that the FMU must leave alone.
const GUARD: usize = 4096;
const UNTOUCHED: u8 = 0xA5;

/// A state that an instance keeps for the importer; freed on drop.
pub(in super::super) struct Saved<'a> {
    instance: &'a Instance<'a>,
    state: *mut c_void,
}

impl Drop for Saved<'_> {
    fn drop(&mut self) {
        type Free = extern "C" fn(Component, *mut *mut c_void) -> Status;
        // SAFETY: the type of fmi2FreeFMUstate in fmi2FunctionTypes.h.
        if let Ok(call) = unsafe { self.instance.binary.function::<Free>("fmi2FreeFMUstate") } {
            call(self.instance.component.as_ptr(), &raw mut self.state);
        }
    }
}

type OfState = extern "C" fn(Component, *mut *mut c_void) -> Status;

impl Instance<'_> {
    pub(in super::super) fn save(&self) -> Result<Called<Saved<'_>>> {
        const NAME: &str = "fmi2GetFMUstate";
        // SAFETY: the type of fmi2GetFMUstate in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<OfState>(NAME)? };
        let mut state = std::ptr::null_mut();
        let status = call(self.component.as_ptr(), &raw mut state);
        let saved = called(NAME, status, ()).map(|()| Saved {
            instance: self,
            state,
        });
        Ok(saved)
    }

    /// Restores a state, perhaps one of another instance of the same FMU.
    pub(in super::super) fn restore(&self, saved: &Saved<'_>) -> Result<Called> {
        const NAME: &str = "fmi2SetFMUstate";
        type Restore = extern "C" fn(Component, *mut c_void) -> Status;
        // SAFETY: the type of fmi2SetFMUstate in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Restore>(NAME)? };
        Ok(called(NAME, call(self.component.as_ptr(), saved.state), ()))
    }

    /// A state as bytes, and whether the FMU wrote beyond the size it told.
    pub(in super::super) fn serialize(&self, saved: &Saved<'_>) -> Result<Called<(Vec<u8>, bool)>> {
        const NAMES: [&str; 2] = ["fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate"];
        type Size = extern "C" fn(Component, *mut c_void, *mut usize) -> Status;
        type Serialize = extern "C" fn(Component, *mut c_void, *mut u8, usize) -> Status;
        let mut size = 0_usize;
        // SAFETY: the type of fmi2SerializedFMUstateSize in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Size>(NAMES[0])? };
        let status = call(self.component.as_ptr(), saved.state, &raw mut size);
        if let Err(refused) = called(NAMES[0], status, ()) {
            return Ok(Err(refused));
        }
        let size = size.min(LARGEST);
        let mut bytes = vec![UNTOUCHED; size + GUARD];
        // SAFETY: the type of fmi2SerializeFMUstate in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Serialize>(NAMES[1])? };
        let status = call(
            self.component.as_ptr(),
            saved.state,
            bytes.as_mut_ptr(),
            size,
        );
        let beyond = bytes.split_off(size).iter().any(|byte| *byte != UNTOUCHED);
        Ok(called(NAMES[1], status, (bytes, beyond)))
    }

    pub(in super::super) fn deserialize(&self, bytes: &[u8]) -> Result<Called<Saved<'_>>> {
        const NAME: &str = "fmi2DeSerializeFMUstate";
        type Deserialize = extern "C" fn(Component, *const u8, usize, *mut *mut c_void) -> Status;
        // SAFETY: the type of fmi2DeSerializeFMUstate in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Deserialize>(NAME)? };
        let mut state = std::ptr::null_mut();
        let status = call(
            self.component.as_ptr(),
            bytes.as_ptr(),
            bytes.len(),
            &raw mut state,
        );
        let saved = called(NAME, status, ()).map(|()| Saved {
            instance: self,
            state,
        });
        Ok(saved)
    }

    /// Derivative of one unknown by one known.
    pub(in super::super) fn directional(&self, unknown: u32, known: u32) -> Result<Called<f64>> {
        const NAME: &str = "fmi2GetDirectionalDerivative";
        type Directional = extern "C" fn(
            Component,
            *const c_uint,
            usize,
            *const c_uint,
            usize,
            *const f64,
            *mut f64,
        ) -> Status;
        // SAFETY: the type of fmi2GetDirectionalDerivative in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Directional>(NAME)? };
        let (seed, mut value) = (1.0, f64::NAN);
        let status = call(
            self.component.as_ptr(),
            &raw const unknown,
            1,
            &raw const known,
            1,
            &raw const seed,
            &raw mut value,
        );
        Ok(called(NAME, status, value))
    }

    /// Sets the first derivative of an input by time.
    pub(in super::super) fn set_slope(&self, reference: u32, value: f64) -> Result<Called> {
        const NAME: &str = "fmi2SetRealInputDerivatives";
        type Set =
            extern "C" fn(Component, *const c_uint, usize, *const c_int, *const f64) -> Status;
        // SAFETY: the type of fmi2SetRealInputDerivatives in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Set>(NAME)? };
        let order = 1;
        let status = call(
            self.component.as_ptr(),
            &raw const reference,
            1,
            &raw const order,
            &raw const value,
        );
        Ok(called(NAME, status, ()))
    }

    /// The first derivative of an output by time.
    pub(in super::super) fn slope(&self, reference: u32) -> Result<Called<f64>> {
        const NAME: &str = "fmi2GetRealOutputDerivatives";
        type Get = extern "C" fn(Component, *const c_uint, usize, *const c_int, *mut f64) -> Status;
        // SAFETY: the type of fmi2GetRealOutputDerivatives in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Get>(NAME)? };
        let (order, mut value) = (1, f64::NAN);
        let status = call(
            self.component.as_ptr(),
            &raw const reference,
            1,
            &raw const order,
            &raw mut value,
        );
        Ok(called(NAME, status, value))
    }

    /// Switches a log category on.
    pub(in super::super) fn log(&self, category: &str) -> Result<Called> {
        const NAME: &str = "fmi2SetDebugLogging";
        type Log = extern "C" fn(Component, c_int, usize, *const *const c_char) -> Status;
        // SAFETY: the type of fmi2SetDebugLogging in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<Log>(NAME)? };
        let text = c_text(category);
        let name = text.as_ptr();
        let status = call(self.component.as_ptr(), 1, 1, &raw const name);
        Ok(called(NAME, status, ()))
    }
}
