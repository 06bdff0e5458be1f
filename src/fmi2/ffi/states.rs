//! FMU states at the C boundary: made, restored, freed, turned into bytes and back.

use super::pointer::{place, slice, slice_mut};
use super::{Library, Status, handed_out};
use crate::handle::Entered;
use crate::saved::Saved;
use crate::{Call, Error, Model};
use core::ffi::c_void;
use core::ptr::null_mut;

impl<M: Model> Library<M> {
    /// `fmi2GetFMUstate`: makes a state, or overwrites the one that `*state` holds.
    pub unsafe fn get_state(&self, component: *mut c_void, state: *mut *mut c_void) -> Status {
        self.enter(component, Call::GetFMUstate, |instance, _| {
            // SAFETY: room for one state (Places, 2.1.8).
            self.put_state(unsafe { place("FMUstate", state)? }, || {
                Ok(Box::new(instance.save()?))
            })
        })
    }

    /// `fmi2SetFMUstate`.
    pub fn set_state(&self, component: *mut c_void, state: *mut c_void) -> Status {
        self.enter(component, Call::SetFMUstate, |instance, _| {
            self.with_state(state, |saved| instance.restore(saved))
        })
    }

    /// `fmi2FreeFMUstate`: a NULL state is none. Also takes the state itself where FMI wants its address, as
    /// fmusim 0.0.39 hands it over: a token must not be followed.
    pub unsafe fn free_state(&self, component: *mut c_void, state: *mut *mut c_void) -> Status {
        self.enter(component, Call::FreeFMUstate, |instance, _| {
            instance.permit(Call::FreeFMUstate)?;
            if let Some(entered) = self.states.enter(state.addr()) {
                self.drop_state(entered);
                return Ok(());
            }
            // SAFETY: it is no state of ours, so the place of one (Places, 2.1.8).
            let state = unsafe { place("FMUstate", state)? };
            if !state.is_null() {
                self.drop_state(self.states.enter(state.addr()).ok_or(Error::State)?);
                *state = null_mut();
            }
            Ok(())
        })
    }

    fn drop_state(&self, entered: Entered<'_, Saved<M>>) {
        // SAFETY: made from a `Box` by `put_state`; nobody finds it any more.
        drop(unsafe { Box::from_raw(self.states.give_back(entered)) });
    }

    /// `fmi2SerializedFMUstateSize`.
    pub unsafe fn state_size(
        &self,
        component: *mut c_void,
        state: *mut c_void,
        size: *mut usize,
    ) -> Status {
        self.enter(component, Call::SerializedFMUstateSize, |instance, _| {
            instance.permit(Call::SerializedFMUstateSize)?;
            // SAFETY: room for a size (Places, 2.1.8).
            let size = unsafe { place("size", size)? };
            self.with_state(state, |saved| {
                *size = saved.to_bytes_under(self.table_hash()).len();
                Ok(())
            })
        })
    }

    /// `fmi2SerializeFMUstate`.
    pub unsafe fn serialize_state(
        &self,
        component: *mut c_void,
        state: *mut c_void,
        bytes: *mut u8,
        size: usize,
    ) -> Status {
        self.enter(component, Call::SerializeFMUstate, |instance, _| {
            instance.permit(Call::SerializeFMUstate)?;
            self.with_state(state, |saved| {
                let saved = saved.to_bytes_under(self.table_hash());
                let needed = saved.len();
                if size < needed {
                    return Err(Error::Size { size, needed });
                }
                // SAFETY: room for `size` bytes (Arrays, 2.1.8), of which no more than those of the state are touched.
                unsafe { slice_mut("serializedState", bytes, needed)? }.copy_from_slice(&saved);
                Ok(())
            })
        })
    }

    /// `fmi2DeSerializeFMUstate`.
    pub unsafe fn deserialize_state(
        &self,
        component: *mut c_void,
        bytes: *const u8,
        size: usize,
        state: *mut *mut c_void,
    ) -> Status {
        self.enter(component, Call::DeSerializeFMUstate, |instance, _| {
            instance.permit(Call::DeSerializeFMUstate)?;
            // A size that no state of this model has is refused before a byte is read.
            if !Self::can_have_size(size) {
                return Err(Error::Serialised(
                    "has another length than those of this model",
                ));
            }
            // SAFETY: `size` bytes (Arrays, 2.1.8).
            let bytes = unsafe { slice("serializedState", bytes, size)? };
            // SAFETY: room for one state (Places, 2.1.8) that does not lie among the bytes (Stillness).
            let state = unsafe { place("FMUstate", state)? };
            self.put_state(state, || {
                Saved::from_bytes_under(self.table_hash(), bytes, instance.fresh())
            })
        })
    }

    #[inline(never)] // what it takes of the stack is free again after it
    fn can_have_size(size: usize) -> bool {
        Saved::<M>::can_have_size(size)
    }

    /// What a state's token stands for.
    fn with_state(
        &self,
        state: *mut c_void,
        body: impl FnOnce(&mut Saved<M>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let entered = self.states.enter(state.addr()).ok_or(Error::State)?;
        // SAFETY: made from a `Box` by `put_state`, and `entered` keeps everybody else out.
        body(unsafe { &mut *entered.value })
    }

    /// Puts a saved state, which never lies on a small stack, behind an importer's pointer: NULL, or one of our states.
    fn put_state(
        &self,
        target: &mut *mut c_void,
        make: impl FnOnce() -> Result<Box<Saved<M>>, Error>,
    ) -> Result<(), Error> {
        if target.is_null() {
            let token = self.states.insert(make()?);
            *target = handed_out(Some(token.ok_or(Error::State)?));
            return Ok(());
        }
        self.with_state(*target, |saved| {
            *saved = *make()?;
            Ok(())
        })
    }
}
