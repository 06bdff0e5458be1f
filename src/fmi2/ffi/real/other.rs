//! Integers and Booleans, read from their places.

use crate::value::Value;

/// A type other than Real whose values have places.
pub trait Other: Value {
    /// Bit of their places.
    const BIT: u32;

    /// The value at a place.
    ///
    /// # Safety
    ///
    /// A value lies there, or the time.
    unsafe fn at(place: *const Self) -> Self;
}

impl Other for i32 {
    const BIT: u32 = 1 << 29;

    unsafe fn at(place: *const Self) -> Self {
        // SAFETY: any four bytes are an i32.
        unsafe { place.read() }
    }
}

impl Other for bool {
    const BIT: u32 = 1 << 30;

    unsafe fn at(place: *const Self) -> Self {
        // SAFETY: any byte is a u8, and that of a bool is 0 or 1.
        unsafe { place.cast::<u8>().read() != 0 }
    }
}
