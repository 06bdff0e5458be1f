//! The energy lost in the dampers over a rung: a quadratic form of z, packed for the usual case.
//!
//! Usually of the eight torques and ramps only T_e, T_v and T_v' are not zero. With those and the states
//! as the core, F z needs only the rows up to each column (entries off the diagonal are doubled); the
//! columns of a core come in blocks whose length the compiler knows.

use crate::plant_matrices::AUGMENTED;
use crate::rung::{Augmented, add, dot};

/// Entries of z in the order of the form: states, T_e, T_v, T_v', then what is usually zero.
const ORDER: [usize; AUGMENTED] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 13, 17, 11, 12, 14, 15, 16];
/// States, T_e, T_v, T_v'.
const CORE: usize = 13;
/// Entries of the columns behind the core, each down to the diagonal.
const REST: usize = AUGMENTED * (AUGMENTED + 1) / 2 - CORE * (CORE + 1) / 2;

/// ∫ viscous power dτ as a quadratic form: columns of its upper triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    first: [[f64; 4]; 4],
    second: [[f64; 8]; 4],
    third: [[f64; 10]; 2],
    torques: [[f64; 12]; 2],
    load_ramp: [f64; CORE],
    rest: [f64; REST],
}

impl Loss {
    pub(crate) const ZERO: Self = Self {
        first: [[0.0; 4]; 4],
        second: [[0.0; 8]; 4],
        third: [[0.0; 10]; 2],
        torques: [[0.0; 12]; 2],
        load_ramp: [0.0; CORE],
        rest: [0.0; REST],
    };

    /// The form of a symmetric matrix, given by its columns.
    pub(crate) fn pack(&mut self, form: &[[f64; AUGMENTED]; AUGMENTED]) {
        let entry = |i: usize, j: usize| match (form[ORDER[i]][ORDER[j]], i) {
            (_, i) if i > j => 0.0,
            (on, i) if i == j => on,
            (off, _) => off + form[ORDER[j]][ORDER[i]],
        };
        let fill = |column: &mut [f64], j: usize| {
            column
                .iter_mut()
                .enumerate()
                .for_each(|(i, to)| *to = entry(i, j));
        };
        let first = self.first.iter_mut().map(|column| &mut column[..]);
        let second = self.second.iter_mut().map(|column| &mut column[..]);
        let third = self.third.iter_mut().map(|column| &mut column[..]);
        let torques = self.torques.iter_mut().map(|column| &mut column[..]);
        let core = first.chain(second).chain(third).chain(torques);
        core.chain([&mut self.load_ramp[..]])
            .enumerate()
            .for_each(|(j, column)| fill(column, j));
        let mut rest = &mut self.rest[..];
        for j in CORE..AUGMENTED {
            let (column, next) = rest.split_at_mut(j + 1);
            fill(column, j);
            rest = next;
        }
    }

    /// The loss from z [J].
    #[inline(always)]
    pub(crate) fn of(&self, z: &Augmented) -> f64 {
        let z = &z.data.0[0];
        let mut sum = [0.0; 12];
        let (engine, load, load_ramp) = (z[ORDER[10]], z[ORDER[11]], z[ORDER[12]]);
        add(&mut sum, &self.torques[0], engine);
        add(&mut sum, &self.torques[1], load);
        for (column, z) in self.third.iter().zip(&z[8..]) {
            add(&mut sum, column, *z);
        }
        for (column, z) in self.second.iter().zip(&z[4..]) {
            add(&mut sum, column, *z);
        }
        for (column, z) in self.first.iter().zip(z) {
            add(&mut sum, column, *z);
        }
        let [states @ .., by_engine, by_load] = &sum;
        let [ramp_states @ .., ramp_engine, ramp_load, ramp_itself] = &self.load_ramp;
        let by_ramp = dot(ramp_states, z)
            + (ramp_engine * engine + ramp_load * load + ramp_itself * load_ramp);
        let core = dot(states, z) + (by_engine * engine + by_load * load) + by_ramp * load_ramp;
        let others = [z[11], z[12], z[14], z[15], z[16]].map(|entry| entry == 0.0);
        let bare = others[0] & others[1] & others[2] & others[3] & others[4];
        if bare { core } else { core + self.of_rest(z) }
    }

    fn of_rest(&self, z: &[f64; AUGMENTED]) -> f64 {
        let z = ORDER.map(|index| z[index]);
        let (mut sum, mut rest) = (0.0, &self.rest[..]);
        for (j, entry) in z.iter().enumerate().skip(CORE) {
            let (column, next) = rest.split_at(j + 1);
            rest = next;
            if *entry != 0.0 {
                sum += entry * dot(column, &z);
            }
        }
        sum
    }
}
