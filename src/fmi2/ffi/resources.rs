//! The files of an FMU at the C boundary.

use super::Component;
use crate::{Category, LoadError, Model, Resources};
use core::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};

impl<M: Model> Component<M> {
    /// Gives a model the files it asks for; false, with a log line, when it cannot start from them.
    pub(super) fn load(&mut self, location: Option<&CStr>) -> bool {
        let loaded = catch_unwind(AssertUnwindSafe(|| self.try_to_load(location)));
        let fault = match loaded {
            Ok(Ok(())) => return true,
            Ok(Err(fault)) => fault,
            Err(payload) => {
                // Dropping what a model panicked with could panic again, outside the barrier.
                core::mem::forget(payload);
                "the model panicked".into()
            }
        };
        let message = format_args!("fmi2Instantiate: {fault}");
        self.reporter.send(Category::Error, message);
        false
    }

    fn try_to_load(&mut self, location: Option<&CStr>) -> Result<(), LoadError> {
        let found = Resources::named(location)?;
        let reporter = &self.reporter;
        let mut sink =
            |category, message: core::fmt::Arguments<'_>| reporter.send(category, message);
        let log = &mut crate::Log::new(&mut sink);
        self.instance.load(found.as_ref(), log)
    }
}
