//! The Reals of an ordinary exchange, without a second look at them.

use super::Instance;
use crate::Model;
use crate::ffi::real;

impl<M: Model> Instance<M> {
    /// [`Self::get`] of Reals where that needs no second look; else it does nothing and returns false.
    #[inline(always)]
    pub(crate) fn get_plainly(&mut self, references: &[u32], values: &mut [f64]) -> bool {
        let plain = !self.now.stale && real::readable(&mut self.now, references);
        if plain {
            for (to, &reference) in values.iter_mut().zip(references) {
                let Some(field) = real::field(&mut self.now, reference) else {
                    break;
                };
                *to = *field;
            }
        }
        plain
    }

    /// [`Self::set`] of Reals where that needs no second look; else it does nothing and returns false.
    #[inline(always)]
    pub(crate) fn set_plainly(&mut self, references: &[u32], values: &[f64]) -> bool {
        let plain = real::settable(&mut self.now, references, values);
        if plain {
            for (&value, &reference) in values.iter().zip(references) {
                let Some(field) = real::field(&mut self.now, reference) else {
                    break;
                };
                *field = value;
            }
            self.now.stale = true;
        }
        plain
    }
}
