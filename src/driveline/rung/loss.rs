//! The energy lost in the dampers over a rung: a quadratic form of the entries of a start, packed.
//!
//! F z needs only the rows up to each column (entries off the diagonal are doubled). Torques of clutches and most
//! ramps are zero usually, entries of the transfer shafts where those are rigid: the order of the entries puts them
//! last, in blocks of columns whose length the compiler knows.
//!
//! What a gear mesh loses grows with ω_o itself, and not with differences of speeds alone: with ω_o(0) times
//! a row that reads the torque in the mesh.

use crate::rung::lanes::{Lanes, add, dot};
use crate::rung::start::{BUILT, CLUTCH_RAMPS, CLUTCHES, ENTRIES, Entries, SHAFTS};
use crate::rung::start::{COMPLIANT, RIGID};

/// First difference of speeds, first torque among the entries, then T_v' and T_e'.
const FIRST_SPEED: usize = 2;
const FIRST_TORQUE: usize = 4;
const LOAD_RAMP: usize = 6;
const ENGINE_RAMP: usize = 7;

/// A symmetric matrix of what moves, as it is built.
type Form = [Lanes<ENTRIES>; ENTRIES];

/// ∫ viscous power dτ as a quadratic form: columns of its upper triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    twists: [Lanes<2>; 2],
    speeds: [Lanes<4>; 2],
    torques: [Lanes<6>; 2],
    ramps: [Lanes<CLUTCHES>; 2],
    clutches: [Lanes<SHAFTS>; 2],
    shafts: [Lanes<CLUTCH_RAMPS>; 4],
    clutch_ramps: [Lanes<ENTRIES>; 2],
    /// What ω_o(0) [rad/s] times the entries loses, where meshes lose power.
    output: Entries,
    meshes_lose: bool,
}

impl Loss {
    pub(crate) const ZERO: Self = Self {
        twists: [Lanes::ZERO; 2],
        speeds: [Lanes::ZERO; 2],
        torques: [Lanes::ZERO; 2],
        ramps: [Lanes::ZERO; 2],
        clutches: [Lanes::ZERO; 2],
        shafts: [Lanes::ZERO; 4],
        clutch_ramps: [Lanes::ZERO; 2],
        output: Lanes::ZERO,
        meshes_lose: false,
    };

    /// The form of a symmetric matrix of what moves; `output`: what ω_o times that loses besides, where
    /// meshes lose power.
    pub(crate) fn pack(&mut self, form: &Form, output: &Entries) {
        fill(&mut self.twists, 0, form);
        fill(&mut self.speeds, FIRST_SPEED, form);
        fill(&mut self.torques, FIRST_TORQUE, form);
        fill(&mut self.ramps, LOAD_RAMP, form);
        fill(&mut self.clutches, CLUTCHES, form);
        fill(&mut self.shafts, SHAFTS, form);
        fill(&mut self.clutch_ramps, CLUTCH_RAMPS, form);
        self.output = Lanes(BUILT.map(|j| output[j]));
        self.meshes_lose = output.0 != [0.0; ENTRIES];
    }

    /// The loss [J] where T_e, T_c1 and T_c2 have no ramps.
    ///
    /// `z`: first entries of a start. `sliding`: T_c1 or T_c2 is not zero. `omega_o`: output speed [rad/s].
    #[inline(always)]
    pub(crate) fn of_held<const N: usize>(&self, z: &Lanes<N>, sliding: bool, omega_o: f64) -> f64 {
        let mut sum = Lanes([-0.0; N]); // what a first sum leaves as it is
        add(&mut sum, &self.ramps[0], z[LOAD_RAMP]);
        for (column, z) in self.torques.iter().zip(&z[FIRST_TORQUE..]) {
            add(&mut sum, column, *z);
        }
        for (column, z) in self.speeds.iter().zip(&z[FIRST_SPEED..]) {
            add(&mut sum, column, *z);
        }
        for (column, z) in self.twists.iter().zip(&z.0) {
            add(&mut sum, column, *z);
        }
        if N == COMPLIANT {
            for (column, z) in self.shafts.iter().zip(&z[SHAFTS..]) {
                add(&mut sum, column, *z);
            }
        }
        if sliding {
            for (column, z) in self.clutches.iter().zip(&z[CLUTCHES..SHAFTS]) {
                if *z != 0.0 {
                    add(&mut sum, column, *z);
                }
            }
        }
        let loss = if N == COMPLIANT || sliding {
            dot(&sum, z)
        } else {
            dot(&sum.first::<CLUTCHES>(), &z.first::<CLUTCHES>())
        };
        if self.meshes_lose {
            return loss + omega_o * dot(&self.output, z);
        }
        loss
    }

