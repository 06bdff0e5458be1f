//! The importer's pointers, turned into references once they are neither NULL nor misaligned.
//!
//! What is unsafe here is what cannot be seen of a pointer; `ffi.rs` says who promises it. The lifetime of a reference
//! is the caller's to choose: it may not outlast the call of the importer.

use crate::Error;
use core::ffi::{CStr, c_char};

/// An array of `count` values; that of an empty one is not looked at.
///
/// # Safety
/// A pointer that is usable points at `count` values of `T`, which nobody writes to during `'a`.
pub(super) unsafe fn slice<'a, T>(
    argument: &'static str,
    values: *const T,
    count: usize,
) -> Result<&'a [T], Error> {
    match count {
        0 => Ok(&[]),
        _ if unusable(values) => Err(Error::Pointer(argument)),
        // SAFETY: not NULL, aligned; the length is this function's condition.
        _ => Ok(unsafe { core::slice::from_raw_parts(values, count) }),
    }
}

/// An array of `count` values, to be written.
///
/// # Safety
/// A pointer that is usable points at `count` values of `T`, which nobody else uses during `'a`.
pub(super) unsafe fn slice_mut<'a, T>(
    argument: &'static str,
    values: *mut T,
    count: usize,
) -> Result<&'a mut [T], Error> {
    match count {
        0 => Ok(&mut []),
        _ if unusable(values) => Err(Error::Pointer(argument)),
        // SAFETY: not NULL, aligned; length and that it is nobody else's are this function's condition.
        _ => Ok(unsafe { core::slice::from_raw_parts_mut(values, count) }),
    }
}

/// A single value, to be written.
///
/// # Safety
/// A pointer that is usable points at a `T`, which nobody else uses during `'a`.
pub(super) unsafe fn place<'a, T>(
    argument: &'static str,
    value: *mut T,
) -> Result<&'a mut T, Error> {
    if unusable(value) {
        return Err(Error::Pointer(argument));
    }
    // SAFETY: not NULL, aligned; that it is there and nobody else's is this function's condition.
    Ok(unsafe { &mut *value })
}

/// A string; `None` for NULL.
///
/// # Safety
/// A pointer that is not NULL points at a string that ends with NUL, and which nobody writes to during `'a`.
pub(super) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL; that it ends is this function's condition.
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
