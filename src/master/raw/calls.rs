//! The call into an FMU that is under way, for those who wait for it.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// What a run calls, as it is told.
const NAMES: [&str; 18] = [
    "the loading of its library",
    "fmi2Instantiate",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2FreeInstance",
    "fmi2DoStep",
    "fmi2GetRealStatus",
    "fmi2GetBooleanStatus",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2SetRealInputDerivatives",
    "fmi2GetRealOutputDerivatives",
];

/// The last call of a run into any of its FMUs; it may have returned.
#[derive(Debug, Default)]
pub struct Calls(AtomicU64);

impl Calls {
    /// Instance and function of the last call; none before the first.
    pub fn last(&self) -> Option<(usize, &'static str)> {
        let word = self.0.load(Relaxed);
        let instance = usize::try_from(word >> 8).ok()?;
        let function = usize::try_from(word & 0xff).ok()?.checked_sub(1)?;
        Some((instance, NAMES.get(function)?))
    }

    /// Tells a call into the instance of this word ([`of`]).
    #[inline]
    pub(crate) fn enter(&self, instance: u64, function: u64) {
        self.0.store(instance | function, Relaxed);
    }
}

/// The word of an instance for [`Calls::enter`].
pub(crate) const fn of(instance: u32) -> u64 {
    (instance as u64) << 8
}

/// Number of a function for [`Calls::enter`]; in a `const` an unknown one does not compile.
pub(crate) const fn number(name: &str) -> u64 {
    let mut at = 0;
    while !same(NAMES[at].as_bytes(), name.as_bytes()) {
        at += 1;
    }
    at as u64 + 1
}

const fn same(one: &[u8], other: &[u8]) -> bool {
    let mut at = 0;
    while at < one.len() && at < other.len() && one[at] == other[at] {
        at += 1;
    }
    at == one.len() && at == other.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_call_is_told() {
        let calls = Calls::default();
        assert_eq!(calls.last(), None);
        for (k, name) in NAMES.iter().enumerate() {
            let instance = u32::try_from(1000 * k).unwrap();
            calls.enter(of(instance), number(name));
            assert_eq!(calls.last(), Some((1000 * k, *name)));
        }
    }
}
