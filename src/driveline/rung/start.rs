//! What moves a driveline, entry by entry: where a rung starts from.

use crate::plant::matrices::{C, E, STATES, State, TORQUES, TWIST_D, TWIST_O, TWIST_T, W};
use crate::rung::RAMP;

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
/// T_e, T_c1, T_c2, T_v among the entries.
pub(crate) const TORQUE: [usize; TORQUES] = [4, 8, 9, 5];
/// Their ramps among the entries.
pub(crate) const RAMPS: [usize; TORQUES] = [7, 14, 15, 6];
/// Entries that every step has, up to T_v.
pub(crate) const CORE: usize = 6;
/// First entries of the clutches, of what only compliant transfer shafts and shafts in neutral have, and of the
/// clutches' ramps.
pub(crate) const CLUTCHES: usize = 8;
pub(crate) const SHAFTS: usize = 10;
pub(crate) const CLUTCH_RAMPS: usize = 14;

/// The entries in the order of [`COLUMNS`].
pub(crate) type Entries = [f64; ENTRIES];

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
        self.entries[TORQUE[q]]
    }

    /// The ramp of one of these torques [N·m/s].
    pub(crate) const fn ramp(&self, q: usize) -> f64 {
        self.entries[RAMPS[q]]
    }

    /// Adds to the ramp of one of these torques [N·m/s].
    pub(crate) const fn add_ramp(&mut self, q: usize, ramp: f64) {
        self.entries[RAMPS[q]] += ramp;
    }
}
