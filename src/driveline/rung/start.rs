//! What moves a driveline, entry by entry: where a rung starts from.

use crate::matrices::{C, D, E, O, STATES, State, TORQUES, TWIST_D, TWIST_O, TWIST_T, W};
use crate::rung::lanes::Lanes;

/// First ramp among the columns of z = (x, v, v').
pub(crate) const RAMP: usize = STATES + TORQUES;
/// Entries of a start.
pub(crate) const ENTRIES: usize = 16;
/// Twists of damper and drive shaft, ω_e − ω_d and ω_w − ω_o, T_e and T_v, their ramps T_v' and T_e'; then
/// T_c1, T_c2; then twists of the transfer shafts, ω_ci − g_i ω_o; then T_c1', T_c2': each as the column of z
/// that stands for it.
pub(crate) const COLUMNS: [usize; ENTRIES] = [
    TWIST_D,
    TWIST_O,
    E,
    W,
    STATES,
    STATES + 3,
    RAMP + 3,
    RAMP,
    STATES + 1,
    STATES + 2,
    TWIST_T,
    TWIST_T + 1,
    C,
    C + 1,
    RAMP + 1,
    RAMP + 2,
];
/// Entries of the state: numbers that move the driveline, those of the shafts last.
pub(crate) const MOVING: usize = 8;
pub(crate) const CORE_STATES: usize = 4;
/// Each as the state that stands for it.
pub(crate) const MOVING_STATES: [usize; MOVING] =
    [TWIST_D, TWIST_O, E, W, TWIST_T, TWIST_T + 1, C, C + 1];
/// The entries among the columns that are built: of the state, of the torques, of their ramps.
pub(crate) const BUILT: [usize; ENTRIES] = [0, 1, 2, 3, 8, 11, 15, 12, 9, 10, 4, 5, 6, 7, 13, 14];
/// T_e, T_c1, T_c2, T_v among the entries.
pub(crate) const TORQUE: [usize; TORQUES] = [4, 8, 9, 5];
/// Their ramps among the entries.
pub(crate) const RAMPS: [usize; TORQUES] = [7, 14, 15, 6];
/// Entries that every step begins with, up to T_v.
pub(crate) const HELD: usize = 6;
/// Entries that every step has, up to T_v'.
pub(crate) const CORE: usize = 7;
/// First entries of the clutches, of what only compliant transfer shafts and shafts in neutral have, and of the
/// clutches' ramps.
pub(crate) const CLUTCHES: usize = 8;
pub(crate) const SHAFTS: usize = 10;
pub(crate) const CLUTCH_RAMPS: usize = 14;

/// Entries where both shafts follow the output rigidly.
pub(crate) const RIGID: usize = SHAFTS;
/// Entries where they need not.
pub(crate) const COMPLIANT: usize = CLUTCH_RAMPS;

/// The entries in the order of [`COLUMNS`].
pub(crate) type Entries = Lanes<ENTRIES>;

/// State, torques and ramps from which a rung leads.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// Speeds [rad/s] and twists [rad], shape (10).
    pub x: State,
    pub(crate) entries: Entries,
}

impl Start {
    /// T_e, T_c1, T_c2 or T_v [N·m], by its place among them.
    pub(crate) const fn torque(&self, q: usize) -> f64 {
        self.entries.0[TORQUE[q]]
    }

    /// The ramp of one of these torques [N·m/s].
    pub(crate) const fn ramp(&self, q: usize) -> f64 {
        self.entries.0[RAMPS[q]]
    }

    /// Adds to the ramp of one of these torques [N·m/s].
    pub(crate) const fn add_ramp(&mut self, q: usize, ramp: f64) {
        self.entries.0[RAMPS[q]] += ramp;
    }
}

/// The entries of a state that begins with speeds and twists; `ratio`: g_i of gears that are in, shape (2).
#[inline(always)]
pub(crate) fn moving<const N: usize>(x: &[f64; N], ratio: [f64; 2]) -> Lanes<MOVING> {
    Lanes([
        x[TWIST_D],
        x[TWIST_O],
        x[E] - x[D],
        x[W] - x[O],
        x[TWIST_T],
        x[TWIST_T + 1],
        x[C] - ratio[0] * x[O],
        x[C + 1] - ratio[1] * x[O],
    ])
}

/// What T_e, T_c1, T_c2, T_v work on [rad/s], shape (4).
///
/// `synchroniser_ratio`: g_i of gears that shafts are synchronised to, else 0, shape (2).
#[inline(always)]
pub(crate) fn worked<const N: usize>(x: &[f64; N], synchroniser_ratio: [f64; 2]) -> [f64; TORQUES] {
    let [one, two] = [0, 1].map(|i| match synchroniser_ratio[i] {
        0.0 => x[D] - x[C + i],
        g => x[C + i] - g * x[O],
    });
    [x[E], one, two, x[W]]
}
