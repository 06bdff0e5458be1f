//! The energy lost in the dampers over a rung: a quadratic form of the entries of a start, packed.
//!
//! F z needs only the rows up to each column (entries off the diagonal are doubled). Entries of the
//! transfer shafts are zero where those are rigid, torques of clutches and most ramps are zero usually: the
//! order of the entries puts them last, in blocks of columns whose length the compiler knows.

use crate::plant_matrices::AUGMENTED;
use crate::rung::{add, dot};
use crate::rung_start::{CLUTCHES, COLUMNS, ENTRIES, SHAFTS};

/// First torque among the entries, then T_v' and T_e'.
const FIRST_TORQUE: usize = 4;
const LOAD_RAMP: usize = 6;
const ENGINE_RAMP: usize = 7;

/// ∫ viscous power dτ as a quadratic form: columns of its upper triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    states: [[f64; 4]; 4],
    torques: [[f64; 6]; 2],
    ramps: [[f64; SHAFTS]; 2],
    shafts: [[f64; CLUTCHES]; 4],
    clutches: [[f64; ENTRIES]; 4],
}

impl Loss {
    pub(crate) const ZERO: Self = Self {
        states: [[0.0; 4]; 4],
        torques: [[0.0; 6]; 2],
        ramps: [[0.0; SHAFTS]; 2],
        shafts: [[0.0; CLUTCHES]; 4],
        clutches: [[0.0; ENTRIES]; 4],
    };

    /// The form of a symmetric matrix of z, given by its columns; it depends on speeds by their
    /// differences alone.
    pub(crate) fn pack(&mut self, form: &[[f64; AUGMENTED]; AUGMENTED]) {
        fill(&mut self.states, 0, form);
        fill(&mut self.torques, FIRST_TORQUE, form);
        fill(&mut self.ramps, LOAD_RAMP, form);
        fill(&mut self.shafts, SHAFTS, form);
        fill(&mut self.clutches, CLUTCHES, form);
    }

    /// The loss [J]; `rigid`: without entries of shafts.
    #[inline(never)] // a function of its own has registers for it
    pub(crate) fn of(&self, z: &[f64; ENTRIES], rigid: bool) -> f64 {
        let mut sum = [0.0; SHAFTS];
        let mut loss = 0.0;
        if !rigid {
            loss += self.of_shafts(z, &mut sum);
        }
        add(&mut sum, &self.ramps[0], z[LOAD_RAMP]);
        add(&mut sum, &self.torques[0], z[FIRST_TORQUE]);
        add(&mut sum, &self.torques[1], z[FIRST_TORQUE + 1]);
        for (column, z) in self.states.iter().zip(z) {
            add(&mut sum, column, *z);
        }
        loss += dot(&sum, z);
        let others = [z[7], z[12], z[13], z[14], z[15]].map(|entry| entry == 0.0);
        let bare = others[0] & others[1] & others[2] & others[3] & others[4];
        if bare { loss } else { loss + self.of_rest(z) }
    }

    /// What entries of shafts lose alone; `sum`: gains what they add to the columns before them.
    #[inline(always)]
    fn of_shafts(&self, z: &[f64; ENTRIES], sum: &mut [f64; SHAFTS]) -> f64 {
        let mut all = [0.0; CLUTCHES];
        for (column, z) in self.shafts.iter().zip(&z[SHAFTS..]) {
            add(&mut all, column, *z);
        }
        let (before, own) = all.split_at(SHAFTS);
        sum.copy_from_slice(before);
        dot(own, &z[SHAFTS..])
    }

    fn of_rest(&self, z: &[f64; ENTRIES]) -> f64 {
        let mut sum = z[ENGINE_RAMP] * dot(&self.ramps[1], z);
        for (column, entry) in self.clutches.iter().zip(&z[CLUTCHES..]) {
            if *entry != 0.0 {
                sum += entry * dot(column, z);
            }
        }
        sum
    }
}

/// Columns from `first` on, down to the diagonal.
fn fill<const N: usize, const M: usize>(
    columns: &mut [[f64; N]; M],
    first: usize,
    form: &[[f64; AUGMENTED]; AUGMENTED],
) {
    for (column, j) in columns.iter_mut().zip(first..) {
        let entry = |i: usize| match form[COLUMNS[i]][COLUMNS[j]] {
            _ if i > j => 0.0,
            on if i == j => on,
            off => off + form[COLUMNS[j]][COLUMNS[i]],
        };
        *column = core::array::from_fn(entry);
    }
}
