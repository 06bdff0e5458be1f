//! How a rung is built: by series over a span that is short for the fastest eigenvalue (`rung/series.rs`), then by
//! doubling.
//!
//! What moves the driveline is eight numbers of its state, the twists and the differences of speeds, with four
//! torques and their ramps: a column each. A column holds the change of the state, and of the speeds that torques
//! work on the integrals of the change. Half of twice the span begins with the numbers z + e(z) + t z', where
//! e are the changes of the eight by the first half, so that the columns are Ψ = I + e + t applied to themselves.

use crate::matrices::{O, System, Systems, TORQUES};
use crate::rung::lanes::{Lanes, add, dot};
use crate::rung::motion::{ANGLE, MOMENT, ROWS};
use crate::rung::start::{CORE_STATES, ENTRIES, MOVING, moving, worked};

/// First torque and first ramp among the columns.
pub(crate) const TORQUE_COLUMN: usize = MOVING;
pub(crate) const RAMP_COLUMN: usize = TORQUE_COLUMN + TORQUES;

/// A rung while it is built: its columns, and the losses as a full matrix.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Builder {
    pub(crate) t: f64,
    /// By what moves: rows of the state, angles, moments.
    pub(crate) columns: [Lanes<ROWS>; ENTRIES],
    /// Losses as a symmetric form of what moves.
    pub(crate) loss: [Lanes<ENTRIES>; ENTRIES],
    /// What ω_o at the start loses times what moves, where gear meshes lose power.
    pub(crate) output: Lanes<ENTRIES>,
}

/// Columns that are not zero.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Active {
    columns: [usize; ENTRIES],
    count: usize,
    /// Shafts move by themselves.
    shafts: bool,
}

impl Active {
    /// With the clutches of `set` engaged, whose torques do not count.
    pub(crate) fn new(system: &System, set: usize) -> Self {
        let shafts = (CORE_STATES..MOVING).any(|j| *system.column(j) != [0.0; _]);
        let mut active = Self {
            columns: [0; ENTRIES],
            count: 0,
            shafts,
        };
        let engaged = |j: usize| {
            let q = j.saturating_sub(TORQUE_COLUMN) % TORQUES;
            j >= TORQUE_COLUMN && (q == 1 && set & 1 == 1 || q == 2 && set & 2 == 2)
        };
        for j in (0..ENTRIES).filter(|j| !engaged(*j)) {
            if shafts || !(CORE_STATES..MOVING).contains(&j) {
                active.columns[active.count] = j;
                active.count += 1;
            }
        }
        active
    }

    pub(crate) fn columns(&self) -> &[usize] {
        &self.columns[..self.count]
    }
}

impl Builder {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        columns: [Lanes::ZERO; ENTRIES],
        loss: [Lanes::ZERO; ENTRIES],
        output: Lanes::ZERO,
    };

    /// Becomes a rung of twice the span of `half`; `active`: columns that are not zero, in both.
    pub(crate) fn double(&mut self, half: &Self, systems: &Systems, active: &Active) {
        if active.shafts {
            self.double_by::<MOVING>(half, systems, active.columns());
        } else {
            self.double_by::<CORE_STATES>(half, systems, active.columns());
        }
    }

    /// The same with the first `K` numbers of the state, beside which no one moves.
    fn double_by<const K: usize>(&mut self, half: &Self, systems: &Systems, active: &[usize]) {
        let mut changes = [Lanes::<K>::ZERO; ENTRIES];
        for (at, &j) in active.iter().enumerate() {
            let change = moving(&half.columns[j], systems.ratio).first();
            changes[j] = change;
            self.columns[j] = half.doubled_column(systems, j, &change);
            let through = half.loss_through(j, &change);
            for &i in &active[..=at] {
                let loss = half.doubled_loss(i, j, &changes[i], &through);
                (self.loss[j][i], self.loss[i][j]) = (loss, loss);
            }
        }
        if systems.meshes_lose() {
            self.double_mesh_loss(half, &changes);
        }
        self.t = 2.0 * half.t;
    }

    /// Column j over twice the span.
    #[inline(always)]
    fn doubled_column<const K: usize>(
        &self,
        systems: &Systems,
        j: usize,
        change: &Lanes<K>,
    ) -> Lanes<ROWS> {
        let (column, t) = (self.columns[j], self.t);
        let mut second = column;
        through(&mut second, &self.columns, change);
        if j >= RAMP_COLUMN {
            add(&mut second, &self.columns[j - TORQUES], t);
        }
        let gained = worked(&column, systems.synchroniser_ratio);
        for q in 0..TORQUES {
            let angle = second[ANGLE + q] + t * gained[q];
            second[ANGLE + q] = angle;
            second[MOMENT + q] += t * (angle + 0.5 * t * gained[q]);
        }
        add(&mut second, &column, 1.0);
        second
    }

    /// Column j of F Ψ.
    #[inline(always)]
    fn loss_through<const K: usize>(&self, j: usize, change: &Lanes<K>) -> Lanes<ENTRIES> {
        let mut half = self.loss[j];
        through(&mut half, &self.loss, change);
        if j >= RAMP_COLUMN {
            add(&mut half, &self.loss[j - TORQUES], self.t);
        }
        half
    }

    /// Row i of column j of F + Ψᵀ F Ψ; `change`: e of column i, `through`: column j of F Ψ.
    #[inline(always)]
    fn doubled_loss<const K: usize>(
        &self,
        i: usize,
        j: usize,
        change: &Lanes<K>,
        through: &Lanes<ENTRIES>,
    ) -> f64 {
        let loss = self.loss[j][i] + through[i] + dot(change, through);
        if i >= RAMP_COLUMN {
            loss + self.t * through[i - TORQUES]
        } else {
            loss
        }
    }

    /// Adds what ω_o(0) and its change over the first half lose in the second one.
    #[cold]
    #[inline(never)]
    fn double_mesh_loss<const K: usize>(&mut self, half: &Self, changes: &[Lanes<K>; ENTRIES]) {
        let second: [f64; ENTRIES] = core::array::from_fn(|j| {
            let ramp = if j >= RAMP_COLUMN {
                half.t * half.output[j - TORQUES]
            } else {
                0.0
            };
            half.output[j] + dot(&changes[j], &half.output) + ramp
        });
        self.output = Lanes(core::array::from_fn(|j| half.output[j] + second[j]));
        self.add_mesh_loss(&half.columns.map(|column| column[O]), &second, 1.0);
    }

    /// Adds `weight` times the loss of ω_o's changes times what reads the torque lost.
    pub(crate) fn add_mesh_loss(
        &mut self,
        omega_o: &[f64; ENTRIES],
        torque: &[f64; ENTRIES],
        weight: f64,
    ) {
        for (j, column) in self.loss.iter_mut().enumerate() {
            for (i, loss) in column.iter_mut().enumerate() {
                *loss += 0.5 * weight * (omega_o[i] * torque[j] + torque[i] * omega_o[j]);
            }
        }
    }
}

/// Adds to `sum` what changes of the first numbers make of the columns.
#[inline(always)]
fn through<const N: usize, const K: usize>(
    sum: &mut Lanes<N>,
    columns: &[Lanes<N>; ENTRIES],
    change: &Lanes<K>,
) {
    let (core, shafts) = columns.split_at(CORE_STATES); // few enough that the compiler needs no loop
    for (column, change) in core.iter().zip(&change.0) {
        add(sum, column, *change);
    }
    for (column, change) in shafts.iter().zip(&change[CORE_STATES..]) {
        add(sum, column, *change);
    }
}
