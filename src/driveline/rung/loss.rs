//! The energy lost in the dampers over a rung: a quadratic form of the entries of a start, packed.
//!
//! F z needs only the rows up to each column (entries off the diagonal are doubled). Torques of clutches and most
//! ramps are zero usually, entries of the transfer shafts where those are rigid: the order of the entries puts them
//! last, in blocks of columns whose length the compiler knows.
//!
//! What a gear mesh loses grows with ω_o itself, and not with differences of speeds alone: with ω_o(0) times
//! a row that reads the torque in the mesh.

use crate::plant::matrices::{AUGMENTED, C, O, Systems, TWIST_T, W};
use crate::rung::start::{CLUTCH_RAMPS, CLUTCHES, COLUMNS, ENTRIES, Entries, SHAFTS};
use crate::rung::{add, dot};

/// First torque among the entries, then T_v' and T_e'.
const FIRST_TORQUE: usize = 4;
const LOAD_RAMP: usize = 6;
const ENGINE_RAMP: usize = 7;

/// ∫ viscous power dτ as a quadratic form: columns of its upper triangle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    states: [[f64; 4]; 4],
    torques: [[f64; 6]; 2],
    ramps: [[f64; CLUTCHES]; 2],
    clutches: [[f64; SHAFTS]; 2],
    shafts: [[f64; CLUTCH_RAMPS]; 4],
    clutch_ramps: [[f64; ENTRIES]; 2],
    /// What ω_o(0) [rad/s] times the entries loses, where meshes lose power.
    output: Entries,
    meshes_lose: bool,
}

impl Loss {
    pub(crate) const ZERO: Self = Self {
        states: [[0.0; 4]; 4],
        torques: [[0.0; 6]; 2],
        ramps: [[0.0; CLUTCHES]; 2],
        clutches: [[0.0; SHAFTS]; 2],
        shafts: [[0.0; CLUTCH_RAMPS]; 4],
        clutch_ramps: [[0.0; ENTRIES]; 2],
        output: [0.0; ENTRIES],
        meshes_lose: false,
    };

    /// The form of a symmetric matrix of z, given by its columns; it depends on speeds by their
    /// differences, and on ω_o times other entries where meshes lose power.
    pub(crate) fn pack(&mut self, form: &[[f64; AUGMENTED]; AUGMENTED], systems: &Systems) {
        fill(&mut self.states, 0, form);
        fill(&mut self.torques, FIRST_TORQUE, form);
        fill(&mut self.ramps, LOAD_RAMP, form);
        fill(&mut self.clutches, CLUTCHES, form);
        fill(&mut self.shafts, SHAFTS, form);
        fill(&mut self.clutch_ramps, CLUTCH_RAMPS, form);
        self.meshes_lose = [0, 1].map(|i| systems.viscous[(O, TWIST_T + i)]) != [0.0; 2];
        let [one, two] = systems.ratio;
        let turning = [(O, 1.0), (W, 1.0), (C, one), (C + 1, two)];
        self.output = COLUMNS.map(|j| {
            let pairs = turning.map(|(k, speed)| speed * (form[j][k] + form[k][j]));
            pairs.iter().sum()
        });
    }

    /// The loss [J] where T_e, T_c1 and T_c2 have no ramps; `rigid`: without entries of shafts; `omega_o`: output
    /// speed [rad/s].
    #[inline(always)]
    pub(crate) fn of_held(&self, z: &Entries, rigid: bool, omega_o: f64) -> f64 {
        let mut loss = if rigid {
            self.of_rigid(z)
        } else {
            self.of_compliant(z)
        };
        if self.meshes_lose {
            loss += omega_o * dot(&self.output, z);
        }
        loss
    }

    /// The loss [J]; arguments as of [`Self::of_held`].
    pub(crate) fn of(&self, z: &Entries, rigid: bool, omega_o: f64) -> f64 {
        let by_engine = z[ENGINE_RAMP] * dot(&self.ramps[1], z);
        let ramps = self.clutch_ramps.iter().zip(&z[CLUTCH_RAMPS..]);
        let by_clutches: f64 = ramps.map(|(column, ramp)| ramp * dot(column, z)).sum();
        self.of_held(z, rigid, omega_o) + by_engine + by_clutches
    }

