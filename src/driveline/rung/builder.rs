//! How a rung is built: by series over a span that is short for the fastest eigenvalue, then by doubling.

use nalgebra::SMatrix;

use crate::plant::matrices::{AUGMENTED, C, D, E, O, SPEEDS, STATES, System, Systems, TORQUES, W};
use crate::rung::{ANGLE, MOMENT, RAMP, ROWS, add};

/// Columns of z = (x, v, v').
pub(crate) type Columns<const N: usize> = [[f64; N]; AUGMENTED];

/// Most terms of the exponential series: with ‖A t‖ ≤ 0.05 the next one is 0.05^10 / 10! < 1e-19.
const SERIES_TERMS: u32 = 9;
/// Size of a term beside which all further ones are below round-off [1].
const NO_TERM: f64 = 1e-19;

/// A rung while it is built: its columns, and the losses as a full matrix.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Builder {
    pub(crate) t: f64,
    pub(crate) columns: Columns<ROWS>,
    pub(crate) loss: Columns<AUGMENTED>,
}

impl Builder {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        columns: [[0.0; ROWS]; AUGMENTED],
        loss: [[0.0; AUGMENTED]; AUGMENTED],
    };

    /// Turns this into a rung of a span `t` [s] by series; losses by Gauss' rule of order 6.
    ///
    /// `norm`: ‖A t‖ [1], ≤ 0.05.
    #[inline(never)] // its stack is free again when the doublings need theirs
    pub(crate) fn base(&mut self, systems: &Systems, set: usize, t: f64, norm: f64) {
        let (system, ratio) = (&systems.by_stuck[set & 3], systems.synchroniser_ratio);
        *self = Self::ZERO;
        self.t = t;
        let nodes = gauss();
        let mut at_nodes = [IDENTITY; 3];
        let mut term = [[0.0; STATES]; AUGMENTED];
        first_term(system, &mut term, t);
        add_worked(&mut self.columns, &IDENTITY, ratio, [t, 0.5 * t * t]);
        let mut size = 1.0;
        for k in 1..=SERIES_TERMS {
            let order = f64::from(k);
            let integrals = [t / (order + 1.0), t * t / (order + 2.0)];
            add_worked(&mut self.columns, &term, ratio, integrals);
            for (column, term) in self.columns.iter_mut().zip(&term) {
                (0..STATES).for_each(|i| column[i] += term[i]);
            }
            for ((node, _), at_node) in nodes.iter().zip(&mut at_nodes) {
                let power = (1..k).fold(*node, |power, _| power * node);
                at_node
                    .iter_mut()
                    .zip(&term)
                    .for_each(|(to, term)| add(to, term, power));
            }
            size *= norm / order;
            if size < NO_TERM {
                break;
            }
            advance_term(system, &mut term, t, order + 1.0);
        }
        for ((_, weight), psi) in nodes.iter().zip(&at_nodes) {
            let (loss, viscous) = (&mut self.loss, &systems.viscous);
            if systems.meshes_lose() {
                add_loss::<STATES>(loss, viscous, psi, weight * t);
            } else {
                add_loss::<SPEEDS>(loss, viscous, psi, weight * t);
            }
        }
    }

    /// Turns this rung into one of twice the span; `active`: columns that are not zero.
    pub(crate) fn double(&mut self, active: &[usize]) {
        let old = *self;
        let states = transposed(&old.columns);
        for &j in active {
            let mut second = old.columns[j];
            through(&mut second, &old.columns, &old.columns[j], j, old.t);
            for q in 0..TORQUES {
                second[MOMENT + q] += old.t * second[ANGLE + q];
            }
            add(&mut self.columns[j], &second, 1.0);
            if j < STATES {
                let loss = old.second_loss::<STATES>(&states, j);
                add(&mut self.loss[j], &loss, 1.0);
            } else {
                let loss = old.second_loss::<AUGMENTED>(&states, j);
                add(&mut self.loss[j], &loss, 1.0);
            }
        }
        self.mirror_loss();
        self.t = 2.0 * old.t;
    }

    /// The first rows of column j of Ψᵀ F Ψ: what is lost in the second half of twice the span.
    ///
    /// `states`: rows of the state. A column of the state needs its own rows only: F is symmetric.
    #[inline(always)]
    fn second_loss<const N: usize>(
        &self,
        states: &[[f64; AUGMENTED]; STATES],
        j: usize,
    ) -> [f64; N] {
        let mut half: [f64; N] = core::array::from_fn(|i| self.loss[j][i]);
        through(&mut half, &self.loss, &self.columns[j], j, self.t);
        let mut loss = half;
        for (row, entry) in states.iter().zip(half) {
            add(&mut loss, row, entry);
        }
        for (ramp, torque) in loss.iter_mut().skip(RAMP).zip(&half[STATES.min(N)..]) {
            *ramp += self.t * torque;
        }
        loss
    }

    /// Writes the rows of torques below the columns of the state, from those of the other half of F.
    fn mirror_loss(&mut self) {
        let (states, torques) = self.loss.split_at_mut(STATES);
        for (j, torque) in torques.iter().enumerate() {
            for (state, entry) in states.iter_mut().zip(torque) {
                state[STATES + j] = *entry;
            }
        }
    }
}

