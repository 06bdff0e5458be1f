//! Memory that will be written soon.

/// Numbers in a line of the cache.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 8;

/// Asks the processor to have the place of these numbers at hand when they are written; changes nothing.
///
/// An FMU that guards its instance by an atomic operation, as it should, waits there until all
/// earlier writes have reached the cache.
#[inline]
pub fn prefetch(numbers: &[f64]) {
    #[cfg(target_arch = "x86_64")]
    for number in numbers.iter().step_by(LINE) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        use std::ptr::from_ref;
        // SAFETY: a hint: at no address does it read, write or fault.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(from_ref(number).cast()) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = numbers;
}
