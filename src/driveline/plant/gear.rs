//! Gears: what a changed preselection does to the driveline.
//!
//! A shaft whose clutch is open may take another gear. The old one goes out, which cuts the shaft from the
//! output; a synchroniser then rubs between the input shaft and the new gear with a Coulomb torque
//! of constant size until both turn alike, and then the gear is in:
//!
//! ```text
//! J_ct ω̇_c = −σ T_s,   J_o ω̇_o = … + σ g T_s,   σ = sgn(ω_c − g ω_o)      until ω_c = g ω_o
//! ```
//!
//! That instant is located like the events of a clutch, so T_s acts for up to a tick too long: its impulse of
//! that time is taken back. What is left is of second order in the tick. T_s |ω_c − g ω_o| is booked as
//! [`Work::synchroniser`](crate::plant::Work::synchroniser), with the elastic energy let go by a gear that goes
//! out. A clutch that is pressed meanwhile turns the shaft against the synchroniser, which lets go: the
//! shaft is in neutral, and is synchronised anew when the clutch is open again.
//!
//! The wheels of a gear may add to J_ct while it is in. They turn with the output before and after, so they
//! come and go with the speed and the energy that they have.
//!
//! Deviation: the paper changes no gears. See PAPER.md.

use nalgebra::{Matrix2, SMatrix, SVector};

use crate::Params;
use crate::coupling::Coupling;
use crate::matrices::mobility::{Mobility, mobility};
use crate::matrices::springs::stored_energy;
use crate::matrices::state::{slip_row, synchroniser_row};
use crate::matrices::{C, O, SPEEDS, State, TWIST_T, Torques, rigid_ratio};
use crate::plant::Plant;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Guard, Mode, ZERO_SLIP};
use crate::plant::ports::{Input, InputRate};

/// One constraint per shaft on the six speeds, shape (6, 2); a column of zeros: none.
type Constraints = SMatrix<f64, SPEEDS, 2>;

impl Plant {
    /// Gears that a step with these inputs has: a shaft keeps its gear while its clutch is pressed, and
    /// is in neutral if the gear was not in yet.
    ///
    /// `rate`: derivatives of the inputs. Returns what acts or is synchronised, shape (2).
    pub fn gear_granted(&self, input: &Input, rate: &InputRate) -> [i32; 2] {
        [0, 1].map(|i| {
            let pressed = input.force[i] > 0.0 || rate.force[i] > 0.0;
            if !pressed {
                input.gear[i]
            } else if self.synchroniser[i] == Mode::Open {
                self.gear[i]
            } else {
                0
            }
        })
    }

    /// Modes of clutch 1, clutch 2, brake, synchroniser 1, synchroniser 2 and of the output in meshes that
    /// lose power, shape (6).
    pub fn all_modes(&self) -> [Mode; 6] {
        let ([one, two], [three, four]) = (self.modes, self.synchroniser);
        [one, two, self.brake, three, four, self.meshes.output]
    }

    /// Gears that are in, shape (2); 0 in neutral and while a synchroniser rubs.
    pub fn gear_in(&self) -> [i32; 2] {
        self.coupling().gear_in()
    }

    /// What is connected to what.
    #[inline(always)]
    pub fn coupling(&self) -> Coupling {
        let plain = self.synchroniser == [Mode::Open; 2] && self.meshes == Meshes::IDEAL;
        if plain && self.brake == Mode::Open {
            return self.gear.into(); // the usual, without any question more
        }
        Coupling {
            gear: self.gear,
            synchronising: self.synchroniser.map(|mode| mode != Mode::Open),
            held: self.brake == Mode::Stuck,
            power: self.meshes.power(),
            jammed: self.meshes.output == Mode::Stuck,
        }
    }

    /// Starts to change gears at the start of a step.
    pub(crate) fn change_gears(&mut self, p: &Params, input: &Input, rate: &InputRate) {
        let granted = self.gear_granted(input, rate);
        if granted != self.gear {
            self.take_out(p, granted);
        }
    }

    /// Takes gears out and starts to synchronise their shafts to `gear`.
    #[cold]
    #[inline(never)]
    fn take_out(&mut self, p: &Params, gear: [i32; 2]) {
        let (before, g) = (self.energies(p), p.g(gear));
        let changed = [0, 1].map(|i| gear[i] != self.gear[i]);
        for i in (0..2).filter(|i| changed[*i]) {
            (self.gear[i], self.modes[i]) = (gear[i], Mode::Open);
            self.x[TWIST_T + i] = 0.0;
            let difference = self.x[C + i] - g[i] * self.x[O];
            self.synchroniser[i] = if g[i] == 0.0 {
                Mode::Open
            } else {
                Mode::slipping(difference)
            };
        }
        self.book_change(p, before);
        let turns_alike = |i: usize| (self.x[C + i] - g[i] * self.x[O]).abs() <= ZERO_SLIP;
        let alike = [0, 1].map(|i| changed[i] && g[i] != 0.0 && turns_alike(i));
        if alike != [false; 2] {
            self.put_in(p, alike, [0.0; 2]);
        }
    }