/// Columns that are not zero with the clutches of `set` engaged: their torques do not count.
pub(crate) const fn active(set: usize) -> &'static [usize] {
    match set & 3 {
        0 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17],
        1 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 13, 14, 16, 17],
        2 => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 15, 17],
        _ => &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 13, 14, 17],
    }
}

/// Adds to `sum` the column j of R (Ψ − 1), R given by its columns and Ψ − 1 by its own `change`.
fn through<const N: usize, const M: usize>(
    sum: &mut [f64; N],
    columns: &Columns<M>,
    change: &[f64; ROWS],
    j: usize,
    t: f64,
) {
    for (column, entry) in columns.iter().zip(&change[..STATES]) {
        add(sum, column, *entry);
    }
    if j >= RAMP {
        add(sum, &columns[j - TORQUES], t);
    }
}

/// Rows of the state out of the columns.
fn transposed(columns: &Columns<ROWS>) -> [[f64; AUGMENTED]; STATES] {
    core::array::from_fn(|i| core::array::from_fn(|j| columns[j][i]))
}

/// Ψ over no time at all; lies with the constants, not on the stack.
static IDENTITY: Columns<STATES> = {
    let (mut identity, mut i) = ([[0.0; STATES]; AUGMENTED], 0);
    while i < STATES {
        identity[i][i] = 1.0;
        i += 1;
    }
    identity
};

/// Fills in t (A B 0): the first term of Ψ − 1.
fn first_term(system: &System, term: &mut Columns<STATES>, t: f64) {
    let columns = system.a.data.0.iter().chain(&system.b.data.0);
    for (term, column) in term.iter_mut().zip(columns) {
        *term = column.map(|entry| entry * t);
    }
}

/// Turns a term into that of the next order k: A t / k times it; the ramps join at order 2.
#[inline(never)] // its stack is free again when the losses need theirs
fn advance_term(system: &System, term: &mut Columns<STATES>, t: f64, k: f64) {
    let mut next = [[0.0; STATES]; AUGMENTED];
    for (next, term) in next.iter_mut().zip(&*term) {
        for (a, entry) in system.a.data.0.iter().zip(term) {
            if *entry != 0.0 {
                add(next, a, entry * t / k);
            }
        }
    }
    if k == 2.0 {
        for q in 0..TORQUES {
            next[RAMP + q] = term[STATES + q].map(|entry| entry * t / k);
        }
    }
    *term = next;
}

/// Adds the worked speeds of a term to angles and moments, with the factors of both.
fn add_worked(
    columns: &mut Columns<ROWS>,
    term: &Columns<STATES>,
    synchroniser_ratio: [f64; 2],
    factor: [f64; 2],
) {
    for (column, x) in columns.iter_mut().zip(term) {
        let [one, two] = [0, 1].map(|i| match synchroniser_ratio[i] {
            0.0 => x[D] - x[C + i],
            g => x[C + i] - g * x[O],
        });
        let worked = [x[E], one, two, x[W]];
        for (q, speed) in worked.into_iter().enumerate() {
            column[ANGLE + q] += factor[0] * speed;
            column[MOMENT + q] += factor[1] * speed;
        }
    }
}

/// Adds `weight` ψᵀ V ψ, V the power lost by the first `N` states.
#[inline(never)] // its stack is free again when the series needs its own
fn add_loss<const N: usize>(
    loss: &mut Columns<AUGMENTED>,
    viscous: &SMatrix<f64, STATES, STATES>,
    psi: &Columns<STATES>,
    weight: f64,
) {
    let rows: [[f64; AUGMENTED]; N] = core::array::from_fn(|i| core::array::from_fn(|j| psi[j][i]));
    for (loss, column) in loss.iter_mut().zip(psi) {
        let mut power = [0.0; N];
        for (row, entry) in viscous.data.0.iter().zip(&column[..N]) {
            add(&mut power, row, entry * weight);
        }
        for (row, power) in rows.iter().zip(power) {
            add(loss, row, power);
        }
    }
}

/// Nodes and weights of Gauss' three-point rule on [0, 1].
fn gauss() -> [(f64, f64); 3] {
    let reach = nalgebra::ComplexField::sqrt(0.6_f64);
    [
        (0.5 * (1.0 - reach), 5.0 / 18.0),
        (0.5, 8.0 / 18.0),
        (0.5 * (1.0 + reach), 5.0 / 18.0),
    ]
}
