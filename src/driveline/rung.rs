//! One rung of the ladder: motion, work and losses over a fixed span, linear and quadratic in what moves it.
//!
//! Speeds that turn together twist nothing, so a driveline moves by its twists, the differences of its
//! speeds, its torques and their ramps: the sixteen entries of a [`Start`]. A column of each holds what it
//! adds to the state and to the work integrals, so one pass over the columns gives motion and work:
//!
//! ```text
//! x(t) − x(0)
//! ∫ ω dτ − ω(0) t       of ω_e, slip 1, slip 2, ω_w: what T_e, T_c1, T_c2, T_v work on; of a shaft
//!                       that is synchronised ω_c − g ω_o in place of the slip
//! ∫ τ ω dτ − ω(0) t²/2  of the same
//! ```
//!
//! All of them vanish where nothing moves, so they double without cancellation (`rung/builder.rs`): with Ψ, what a
//! rung makes of the sixteen entries, every row r obeys r(2t) = r(t) + r(t) Ψ(t), but for the angles,
//! which also gain t times the change of their speed over the first half, and the moments, which gain t times the
//! angles of the second half and t²/2 times that change. Losses are a quadratic form, F(2t) = F(t) + Ψᵀ F(t) Ψ.
//!
//! So work and losses are of no lower order than the motion: for torques that are ramps the energy balance closes to
//! round-off over any span, and an energy that does not close tells a fault of modes or matrices, not of quadrature. What
//! an impulse takes (slip removed at an event, a gear let go) is booked where it happens. How good a rung is:
//! [`crate::integrate`].
//!
//! A finished rung keeps the rows of the transfer shafts, which follow the output where they are rigid, and those
//! of the slips, which only a slipping clutch needs, apart from what every step needs, and the losses
//! packed: see `rung/loss.rs`.

pub(crate) mod builder;
pub(crate) mod held;
pub(crate) mod lanes;
mod loss;
pub(crate) mod motion;
mod series;
pub(crate) mod start;
pub(crate) mod watch;

use crate::matrices::{C, D, O, State, Systems, Torques};
use crate::rung::builder::Builder;
use crate::rung::lanes::{Lanes, add, dot};
use crate::rung::loss::Loss;
pub use crate::rung::motion::Motion;
use crate::rung::motion::{ALL, KEPT, SLIPS};
pub use crate::rung::start::Start;
use crate::rung::start::{BUILT, CLUTCH_RAMPS, ENTRIES, Entries, RAMPS, moving};

/// Motion over one level of the ladder with one choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct Rung {
    /// Time the rung spans [s].
    pub t: f64,
    /// g_i of gears that are in, else 0, shape (2).
    ratio: [f64; 2],
    /// g_i of gears that shafts are synchronised to, else 0, shape (2).
    synchroniser_ratio: [f64; 2],
    /// Both shafts follow the output rigidly.
    rigid: bool,
    /// What each entry adds to the motion.
    columns: [Lanes<ALL>; ENTRIES],
    /// What reads angles and moments of both slips from the entries: rows.
    slips: [Entries; 4],
    loss: Loss,
}

