//! One rung of the ladder: motion, work and losses over a fixed span, linear and quadratic in z.
//!
//! With z = (x, v, v') the state moves to x + X z. Below the rows of X stand those of the work
//! integrals, so one pass over the columns gives motion and work:
//!
//! ```text
//! rows 0..10   x(t) − x(0)
//! rows 10..14  ∫ ω dτ     of ω_e, slip 1, slip 2, ω_w: what T_e, T_c1, T_c2, T_v work on; of a shaft
//!                         that is synchronised ω_c − g ω_o in place of the slip
//! rows 14..18  ∫ τ ω dτ   of the same
//! ```
//!
//! Doubling a span uses Ψ = (I + X over the states, v + t v' for torques): every row r obeys
//! r(2t) = r(t) + r(t) Ψ(t), but for the moments, which also gain t times the angles of the second
//! half. Losses are a quadratic form, F(2t) = F(t) + Ψᵀ F(t) Ψ.
//!
//! A finished rung keeps the rows that every step needs together, those of the slips, which only a
//! slipping clutch needs, apart, and the losses packed: see `rung_loss.rs`.

use nalgebra::{SMatrix, SVector};

use crate::plant_matrices::{
    AUGMENTED, C, D, E, O, SPEEDS, STATES, State, System, Systems, TORQUES, Torques, W,
};
use crate::rung_loss::Loss;

/// Terms of the exponential series: with ‖A t‖ ≤ 0.05 the next one is 0.05^10 / 10! < 1e-19.
const SERIES_TERMS: u32 = 9;
/// First row of the angles.
const ANGLE: usize = STATES;
/// First row of the moments.
const MOMENT: usize = ANGLE + TORQUES;
const ROWS: usize = MOMENT + TORQUES;
/// First ramp among the columns.
const RAMP: usize = STATES + TORQUES;
/// Rows of every step: states, angles of ω_e and ω_w, moments of ω_w and ω_e.
const MAIN: usize = STATES + 4;
/// Those rows among all of them, behind the states.
const WORKED: [usize; 4] = [ANGLE, ANGLE + 3, MOMENT + 3, MOMENT];
/// The rows of slipping clutches: angles and moments of the slips.
const SLIPS: [usize; 4] = [ANGLE + 1, ANGLE + 2, MOMENT + 1, MOMENT + 2];

/// State, torques and their ramps, shape (18).
pub type Augmented = SVector<f64, AUGMENTED>;
type Columns<const N: usize> = [[f64; N]; AUGMENTED];

/// Where a rung leads from z: change of the state, angles and moments of ω_e and ω_w.
#[derive(Debug, Clone, Copy)]
pub struct Motion([f64; MAIN]);

impl Motion {
    /// x(t).
    pub fn end(&self, z: &Augmented) -> State {
        let z = entries(z);
        State::from(core::array::from_fn::<f64, STATES, _>(|i| z[i] + self.0[i]))
    }

    /// ω_w(t) [rad/s].
    pub fn wheel_speed(&self, z: &Augmented) -> f64 {
        z[W] + self.0[W]
    }

    /// ∫ ω_w dτ [rad] and ∫ τ ω_w dτ [rad·s], shape (2): what a constant torque and a ramp on the wheels work on.
    pub(crate) const fn wheel_angles(&self) -> [f64; 2] {
        let [.., angle, moment, _] = self.0;
        [angle, moment]
    }

    /// Slip 1, slip 2 and ω_w at the end [rad/s], shape (3): what T_c1, T_c2 and T_v work on.
    pub(crate) fn worked_speeds(&self, z: &Augmented) -> [f64; 3] {
        let x = self.end(z);
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }
}

/// Motion over one level of the ladder with one choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct Rung {
    /// Time the rung spans [s].
    pub t: f64,
    /// What each entry of z adds to the motion.
    columns: Columns<MAIN>,
    /// What reads angles and moments of both slips from z: rows.
    slips: [[f64; AUGMENTED]; 4],
    loss: Loss,
}

