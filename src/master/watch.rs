//! What others know of runs while they are made, and how they end them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Steps of a run between two additions to [`Watch::steps`].
const ADDED: usize = 64;

/// Looks at runs from outside, and ends them at their next communication point.
#[derive(Debug, Default)]
pub struct Watch {
    ended: Arc<AtomicBool>,
    steps: AtomicUsize,
}

impl Watch {
    /// Ends all runs, each at its next communication point; rows so far are kept.
    pub fn end(&self) {
        self.ended.store(true, Relaxed);
    }

    /// Whether runs are to end.
    pub fn is_ended(&self) -> bool {
        self.ended.load(Relaxed)
    }

    /// What ends all runs when it is set: for a signal handler, or another thread.
    pub fn switch(&self) -> Arc<AtomicBool> {
        self.ended.clone()
    }

    /// Steps that all runs have made so far, but for the last ones of each.
    pub fn steps(&self) -> usize {
        self.steps.load(Relaxed)
    }

    /// Whether a run that has made so many steps is to end here.
    #[inline]
    pub(crate) fn ends(&self, made: usize) -> bool {
        if made % ADDED == ADDED - 1 {
            self.steps.fetch_add(ADDED, Relaxed);
        }
        self.ended.load(Relaxed)
    }
}
