//! Gears: what a changed preselection does to the driveline.
//!
//! A shaft whose clutch is open may take another gear. Its synchroniser brings it to the speed of the
//! new gear at once, by one impulse that keeps momentum; what that costs is booked as
//! [`Work::synchroniser`](crate::plant::Work::synchroniser).

use nalgebra::{Matrix2, SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::plant::Plant;
use crate::plant_matrices::{C, O, SPEEDS, Systems, TWIST_T, mobility, slip_row};
use crate::plant_modes::Mode;

/// One constraint per shaft on the six speeds, shape (6, 2); a column of zeros: none.
type Constraints = SMatrix<f64, SPEEDS, 2>;

impl Plant {
    /// Gears that act when `requested` ones are preselected: a shaft keeps its gear while its clutch
    /// transmits.
    ///
    /// `present`: gears that act now, shape (2).
    pub fn gear_granted(&self, present: [i32; 2], requested: [i32; 2]) -> [i32; 2] {
        [0, 1].map(|i| {
            if self.modes[i] == Mode::Open {
                requested[i]
            } else {
                present[i]
            }
        })
    }

    /// Changes the gears that act from those of `from` to those of `to`.
    ///
    /// Only shafts with an open clutch may change: see [`Self::gear_granted`].
    pub fn change_gear(&mut self, p: &Params, from: &Systems, to: &Systems) {
        let before = from.stored_energy(&self.x);
        let (old, new) = (from.coupling, to.coupling);
        let changed = [0, 1].map(|i| old.gear[i] != new.gear[i]);
        let gear = [0, 1].map(|i| if changed[i] { 0 } else { old.gear[i] });
        self.synchronise(
            &mobility(p, Coupling { gear, ..old }),
            &self.constraints(p, to, changed),
        );
        for i in (0..2).filter(|i| changed[*i]) {
            self.x[TWIST_T + i] = 0.0;
        }
        self.hold_ratios(to);
        self.work.synchroniser += before - to.stored_energy(&self.x);
    }

    /// What holds at once: ω_ci = g_i ω_o where a gear comes in, ω_d = ω_ci where a clutch is engaged.
    fn constraints(&self, p: &Params, to: &Systems, changed: [bool; 2]) -> Constraints {
        let g = p.g(to.coupling.gear);
        let mut rows = Constraints::zeros();
        for i in [0, 1] {
            if changed[i] && g[i] != 0.0 {
                rows[(C + i, i)] = 1.0;
                rows[(O, i)] = -g[i];
            } else if self.modes[i] == Mode::Stuck {
                rows.set_column(i, &slip_row(i));
            }
        }
        rows
    }

    fn synchronise(&mut self, mobility: &SMatrix<f64, SPEEDS, SPEEDS>, rows: &Constraints) {
        let speeds: SVector<f64, SPEEDS> = self.x.fixed_rows::<SPEEDS>(0).into_owned();
        let mut coupling: Matrix2<f64> = rows.transpose() * mobility * rows;
        for i in [0, 1] {
            if coupling[(i, i)] == 0.0 {
                coupling[(i, i)] = 1.0; // no constraint, no impulse
            }
        }
        let impulse = coupling.try_inverse().unwrap_or_default() * rows.transpose() * speeds;
        let mut moved = self.x.fixed_rows_mut::<SPEEDS>(0);
        moved -= mobility * rows * impulse;
    }
}

#[cfg(test)]
mod tests {
    use super::{C, O, Plant, Systems};
    use crate::Params;
    use crate::integrate::Propagators;
    use crate::plant::{Input, InputRate};

    const TWO_ODD_GEARS: [f64; 4] = [3.0, 1.4, 0.0, 0.0];
    const DRIVE: Input = Input {
        t_e: 50.0,
        force: [3000.0, 0.0],
        gear: [1, 0],
        t_brake: 0.0,
        phi: 0.0,
    };

    fn variants() -> [Params; 2] {
        [false, true].map(|rigid| {
            let i_t = [TWO_ODD_GEARS, Params::TABLE_1.i_t[1]];
            Params {
                rigid,
                i_t,
                ..Params::TABLE_1
            }
        })
    }

    fn driven(p: &Params, input: &Input, steps: u32) -> (Plant, Propagators) {
        let mut propagators = Propagators::new(p, input.gear, 1e-3);
        let mut plant = Plant::start(p, input, 90.0, 90.0 / 18.0 * p.road.r_w);
        for _ in 0..steps {
            plant.step(p, &mut propagators, input, &InputRate::default());
        }
        (plant, propagators)
    }

    #[test]
    fn a_gear_comes_in_with_momentum_kept_and_energy_booked() {
        for p in variants() {
            let (mut plant, old) = driven(&p, &DRIVE, 500);
            let mut new = Propagators::new(&p, [1, 2], 1e-3);
            plant.change_gear(&p, &old.systems, &new.systems);
            assert!((plant.x[C + 1] - p.g([1, 2])[1] * plant.x[O]).abs() < 1e-9);
            assert!(plant.work.synchroniser > 0.0);
            assert!(plant.slip()[0].abs() < 1e-12 && (plant.x[1] - plant.x[C]).abs() < 1e-9);
            for _ in 0..500 {
                plant.step(
                    &p,
                    &mut new,
                    &Input {
                        gear: [1, 2],
                        ..DRIVE
                    },
                    &InputRate::default(),
                );
            }
            let residual = plant.energy_residual(&new.systems).abs();
            assert!(residual < 1e-9 * plant.work.engine, "{residual} J");
        }
    }

    #[test]
    fn a_shaft_changes_between_two_of_its_gears() {
        for p in variants() {
            let coast = Input {
                force: [0.0; 2],
                t_e: 0.0,
                gear: [1, 2],
                ..DRIVE
            };
            let (mut plant, old) = driven(&p, &coast, 100);
            let momentum = |plant: &Plant| p.j_ct[0] * plant.x[C] / p.g([1, 2])[0];
            let before = momentum(&plant);
            let to = Systems::new(&p, [3, 2]);
            plant.change_gear(&p, &old.systems, &to);
            assert!((plant.x[C] - p.g([3, 2])[0] * plant.x[O]).abs() < 1e-9);
            assert!(momentum(&plant) < before);
            assert!(plant.energy_residual(&to).abs() < 1e-9 * to.stored_energy(&plant.x));
        }
    }

    #[test]
    fn a_shaft_keeps_its_gear_while_its_clutch_transmits() {
        let p = Params::TABLE_1;
        let (plant, _) = driven(&p, &DRIVE, 10);
        assert_eq!(plant.gear_granted([1, 0], [3, 2]), [1, 2]);
    }

    #[test]
    fn the_same_gears_change_nothing() {
        for p in variants() {
            let (mut plant, old) = driven(&p, &DRIVE, 50);
            let before = plant;
            plant.change_gear(&p, &old.systems, &old.systems);
            assert!((plant.x - before.x).amax() < 1e-12);
            assert!(plant.work.synchroniser.abs() < 1e-9);
        }
    }
}