    /// Puts in the gears of shafts that turned like them `since` [s] ago, shape (2).
    #[cold]
    #[inline(never)]
    pub(crate) fn put_in(&mut self, p: &Params, synchronised: [bool; 2], since: [f64; 2]) {
        let (before, mobility) = (self.energies(p), mobility(p, self.coupling()));
        if p.rigid {
            self.pull_together(&mobility, &self.constraints(p, synchronised));
        } else {
            self.take_back(p, &mobility, since);
        }
        for i in (0..2).filter(|i| synchronised[*i]) {
            self.synchroniser[i] = Mode::Open;
        }
        self.hold_ratios(rigid_ratio(p, self.coupling()));
        self.book_change(p, before);
    }

    /// Stored energy, and that of the wheels of gears that are in [J].
    fn energies(&self, p: &Params) -> [f64; 2] {
        let gear = self.gear_in();
        let of = |i: usize| 0.5 * p.gear_inertia(i, gear[i]) * self.x[C + i] * self.x[C + i];
        [stored_energy(p, self.coupling(), &self.x), of(0) + of(1)]
    }

    /// Books what a change cost; wheels come and go with the energy that they have.
    fn book_change(&mut self, p: &Params, [stored, wheels]: [f64; 2]) {
        let [stored_now, wheels_now] = self.energies(p);
        let brought = wheels_now - wheels;
        self.stored_at_start += brought;
        self.work.synchroniser += stored + brought - stored_now;
    }

    /// What holds at once: ω_ci = g_i ω_o where a gear comes in, ω_d = ω_ci where a clutch is engaged.
    fn constraints(&self, p: &Params, synchronised: [bool; 2]) -> Constraints {
        let g = p.g(self.gear);
        let mut rows = Constraints::zeros();
        for i in [0, 1] {
            if synchronised[i] {
                rows.set_column(i, &synchroniser_row(i, g[i]));
            } else if self.modes[i] == Mode::Stuck {
                rows.set_column(i, &slip_row(i));
            }
        }
        rows
    }

    /// Removes by impulses, which keep momentum, the speeds that the constraints of rigid shafts do not allow.
    fn pull_together(&mut self, mobility: &Mobility, rows: &Constraints) {
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

    /// Speed difference that is left to the synchroniser of a shaft, > 0 until it is done, and its rate.
    ///
    /// `g`: total ratio of the gear that comes in [1]. `x_dot`: rate of the state `x`.
    pub(crate) fn synchroniser_guard(&self, i: usize, g: f64, x: &State, x_dot: &State) -> Guard {
        let left = |x: &State| self.synchroniser[i].direction() * (x[C + i] - g * x[O]);
        Guard {
            value: left(x),
            rate: left(x_dot),
        }
    }

    /// σ T_s of both shafts [N·m], shape (2); 0 where nothing is synchronised.
    pub(crate) fn synchroniser_torque(&self, p: &Params) -> [f64; 2] {
        [0, 1].map(|i| self.synchroniser[i].direction() * p.t_s[i])
    }

    /// Power lost in the synchronisers [W].
    pub(crate) fn synchroniser_power(&self, p: &Params) -> f64 {
        let (g, torque) = (p.g(self.gear), self.synchroniser_torque(p));
        let power = |i: usize| torque[i] * (self.x[C + i] - g[i] * self.x[O]);
        power(0) + power(1)
    }

    /// Adds the torques of synchronisers to those of open clutches, whose place they take.
    pub(crate) fn with_synchronisers(&self, p: &Params, mut v: Torques) -> Torques {
        let [one, two] = self.synchroniser_torque(p);
        v[1] += one;
        v[2] += two;
        v
    }

    /// Keeps ω_ci = g_i ω_o of rigid transfer shafts exact.
    pub(crate) fn hold_ratios(&mut self, rigid_ratio: [f64; 2]) {
        for (i, ratio) in rigid_ratio.into_iter().enumerate() {
            if ratio != 0.0 {
                self.x[C + i] = ratio * self.x[O];
            }
        }
    }
}
