//! FMU states in random sequences: live ones, freed ones, ones that never were, damaged bytes.

use super::sequences::{PROBE, Rig};
use super::*;

impl Rig {
    /// Frees everything.
    pub(super) fn end(mut self) {
        for (mut state, _) in core::mem::take(&mut self.saved) {
            // SAFETY: a live component and state.
            let status = unsafe { PROBE.free_state(self.c, &mut state) };
            assert_eq!(status, Status::Ok);
        }
        // SAFETY: a live component.
        unsafe { PROBE.free_instance(self.c) };
    }

    /// A call that concerns FMU states.
    pub(super) fn states(&mut self, call: Call) -> (Status, Status) {
        match call {
            Call::GetFMUstate => self.get_state(),
            Call::SetFMUstate => self.set_state(),
            Call::FreeFMUstate => self.free_state(),
            Call::SerializedFMUstateSize => self.state_size(),
            Call::SerializeFMUstate => self.serialize(),
            Call::DeSerializeFMUstate => self.deserialize(),
            other => panic!("{other} is not tested"),
        }
    }

    /// Index of a live state, mostly; else a token that is none.
    fn token(&mut self) -> (*mut c_void, Option<usize>) {
        let nothing = [null_mut(), self.c, self.freed, without_provenance_mut(64)];
        if self.saved.is_empty() || self.random.seldom() {
            return (self.random.pick(&nothing), None);
        }
        let index = self.random.below(self.saved.len());
        (self.saved[index].0, Some(index))
    }

    fn get_state(&mut self) -> (Status, Status) {
        let (mut token, index) = self.token();
        let fresh = token.is_null() || (self.saved.len() < 4 && self.random.below(2) == 0);
        if fresh {
            token = null_mut();
        }
        // SAFETY: a live component; a place of our own.
        let got = unsafe { PROBE.get_state(self.c, &mut token) };
        match index {
            _ if fresh => self.saved.push((token, self.shadow.clone())),
            Some(index) => self.saved[index].1 = self.shadow.clone(),
            None => return (got, Status::Error),
        }
        (got, Status::Ok)
    }

    fn set_state(&mut self) -> (Status, Status) {
        let (token, index) = self.token();
        let got = PROBE.set_state(self.c, token);
        let Some(index) = index else {
            return (got, Status::Error);
        };
        self.shadow = self.saved[index].1.clone();
        (got, Status::Ok)
    }

    fn free_state(&mut self) -> (Status, Status) {
        let (mut token, index) = self.token();
        let (kept, was_null) = (token, token.is_null());
        // SAFETY: a live component; a place of our own.
        let got = unsafe { PROBE.free_state(self.c, &mut token) };
        if let Some(index) = index {
            assert!(token.is_null());
            self.freed = kept;
            self.saved.swap_remove(index);
        }
        let legal = index.is_some() || was_null;
        (got, if legal { Status::Ok } else { Status::Error })
    }

    fn state_size(&mut self) -> (Status, Status) {
        let ((token, index), mut size) = (self.token(), 7);
        // SAFETY: a live component; a number of our own.
        let got = unsafe { PROBE.state_size(self.c, token, &mut size) };
        let wanted = if index.is_some() {
            self.bytes().len()
        } else {
            7
        };
        assert_eq!(size, wanted);
        (got, found(index.is_some()))
    }

    fn serialize(&mut self) -> (Status, Status) {
        let (token, index) = self.token();
        let size = self.bytes().len();
        let room = self.random.pick(&[size, size, size + 9, size - 1, 0]);
        let mut bytes = vec![0xab; room];
        // SAFETY: a live component; bytes of that number.
        let got = unsafe { PROBE.serialize_state(self.c, token, bytes.as_mut_ptr(), room) };
        assert!(bytes.iter().skip(size).all(|byte| *byte == 0xab));
        (got, found(index.is_some() && room >= size))
    }

    fn deserialize(&mut self) -> (Status, Status) {
        let mut bytes = self.bytes();
        let flipped = self.random.below(2) == 0;
        if flipped {
            let at = self.random.below(bytes.len());
            bytes[at] ^= 1 << self.random.below(8);
        }
        let size = bytes.len();
        let said = if self.random.seldom() {
            self.random.pick(&[0, size - 1, usize::MAX])
        } else {
            size
        };
        let mut token = null_mut();
        // SAFETY: a live component; at most as many bytes as said, or a size that no one believes.
        let got = unsafe { PROBE.deserialize_state(self.c, bytes.as_ptr(), said, &mut token) };
        let legal = !flipped && said == size;
        assert_eq!(token.is_null(), !legal);
        if legal {
            self.saved.push((token, self.shadow.clone()));
        }
        (got, found(legal))
    }
}

fn found(legal: bool) -> Status {
    if legal { Status::Ok } else { Status::Error }
}
