//! The different parameters that the plants of a library have, and copies kept ready for those who touch theirs.

use dct_driveline::Params;
use std::sync::Arc;

/// Copies that are kept ready.
const SPARE: usize = 4;

/// The parameters of all plants of a library.
pub(super) struct Sets {
    known: Vec<Arc<Params>>,
    /// Copies of nobody.
    spare: Vec<Arc<Params>>,
}

impl Sets {
    pub(super) const EMPTY: Self = Self {
        known: Vec::new(),
        spare: Vec::new(),
    };

    /// A copy that nobody else has.
    pub(super) fn fresh(&mut self, params: &Params) -> Arc<Params> {
        let Some(mut spare) = self.spare.pop() else {
            return Arc::new(*params);
        };
        *Arc::make_mut(&mut spare) = *params;
        spare
    }

    /// Makes parameters the same as equal ones of another plant, and copies ready; not for the middle of a run:
    /// it allocates. None: those of Table 1, which nobody holds.
    pub(super) fn share(&mut self, own: Option<&mut Arc<Params>>) {
        if let Some(own) = own {
            self.known.retain(|known| Arc::strong_count(known) > 1);
            let equal = |known: &&Arc<Params>| Arc::ptr_eq(known, own) || ***known == **own;
            match self.known.iter().find(equal) {
                Some(known) => {
                    let other = std::mem::replace(own, Arc::clone(known));
                    if Arc::strong_count(&other) == 1 {
                        self.spare.push(other);
                    }
                }
                None => self.known.push(Arc::clone(own)),
            }
        }
        self.spare.truncate(SPARE);
        while self.spare.len() < SPARE {
            self.spare.push(Arc::new(Params::TABLE_1));
        }
    }
}