impl Rung {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        ratio: [0.0; 2],
        synchroniser_ratio: [0.0; 2],
        rigid: false,
        columns: [Lanes::ZERO; ENTRIES],
        slips: [Lanes::ZERO; 4],
        loss: Loss::ZERO,
    };

    /// Becomes what was built.
    pub(crate) fn take(&mut self, built: &Builder, systems: &Systems) {
        (self.t, self.ratio) = (built.t, systems.ratio);
        self.synchroniser_ratio = systems.synchroniser_ratio;
        self.rigid = systems.rigid_ratio[0] != 0.0 && systems.rigid_ratio[1] != 0.0;
        for (entry, column) in BUILT
            .map(|column| &built.columns[column])
            .iter()
            .enumerate()
        {
            self.columns[entry] = Lanes(KEPT.map(|row| column[row]));
            for (to, row) in self.slips.iter_mut().zip(SLIPS) {
                to[entry] = column[row];
            }
        }
        self.loss.pack(&built.loss, &built.output);
    }

    /// A start for [`Self::motion`].
    ///
    /// `x`: state, shape (10). `v`: T_e, T_c1, T_c2, T_v [N·m], shape (4). `v_dot`: their ramps [N·m/s].
    pub fn start(&self, x: &State, v: &Torques, v_dot: &Torques) -> Start {
        let mut entries = self.entries(x, v);
        for (ramp, value) in RAMPS.into_iter().zip(v_dot) {
            entries[ramp] = *value;
        }
        Start { x: *x, entries }
    }

    /// The entries of a start whose torques have no ramps.
    fn entries(&self, x: &State, v: &Torques) -> Entries {
        let v = &v.data.0[0];
        let Lanes([twist_d, twist_o, damper, drive, shafts @ ..]) =
            moving(&x.data.0[0], self.ratio);
        let [twist_1, twist_2, shaft_1, shaft_2] = shafts;
        Lanes([
            twist_d, twist_o, damper, drive, v[0], v[3], 0.0, 0.0, v[1], v[2], twist_1, twist_2,
            shaft_1, shaft_2, 0.0, 0.0,
        ])
    }

    /// Motion from a start; torques of clutches and ramps that are zero cost nothing.
    pub fn motion(&self, start: &Start) -> Motion {
        let mut motion = self.motion_held(start);
        for entry in [RAMPS[0], RAMPS[1], RAMPS[2]] {
            if start.entries[entry] != 0.0 {
                add(&mut motion.0, &self.columns[entry], start.entries[entry]);
            }
        }
        motion
    }

    /// Adds what a ramp [N·m/s] of torque `q` of T_e, T_c1, T_c2, T_v does to a motion without it.
    pub fn add_ramp(&self, motion: &mut Motion, q: usize, ramp: f64) {
        add(&mut motion.0, &self.columns[RAMPS[q]], ramp);
    }

    /// Change of the state by an entry alone, shape (10).
    pub(crate) fn change_by(&self, entry: usize) -> State {
        Motion(self.columns[entry].0).end(&State::zeros())
    }

    /// What reads ω_w(t) − ω_w(0) [rad/s] from the first entries of a start.
    pub(crate) fn wheel_row(&self) -> Lanes<CLUTCH_RAMPS> {
        Lanes(core::array::from_fn(|entry| self.columns[entry].0[3]))
    }

    /// Whether both shafts follow the output rigidly, so that their entries move nothing.
    pub(crate) const fn is_rigid(&self) -> bool {
        self.rigid
    }

    /// ∂ω_w(t) / ∂T_v' [s²/(kg·m²)]: effect of the ramp of the load on the wheel speed.
    pub const fn wheel_speed_by_load_ramp(&self) -> f64 {
        self.columns[RAMPS[3]].0[3]
    }

    /// Effect of the ramp of torque `q` on [`Motion::worked_speeds`] [s²/(kg·m²)], shape (3).
    pub(crate) const fn worked_speeds_by_ramp(&self, q: usize) -> [f64; 3] {
        let [_, d, _, w, .., c1, c2, _, _] = self.columns[RAMPS[q]].0;
        [d - c1, d - c2, w]
    }

    /// Work of T_e, T_c1, T_c2, T_v on ω_e, slip 1, slip 2, ω_w [J], shape (4).
    ///
    /// `motion`: the motion from the start.
    pub fn work(&self, start: &Start, motion: &Motion) -> Torques {
        let (z, x) = (&start.entries, &start.x);
        let friction = |i: usize| match start.torque(1 + i) {
            0.0 => 0.0,
            torque => torque * self.worked_angle(x, z, i),
        };
        let engine = start.torque(0) * motion.0[6] + start.ramp(0) * motion.0[9];
        let load = start.torque(3) * motion.0[7] + start.ramp(3) * motion.0[8];
        let mut work = Torques::from([engine, friction(0), friction(1), load]);
        for i in [0, 1] {
            let ramp = start.ramp(1 + i);
            if ramp != 0.0 {
                let moment = 0.5 * self.t * self.t * self.worked_speed(x, i);
                work[1 + i] += ramp * (moment + dot(&self.slips[2 + i], z));
            }
        }
        work
    }

    /// What T_c1 or T_c2 works on [rad/s].
    #[inline(always)]
    fn worked_speed(&self, x: &State, i: usize) -> f64 {
        match self.synchroniser_ratio[i] {
            0.0 => x[D] - x[C + i],
            g => x[C + i] - g * x[O],
        }
    }

    /// Energy lost in dampers and meshes from a start [J].
    pub fn viscous_loss(&self, start: &Start) -> f64 {
        self.loss.of(&start.entries, self.rigid, start.x[O])
    }
}