impl Rung {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        columns: [[0.0; MAIN]; AUGMENTED],
        slips: [[0.0; AUGMENTED]; 4],
        loss: Loss::ZERO,
    };

    /// Motion from z; torques and ramps that are zero cost nothing.
    #[inline(always)]
    pub fn motion(&self, z: &Augmented) -> Motion {
        let (mut rows, z) = ([0.0; MAIN], entries(z));
        for (column, z) in self.columns[..=STATES].iter().zip(z) {
            add(&mut rows, column, *z);
        }
        for (column, &z) in self.columns[STATES + 1..].iter().zip(&z[STATES + 1..]) {
            if z != 0.0 {
                add(&mut rows, column, z);
            }
        }
        Motion(rows)
    }

    /// Adds what a ramp of the load [N·m/s] does to a motion without one.
    pub fn add_load_ramp(&self, motion: &mut Motion, ramp: f64) {
        add(&mut motion.0, &self.columns[AUGMENTED - 1], ramp);
    }

    /// ∂ω_w(t) / ∂T_v' [s²/(kg·m²)]: effect of the ramp of the load on the wheel speed.
    pub fn wheel_speed_by_load_ramp(&self) -> f64 {
        self.columns[AUGMENTED - 1][W]
    }

    /// Adds what a ramp [N·m/s] of torque `q` of T_e, T_c1, T_c2, T_v does to a motion without it.
    pub(crate) fn add_ramp(&self, motion: &mut Motion, q: usize, ramp: f64) {
        add(&mut motion.0, &self.columns[RAMP + q], ramp);
    }

    /// Effect of the ramp of torque `q` on [`Motion::worked_speeds`] [s²/(kg·m²)], shape (3).
    pub(crate) fn worked_speeds_by_ramp(&self, q: usize) -> [f64; 3] {
        let x = &self.columns[RAMP + q];
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }

    /// Work of T_e, T_c1, T_c2, T_v on ω_e, slip 1, slip 2, ω_w [J], shape (4).
    ///
    /// `motion`: the motion from z.
    #[inline(always)]
    pub fn work(&self, z: &Augmented, motion: &Motion) -> Torques {
        let (z, [.., angle_e, angle_w, moment_w, moment_e]) = (entries(z), motion.0);
        let friction = |i: usize| {
            let (torque, ramp) = (z[STATES + 1 + i], z[RAMP + 1 + i]);
            if torque == 0.0 && ramp == 0.0 {
                return 0.0;
            }
            torque * dot(&self.slips[i], z) + ramp * dot(&self.slips[2 + i], z)
        };
        Torques::from([
            z[STATES] * angle_e + z[RAMP] * moment_e,
            friction(0),
            friction(1),
            z[STATES + 3] * angle_w + z[RAMP + 3] * moment_w,
        ])
    }

    /// Energy lost in the dampers from z [J].
    #[inline(always)]
    pub fn viscous_loss(&self, z: &Augmented) -> f64 {
        self.loss.of(z)
    }
}

/// The entries of z, whose number the compiler knows.
const fn entries(z: &Augmented) -> &[f64; AUGMENTED] {
    &z.data.0[0]
}

/// `sum` + `scale` · `column`, which may be shorter; inlined, so that a chain of these keeps the sum in registers.
#[inline(always)]
pub(crate) fn add<const N: usize, const M: usize>(
    sum: &mut [f64; N],
    column: &[f64; M],
    scale: f64,
) {
    for (sum, entry) in sum.iter_mut().zip(column) {
        *sum += entry * scale;
    }
}

/// Σ a b over the entries of `a`, in two lanes.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (pairs, rest) = a.as_chunks::<2>();
    let (others, _) = b.as_chunks::<2>();
    let mut lanes = [0.0; 2];
    for ([a0, a1], [b0, b1]) in pairs.iter().zip(others) {
        lanes[0] += a0 * b0;
        lanes[1] += a1 * b1;
    }
    let last = rest.iter().zip(&b[2 * pairs.len()..]).map(|(a, b)| a * b);
    lanes[0] + lanes[1] + last.sum::<f64>()
}

/// A rung while it is built: its columns, and the losses as a full matrix.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Builder {
    t: f64,
    columns: Columns<ROWS>,
    loss: Columns<AUGMENTED>,
}

