//! Calls with saved states, in memory and as bytes.

use super::{Importer, see};
use crate::script::Script;
use core::ffi::c_void;
use core::ptr::null_mut;
use fmi2_cosim::{Model, Status};

impl<M: Model> Importer<M> {
    pub(super) fn with_states(&mut self, script: &mut Script<'_>) -> Status {
        let (c, library) = (self.component(script), self.library);
        let mut state = self.state(script);
        // SAFETY: an instance or something that is refused; places of our own.
        unsafe {
            match script.below(4) {
                0 => {
                    if self.states.len() < 4 {
                        state = null_mut();
                    }
                    let status = library.get_state(c, &mut state);
                    if status == Status::Ok {
                        self.states.push(state);
                    }
                    status
                }
                1 => library.set_state(c, state),
                2 => library.free_state(c, &mut state),
                _ => self.through_bytes(c, state, script),
            }
        }
    }

    /// Writes a state as bytes, damages them perhaps, and reads them back.
    fn through_bytes(
        &mut self,
        c: *mut c_void,
        state: *mut c_void,
        script: &mut Script<'_>,
    ) -> Status {
        let (library, mut size, mut copy) = (self.library, 0, null_mut());
        // SAFETY: an instance and a state, or something that is refused; bytes of that number.
        unsafe {
            let status = library.state_size(c, state, &mut size);
            if status != Status::Ok {
                return status;
            }
            let mut bytes = vec![0; size];
            assert_eq!(
                library.serialize_state(c, state, bytes.as_mut_ptr(), size),
                Status::Ok
            );
            see(&bytes);
            let damaged = script.seldom();
            if damaged {
                bytes[script.below(size)] ^= 1 << script.below(8);
            }
            let status = library.deserialize_state(c, bytes.as_ptr(), size, &mut copy);
            assert_eq!(status == Status::Ok, !damaged);
            if !damaged {
                self.states.push(copy);
            }
            status
        }
    }
}
