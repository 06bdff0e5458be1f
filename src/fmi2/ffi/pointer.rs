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

/// Whether two arrays, neither of them empty, are neither NULL nor misaligned.
#[inline(always)]
pub(super) fn usable<T, U>(one: *const T, other: *const U) -> bool {
    // Both at once: the low bits of one address where the multiples of its alignment are those of the other.
    let aligned = const { align_of::<U>() / align_of::<T>() };
    let low = one.addr().wrapping_mul(aligned) | other.addr();
    low.is_multiple_of(align_of::<U>()) && !one.is_null() && !other.is_null()
}

fn unusable<T>(values: *const T) -> bool {
    values.is_null() || !values.is_aligned()
}