impl Builder {
    /// A rung of a span [s] with ‖A t‖ ≤ 0.05, by series; losses by Gauss' rule of order 6.
    #[inline(never)] // its stack is free again when the doublings need theirs
    pub(crate) fn base(systems: &Systems, set: usize, t: f64) -> Self {
        let (system, ratio) = (&systems.by_stuck[set & 3], systems.synchroniser_ratio);
        let mut new = Self {
            t,
            columns: [[0.0; ROWS]; AUGMENTED],
            loss: [[0.0; AUGMENTED]; AUGMENTED],
        };
        let nodes = gauss();
        let mut at_nodes = nodes.map(|_| identity());
        let mut term = first_term(system, t);
        add_worked(&mut new.columns, &identity(), ratio, [t, 0.5 * t * t]);
        for k in 1..=SERIES_TERMS {
            let order = f64::from(k);
            let integrals = [t / (order + 1.0), t * t / (order + 2.0)];
            add_worked(&mut new.columns, &term, ratio, integrals);
            for (column, term) in new.columns.iter_mut().zip(&term) {
                (0..STATES).for_each(|i| column[i] += term[i]);
            }
            for ((node, _), at_node) in nodes.iter().zip(&mut at_nodes) {
                let power = (1..k).fold(*node, |power, _| power * node);
                at_node
                    .iter_mut()
                    .zip(&term)
                    .for_each(|(to, term)| add(to, term, power));
            }
            term = next_term(system, &term, t, order + 1.0);
        }
        for ((_, weight), psi) in nodes.iter().zip(&at_nodes) {
            add_loss(&mut new.loss, &systems.viscous, psi, weight * t);
        }
        new
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
            let mut loss = old.loss[j];
            through(&mut loss, &old.loss, &old.columns[j], j, old.t);
            let half = loss;
            for (row, entry) in states.iter().zip(half) {
                add(&mut loss, row, entry);
            }
            for q in 0..TORQUES {
                loss[RAMP + q] += old.t * half[STATES + q];
            }
            add(&mut self.loss[j], &loss, 1.0);
        }
        self.t = 2.0 * old.t;
    }

    /// Writes the finished rung to its place.
    pub(crate) fn finish(&self, rung: &mut Rung) {
        rung.t = self.t;
        for (j, column) in self.columns.iter().enumerate() {
            let (states, worked) = rung.columns[j].split_at_mut(STATES);
            states.copy_from_slice(&column[..STATES]);
            worked.copy_from_slice(&WORKED.map(|row| column[row]));
            for (to, row) in rung.slips.iter_mut().zip(SLIPS) {
                to[j] = column[row];
            }
        }
        rung.loss.pack(&self.loss);
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
fn through<const N: usize>(
    sum: &mut [f64; N],
    columns: &Columns<N>,
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

fn identity() -> Columns<STATES> {
    core::array::from_fn(|j| core::array::from_fn(|i| f64::from(u8::from(i == j))))
}

/// t (A B 0): the first term of Ψ − 1.
fn first_term(system: &System, t: f64) -> Columns<STATES> {
    core::array::from_fn(|j| match j {
        0..STATES => system.a.column(j).into_owned().data.0[0].map(|a| a * t),
        STATES..RAMP => system.b.column(j - STATES).into_owned().data.0[0].map(|b| b * t),
        _ => [0.0; STATES],
    })
}

/// A term of order k from the one before: A t / k times it; the ramps join at order 2.
fn next_term(system: &System, term: &Columns<STATES>, t: f64, k: f64) -> Columns<STATES> {
    let mut next = [[0.0; STATES]; AUGMENTED];
    for (next, term) in next.iter_mut().zip(term) {
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
    next
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

/// Adds `weight` ψᵀ V ψ, V the viscous power of the speeds.
fn add_loss(
    loss: &mut Columns<AUGMENTED>,
    viscous: &SMatrix<f64, STATES, STATES>,
    psi: &Columns<STATES>,
    weight: f64,
) {
    for (loss, column) in loss.iter_mut().zip(psi) {
        let mut power = [0.0; STATES];
        for (row, entry) in viscous.data.0.iter().zip(&column[..SPEEDS]) {
            add(&mut power, row, entry * weight);
        }
        for (loss, other) in loss.iter_mut().zip(psi) {
            *loss += other[..SPEEDS]
                .iter()
                .zip(&power)
                .map(|(a, b)| a * b)
                .sum::<f64>();
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
