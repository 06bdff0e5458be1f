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

#[cfg(test)]
mod tests {
    use super::Coupling;
    use crate::Params;

    #[test]
    fn rigid_shafts_in_two_gears_of_two_ratios_tie_both_clutches() {
        let mut p = Params::TABLE_1;
        let [both, one] = [[1, 2], [1, 0]].map(Coupling::from);
        assert!(!both.ties(&p), "compliant shafts give way");
        p.rigid = true;
        assert!(both.ties(&p) && !one.ties(&p));
        let jammed = Coupling {
            jammed: true,
            ..both
        };
        assert_eq!((both.tied(&p), jammed.tied(&p)), (None, Some(both)));
        let coming_in = Coupling {
            synchronising: [false, true],
            ..both
        };
        assert!(!coming_in.ties(&p), "its gear is not in yet");
        (p.i_t[1], p.i_f[1]) = (p.i_t[0], p.i_f[0]);
        assert!(!both.ties(&p), "one ratio turns as one");
    }

    #[test]
    fn a_clutch_whose_shaft_is_synchronised_cannot_be_engaged() {
        for (synchronising, engageable) in [
            ([false, false], 0b11),
            ([true, false], 0b10),
            ([false, true], 0b01),
            ([true, true], 0),
        ] {
            let coupling = Coupling {
                synchronising,
                ..Coupling::from([1, 2])
            };
            assert_eq!(coupling.engageable(0b11), engageable, "{synchronising:?}");
        }
    }
}