    /// The loss [J]; `rigid`: without entries of shafts, `omega_o`: output speed [rad/s].
    pub(crate) fn of(&self, z: &Entries, rigid: bool, omega_o: f64) -> f64 {
        let by_engine = z[ENGINE_RAMP] * dot(&self.ramps[1], z);
        let ramps = self.clutch_ramps.iter().zip(&z[CLUTCH_RAMPS..]);
        let by_clutches: f64 = ramps.map(|(column, ramp)| ramp * dot(column, z)).sum();
        let ramps = self.output[CLUTCH_RAMPS..].iter().zip(&z[CLUTCH_RAMPS..]);
        let by_output: f64 = ramps.map(|(entry, ramp)| entry * ramp).sum();
        let held = if rigid {
            self.of_held::<RIGID>(&z.first(), true, omega_o)
        } else {
            self.of_held::<COMPLIANT>(&z.first(), true, omega_o)
        };
        held + by_engine + by_clutches + omega_o * by_output
    }
}

/// Columns from `first` on, down to the diagonal.
fn fill<const N: usize, const M: usize>(columns: &mut [Lanes<N>; M], first: usize, form: &Form) {
    for (column, j) in columns.iter_mut().zip(first..) {
        let entry = |i: usize| match form[BUILT[i]][BUILT[j]] {
            _ if i > j => 0.0,
            on if i == j => on,
            off => off + form[BUILT[j]][BUILT[i]],
        };
        *column = Lanes(core::array::from_fn(entry));
    }
}

#[cfg(test)]
mod tests {
    use super::{BUILT, ENTRIES, Form, Lanes, Loss};
    use crate::Params;
    use crate::integrate::Propagators;

    /// A symmetric form and a row without a pattern.
    fn form_and_row() -> (Form, Lanes<ENTRIES>) {
        let number =
            |i: usize, j: usize| f64::from(u8::try_from((7 * i * j + i + j) % 11).unwrap());
        let form = core::array::from_fn(|j| Lanes(core::array::from_fn(|i| number(i, j) - 4.0)));
        (form, Lanes(core::array::from_fn(|j| number(j, 3) - 6.0)))
    }

    #[test]
    fn packed_it_is_the_form_that_it_was() {
        let (form, output) = form_and_row();
        let mut loss = Loss::ZERO;
        loss.pack(&form, &output);
        let x = [
            200.0, 198.0, 190.0, 150.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ];
        let (v, v_dot) = ([60.0, 40.0, -25.0, 300.0], [2e3, -1e3, 5e2, 1e4]);
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], 1e-3);
        let rung = propagators.rung(0, 0);
        let start = rung.start(&x.into(), &v.into(), &v_dot.into());
        let mut moves = [0.0; ENTRIES];
        for (column, entry) in BUILT.into_iter().zip(start.entries.0) {
            moves[column] = entry;
        }
        let read = |row: &Lanes<ENTRIES>| row.iter().zip(moves).map(|(a, b)| a * b).sum::<f64>();
        let of_form: f64 = form.iter().zip(moves).map(|(row, z)| z * read(row)).sum();
        let wanted = of_form + start.x[4] * read(&output);
        let found = loss.of(&start.entries, false, start.x[4]);
        assert!(
            (found - wanted).abs() < 1e-9 * wanted.abs(),
            "{found} {wanted}"
        );
    }
}