    #[inline(never)] // a function of its own has registers for it
    fn of_rigid(&self, z: &Entries) -> f64 {
        let mut sum = [0.0; SHAFTS];
        for (sum, entry) in sum.iter_mut().zip(&self.ramps[0]) {
            *sum = entry * z[LOAD_RAMP];
        }
        self.add_core(z, &mut sum);
        dot(&sum, z)
    }

    #[inline(never)]
    fn of_compliant(&self, z: &Entries) -> f64 {
        let [first, others @ ..] = &self.shafts;
        let mut sum = first.map(|entry| entry * z[SHAFTS]);
        for (column, z) in others.iter().zip(&z[SHAFTS + 1..]) {
            add(&mut sum, column, *z);
        }
        add(&mut sum, &self.ramps[0], z[LOAD_RAMP]);
        self.add_core(z, &mut sum);
        dot(&sum, z)
    }

    /// Adds the columns before those of the shafts but for T_v'.
    #[inline(always)]
    fn add_core<const N: usize>(&self, z: &Entries, sum: &mut [f64; N]) {
        for (column, z) in self.clutches.iter().zip(&z[CLUTCHES..]) {
            if *z != 0.0 {
                add(sum, column, *z);
            }
        }
        for (column, z) in self.torques.iter().zip(&z[FIRST_TORQUE..]) {
            add(sum, column, *z);
        }
        for (column, z) in self.states.iter().zip(z) {
            add(sum, column, *z);
        }
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

#[cfg(test)]
mod tests {
    use super::Loss;
    use crate::Params;
    use crate::integrate::Propagators;
    use crate::plant::matrices::{AUGMENTED, C, D, E, O, STATES, Systems, TWIST_T, W};

    type Row = [f64; AUGMENTED];

    fn row(entries: &[(usize, f64)]) -> Row {
        let mut row = [0.0; AUGMENTED];
        entries.iter().for_each(|(at, value)| row[*at] += value);
        row
    }

    #[test]
    fn packed_it_is_the_form_that_it_was() {
        let mut systems = Systems::new(&Params::TABLE_1, [1, 2]);
        let g = systems.ratio[0];
        let torque = row(&[(TWIST_T, 900.0), (C, 2.0), (O, -2.0 * g), (STATES + 1, 3.0)]);
        let output = row(&[(O, 0.7), (STATES + 7, 0.1), (E, 0.2), (D, -0.2)]);
        let shaft = row(&[(O, 3.0), (W, -3.0), (STATES + 4, 0.5), (STATES + 3, 0.2)]);
        let mut form = [[0.0; AUGMENTED]; AUGMENTED];
        for (j, column) in form.iter_mut().enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                *entry =
                    0.5 * (torque[i] * output[j] + output[i] * torque[j]) + shaft[i] * shaft[j];
            }
        }
        systems.viscous[(O, TWIST_T)] = 1.0; // a mesh loses power
        let mut loss = Loss::ZERO;
        loss.pack(&form, &systems);
        let x = [
            200.0, 198.0, 190.0, 150.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ];
        let (v, v_dot) = ([60.0, 40.0, -25.0, 300.0], [2e3, -1e3, 5e2, 1e4]);
        let z = [&x[..], &v, &v_dot].concat();
        let read = |row: &Row| row.iter().zip(&z).map(|(a, b)| a * b).sum::<f64>();
        let wanted = read(&torque) * read(&output) + read(&shaft) * read(&shaft);
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], 1e-3);
        let start = propagators
            .rung(0, 0)
            .start(&x.into(), &v.into(), &v_dot.into());
        let found = loss.of(&start.entries, false, start.x[O]);
        assert!(
            (found - wanted).abs() < 1e-9 * wanted.abs(),
            "{found} {wanted}"
        );
    }
}
