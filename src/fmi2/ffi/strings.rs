//! Strings at the C boundary: copied out of the model and into it.

use super::pointer::{slice, slice_mut, text};
use super::variables::plausible;
use super::{Library, Status};
use crate::row::has_strings;
use crate::{Call, Error, Model};
use core::ffi::{c_char, c_void};
use std::ffi::CString;

impl<M: Model> Library<M> {
    /// `fmi2GetString`: the texts are the instance's, and stay until it is asked for strings again.
    pub unsafe fn get_strings(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *mut *const c_char,
    ) -> Status {
        if const { !has_strings::<M>() } {
            // SAFETY: `count` references (Arrays, 2.1.7).
            return unsafe { self.no_strings(component, Call::GetString, references, count) };
        }
        self.enter_component(component, Call::GetString, |component| {
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            // SAFETY: room for `count` strings (Arrays, 2.1.7) that lies apart (Stillness).
            let values = unsafe { slice_mut("value", values, count)? };
            let mut texts = Box::default();
            component.with_log(|instance, log| {
                texts = instance.strings(references, log)?.map(c_string).collect();
                Ok(())
            })?;
            component.texts = texts;
            for (to, text) in values.iter_mut().zip(&component.texts) {
                *to = text.as_ptr();
            }
            Ok(())
        })
    }

    /// `fmi2SetString`: texts in UTF-8.
    pub unsafe fn set_strings(
        &self,
        component: *mut c_void,
        references: *const u32,
        count: usize,
        values: *const *const c_char,
    ) -> Status {
        if const { !has_strings::<M>() } {
            // SAFETY: `count` references (Arrays, 2.1.7).
            return unsafe { self.no_strings(component, Call::SetString, references, count) };
        }
        self.enter(component, Call::SetString, |instance, _| {
            instance.permit(Call::SetString)?;
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            // SAFETY: `count` strings (Arrays, 2.1.7).
            let values = unsafe { slice("value", values, count)? };
            let read = |&value: &*const c_char| {
                // SAFETY: NULL, or it ends (Strings).
                let text = unsafe { text(value) }.ok_or(Error::Pointer("value"))?;
                text.to_str().map_err(|_| Error::NotUtf8)
            };
            let texts: Vec<&str> = values.iter().map(read).collect::<Result<_, _>>()?;
            instance.set_strings(references, &texts)
        })
    }

    /// Both where there are no strings: only empty calls are legal.
    unsafe fn no_strings(
        &self,
        component: *mut c_void,
        call: Call,
        references: *const u32,
        count: usize,
    ) -> Status {
        self.enter(component, call, |instance, _| {
            instance.permit(call)?;
            plausible::<M>(count)?;
            // SAFETY: `count` references (Arrays, 2.1.7).
            let references = unsafe { slice("vr", references, count)? };
            let kind = "String";
            references.first().map_or(Ok(()), |&reference| {
                Err(Error::UnknownReference { reference, kind })
            })
        })
    }
}

/// For C, which a NUL would tell that the text ends there.
fn c_string(text: String) -> CString {
    let mut bytes = text.into_bytes();
    bytes.retain(|byte| *byte != 0);
    CString::new(bytes).unwrap_or_default()
}
