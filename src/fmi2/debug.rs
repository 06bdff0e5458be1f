//! What `{:?}` shows, of types whose models need not be `Debug`: enough for the message of a failed test.

use crate::{Access, Instance, Log, Model, Saved, Variable};
use core::fmt::{Debug, Formatter, Result};

impl<M> Debug for Access<M> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(self.type_name())
    }
}

impl<M> Debug for Variable<M> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.debug_struct("Variable")
            .field("name", &self.name)
            .field("type", &self.access)
            .field("causality", &self.causality)
            .field("variability", &self.variability)
            .field("unit", &self.unit.name)
            .field("min", &self.min)
            .field("max", &self.max)
            .finish_non_exhaustive()
    }
}

impl<M: Model> Debug for Instance<M> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.debug_struct("Instance")
            .field("model", &M::NAME)
            .field("state", &self.state())
            .field("time", &self.time())
            .finish_non_exhaustive()
    }
}

impl<M: Model> Debug for Saved<M> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.debug_struct("Saved")
            .field("model", &M::NAME)
            .field("state", &self.state)
            .field("time", &self.time)
            .finish_non_exhaustive()
    }
}

impl Debug for Log<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.debug_struct("Log").finish_non_exhaustive()
    }
}
