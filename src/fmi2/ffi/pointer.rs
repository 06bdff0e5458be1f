//! The importer's pointers, turned into references once they are neither NULL nor misaligned.
//!
//! What is unsafe here is the importer's promise: an array has the length that is passed with it, a
//! string ends with NUL, and nobody else uses either during the call.

use crate::Error;
use core::ffi::{CStr, c_char};

/// An array of `count` values; that of an empty one is not looked at.
pub(super) unsafe fn slice<'a, T>(
    argument: &'static str,
    values: *const T,
    count: usize,
) -> Result<&'a [T], Error> {
    match count {
        0 => Ok(&[]),
        _ if unusable(values) => Err(Error::Pointer(argument)),
        // SAFETY: not NULL, aligned, and by the importer's promise of that length.
        _ => Ok(unsafe { core::slice::from_raw_parts(values, count) }),
    }
}

/// [`slice`] of one value or more; `None` where it needs a second look.
#[inline(always)]
pub(super) unsafe fn few<'a, T>(values: *const T, count: usize) -> Option<&'a [T]> {
    let plain = count > 0 && !unusable(values);
    // SAFETY: not NULL, aligned, and by the importer's promise of that length.
    plain.then(|| unsafe { core::slice::from_raw_parts(values, count) })
}

/// [`slice_mut`] of one value or more; `None` where it needs a second look.
#[inline(always)]
pub(super) unsafe fn few_mut<'a, T>(values: *mut T, count: usize) -> Option<&'a mut [T]> {
    let plain = count > 0 && !unusable(values);
    // SAFETY: as above, and the importer reads it after the call only.
    plain.then(|| unsafe { core::slice::from_raw_parts_mut(values, count) })
}

/// An array of `count` values, to be written.
pub(super) unsafe fn slice_mut<'a, T>(
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

/// A single value, to be written.
pub(super) unsafe fn place<'a, T>(
    argument: &'static str,
    value: *mut T,
) -> Result<&'a mut T, Error> {
    if unusable(value) {
        return Err(Error::Pointer(argument));
    }
    // SAFETY: not NULL, aligned, and by the importer's promise writable.
    Ok(unsafe { &mut *value })
}

/// A string; `None` for NULL.
pub(super) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL, and by the importer's promise NUL-terminated.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

fn unusable<T>(values: *const T) -> bool {
    values.is_null() || !values.is_aligned()
}
