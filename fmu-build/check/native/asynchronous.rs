//! Steps that an FMU goes on computing after fmi2DoStep returned: fmi2Pending.

use super::{Called, Component, Instance, Status, called};
use crate::Result;
use crate::check::trace;
use std::ffi::{c_int, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

const PENDING: Status = 5;
/// `fmi2DoStepStatus` of `fmi2StatusKind`.
const DO_STEP_STATUS: c_int = 0;
/// Between two looks at a pending step.
const PAUSE: Duration = Duration::from_micros(200);

/// Calls of `stepFinished` by all instances; an FMU calls it from a thread of its own.
static FINISHED: AtomicUsize = AtomicUsize::new(0);

/// `fmi2StepFinished`.
pub(super) extern "C" fn step_finished(_: *mut c_void, _: Status) {
    FINISHED.fetch_add(1, Ordering::SeqCst);
}

/// How often `stepFinished` was called.
pub(in super::super) fn finished() -> usize {
    FINISHED.load(Ordering::SeqCst)
}

/// How fmi2DoStep ended.
pub(in super::super) enum Begun {
    /// The step is made, or was refused.
    Over(Called),
    /// The FMU goes on computing it.
    Pending,
}

impl Instance<'_> {
    /// Makes a step to its end, however the FMU computes it.
    pub(in super::super) fn do_step(&self, time: f64, step: f64) -> Result<Called> {
        match self.begin_step(time, step)? {
            Begun::Over(called) => Ok(called),
            Begun::Pending => self.wait(),
        }
    }

    /// Calls fmi2DoStep and waits for nothing.
    pub(in super::super) fn begin_step(&self, time: f64, step: f64) -> Result<Begun> {
        type DoStep = extern "C" fn(Component, f64, f64, c_int) -> Status;
        // SAFETY: the type of fmi2DoStep in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.function::<DoStep>("fmi2DoStep")? };
        Ok(match call(self.component.as_ptr(), time, step, 1) {
            PENDING => Begun::Pending,
            status => Begun::Over(called("fmi2DoStep", status, ())),
        })
    }

    /// Waits until a step is no longer pending.
    pub(in super::super) fn wait(&self) -> Result<Called> {
        trace::announce("fmi2GetStatus of a pending step");
        loop {
            match self.step_status()? {
                Ok(PENDING) => thread::sleep(PAUSE),
                Ok(status) => return Ok(called("fmi2DoStep", status, ())),
                Err(refused) => return Ok(Err(refused)),
            }
        }
    }

    /// Whether the FMU says that a step is being computed.
    pub(in super::super) fn is_pending(&self) -> Result<bool> {
        Ok(matches!(self.step_status()?, Ok(PENDING)))
    }

    /// `fmi2GetStatus(fmi2DoStepStatus)`. Not announced: one that goes on for ever shall count as one call.
    fn step_status(&self) -> Result<Called<Status>> {
        const NAME: &str = "fmi2GetStatus";
        type GetStatus = extern "C" fn(Component, c_int, *mut Status) -> Status;
        // SAFETY: the type of fmi2GetStatus in fmi2FunctionTypes.h.
        let call = unsafe { self.binary.look_up::<GetStatus>(NAME)? };
        let mut found = PENDING;
        let status = call(self.component.as_ptr(), DO_STEP_STATUS, &raw mut found);
        Ok(called(NAME, status, found))
    }
}
