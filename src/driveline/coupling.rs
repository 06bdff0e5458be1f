//! What is connected to what in the driveline.
//!
//! A change of it within a step (the brake lets the wheels go, say) takes other matrices from there on.
//!
//! ```
//! use dct_driveline::coupling::Coupling;
//!
//! let coming_in = Coupling { synchronising: [false, true], ..Coupling::from([1, 2]) };
//! assert_eq!(coming_in.gear_in(), [1, 0]);
//! assert_eq!(coming_in.engageable(0b11), 0b01); // clutch 2 stays open meanwhile
//! ```

use crate::Params;

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

    /// Whether both clutches engaged let nothing turn.
    pub(crate) fn ties(&self, p: &Params) -> bool {
        let [one, two] = p.g(self.gear_in());
        p.rigid && one != 0.0 && two != 0.0 && one != two
    }

    /// Another coupling in place of this one with both clutches engaged, where that ties them: they
    /// stand by that alone and carry what comes in, as if no gear jammed.
    pub(crate) fn tied(self, p: &Params) -> Option<Self> {
        let jammed = false;
        (self.jammed && self.ties(p)).then_some(Self { jammed, ..self })
    }
}
