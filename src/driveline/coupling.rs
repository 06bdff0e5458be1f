//! What is connected to what in the driveline, and where its propagators come from.
//!
//! A change of it within a step (the brake lets the wheels go, say) takes other matrices from there on.
//!
//! ```
//! use dct_driveline::coupling::{Coupling, Ladders};
//! use dct_driveline::{Params, integrate::Propagators};
//!
//! let p = Params::TABLE_1;
//! let mut ladders = Propagators::new(&p, [1, 2], 1e-3);
//! let held = Coupling { held: true, ..Coupling::from([1, 2]) };
//! assert!(ladders.of(&p, held).fits(held, 1e-3));
//! ```

use crate::Params;
use crate::integrate::Propagators;

/// What is connected to what, clutches aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Coupling {
    /// Gears that are in, or that shafts are being synchronised to, shape (2); 0 is neutral.
    pub gear: [i32; 2],
    /// A shaft's gear is not in yet: its synchroniser rubs, and its clutch is open, shape (2).
    pub synchronising: [bool; 2],
    /// The brake holds the wheels: ω_w stays as it is.
    pub held: bool,
    /// s of shafts whose gear loses power, shape (2): 1 drives the output, −1 is driven by it; otherwise 0.
    pub power: [i8; 2],
    /// The meshes of gears that lose power jam: ω_o stays as it is.
    pub jammed: bool,
}

impl From<[i32; 2]> for Coupling {
    fn from(gear: [i32; 2]) -> Self {
        Self {
            gear,
            synchronising: [false; 2],
            held: false,
            power: [0; 2],
            jammed: false,
        }
    }
}

impl Coupling {
    /// Gears that connect a shaft with the output, shape (2); 0: none does.
    pub fn gear_in(&self) -> [i32; 2] {
        [0, 1].map(|i| {
            if self.synchronising[i] {
                0
            } else {
                self.gear[i]
            }
        })
    }

    /// Those of `set` (bit i: clutch i) that may be engaged: not while their shafts are synchronised.
    pub fn engageable(&self, set: usize) -> usize {
        let [one, two] = self.synchronising.map(usize::from);
        set & !(one | two << 1)
    }
}

/// Where a plant finds the propagators of a communication step; its coupling may change within it.
pub trait Ladders {
    /// The propagators of the step with this coupling.
    fn of(&mut self, p: &Params, coupling: Coupling) -> &Propagators;

    /// [`Self::of`] where gears are all that is connected.
    #[inline(always)]
    fn of_gears(&mut self, p: &Params, gear: [i32; 2]) -> &Propagators {
        self.of(p, gear.into())
    }
}

impl Ladders for Propagators {
    fn of(&mut self, p: &Params, coupling: Coupling) -> &Propagators {
        if self.systems.coupling != coupling {
            self.rebuild(p, coupling, self.h);
        }
        self
    }
}
