//! An instance whose model takes something from files before its life begins.

use super::Instance;
use crate::model::Log;
use crate::saved::Saved;
use crate::{Call, Error, LoadError, Model, Resources};

impl<M: Model> Instance<M> {
    /// `fmi2Instantiate`: gives the model its files. To be called once, before anything else.
    ///
    /// # Errors
    /// When the model cannot start from them.
    pub fn load(
        &mut self,
        resources: Option<&Resources>,
        log: &mut Log<'_>,
    ) -> Result<(), LoadError> {
        if const { M::RESOURCES } {
            let mut fresh = Box::new(M::default());
            fresh.load(resources, log)?;
            self.now.model.clone_from(&fresh);
            self.fresh = Some(fresh);
        }
        Ok(())
    }

    /// `fmi2Reset`: as a fresh instance, bit for bit; what was loaded stays.
    ///
    /// # Errors
    /// None in the present life cycle.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.permit(Call::Reset)?;
        self.now = Saved::new();
        if let (true, Some(fresh)) = (M::RESOURCES, &self.fresh) {
            self.now.model.clone_from(fresh);
        }
        Ok(())
    }

    /// The model as it was loaded, for states that are read back from bytes.
    pub(crate) fn fresh(&self) -> Option<&M> {
        if const { M::RESOURCES } {
            self.fresh.as_deref()
        } else {
            None
        }
    }
}
