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
//! A rung is built from columns for z = (x, v, v') and rows without the constant terms. Doubling a span
//! (`rung_builder.rs`) uses Ψ = (I + X over the states, v + t v' for torques): every row r obeys
//! r(2t) = r(t) + r(t) Ψ(t), but for the moments, which also gain t times the angles of the second
//! half. Losses are a quadratic form, F(2t) = F(t) + Ψᵀ F(t) Ψ.
//!
//! A finished rung keeps the rows of the transfer shafts, which follow the output where they are rigid, and those
//! of the slips, which only a slipping clutch needs, apart from what every step needs, and the losses
//! packed: see `rung_loss.rs`.

use crate::plant_matrices::{
    C, D, E, O, STATES, State, Systems, TORQUES, TWIST_D, TWIST_O, TWIST_T, Torques, W,
};
use crate::rung_builder::Builder;
use crate::rung_loss::Loss;
pub use crate::rung_start::Start;
use crate::rung_start::{CLUTCHES, COLUMNS, CORE, ENTRIES, RAMPS, SHAFTS};

/// First row of the angles.
pub(crate) const ANGLE: usize = STATES;
/// First row of the moments.
pub(crate) const MOMENT: usize = ANGLE + TORQUES;
pub(crate) const ROWS: usize = MOMENT + TORQUES;
/// First ramp among the columns that a rung is built from.
pub(crate) const RAMP: usize = STATES + TORQUES;

/// Rows of every step: states but for those of the shafts, angles of ω_e and ω_w, moments of ω_w and ω_e.
const MAIN: usize = 10;
/// Those rows among all that are built.
const MAIN_ROWS: [usize; MAIN] = [
    E,
    D,
    O,
    W,
    TWIST_D,
    TWIST_O,
    ANGLE,
    ANGLE + 3,
    MOMENT + 3,
    MOMENT,
];
/// The rows of the shafts.
const SHAFT_ROWS: [usize; 4] = [C, C + 1, TWIST_T, TWIST_T + 1];
/// The rows of slipping clutches: angles and moments of the slips.
const SLIPS: [usize; 4] = [ANGLE + 1, ANGLE + 2, MOMENT + 1, MOMENT + 2];

/// Where a rung leads: change of the state, angles and moments of ω_e and ω_w.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    main: [f64; MAIN],
    shafts: [f64; 4],
}

impl Motion {
    /// x(t).
    #[inline(always)]
    pub fn end(&self, start: &Start) -> State {
        let ([e, d, o, w, twist_d, twist_o, ..], [c1, c2, twist_1, twist_2]) =
            (self.main, self.shafts);
        let change = [e, d, c1, c2, o, w, twist_d, twist_1, twist_2, twist_o];
        let x = &start.x.data.0[0];
        State::from(core::array::from_fn::<f64, STATES, _>(|i| x[i] + change[i]))
    }

    /// ω_w(t) [rad/s].
    pub fn wheel_speed(&self, start: &Start) -> f64 {
        start.x[W] + self.main[3]
    }

    /// ∫ ω_w dτ [rad] and ∫ τ ω_w dτ [rad·s], shape (2): what a constant torque and a ramp on the wheels work on.
    pub(crate) const fn wheel_angles(&self) -> [f64; 2] {
        let [.., angle, moment, _] = self.main;
        [angle, moment]
    }

    /// Slip 1, slip 2 and ω_w at the end [rad/s], shape (3): what T_c1, T_c2 and T_v work on.
    pub(crate) fn worked_speeds(&self, start: &Start) -> [f64; 3] {
        let x = self.end(start);
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }
}

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
    /// What each entry adds to the rows of every step.
    main: [[f64; MAIN]; ENTRIES],
    /// What each entry adds to the states of the shafts.
    shafts: [[f64; 4]; ENTRIES],
    /// What reads angles and moments of both slips from the entries: rows.
    slips: [[f64; ENTRIES]; 4],
    loss: Loss,
}

impl Rung {
    /// A rung that leads nowhere.
    pub(crate) const ZERO: Self = Self {
        t: 0.0,
        ratio: [0.0; 2],
        synchroniser_ratio: [0.0; 2],
        rigid: false,
        main: [[0.0; MAIN]; ENTRIES],
        shafts: [[0.0; 4]; ENTRIES],
        slips: [[0.0; ENTRIES]; 4],
        loss: Loss::ZERO,
    };

    /// Becomes what was built.
    pub(crate) fn take(&mut self, built: &Builder, systems: &Systems) {
        (self.t, self.ratio) = (built.t, systems.ratio);
        self.synchroniser_ratio = systems.synchroniser_ratio;
        self.rigid = systems.rigid_ratio[0] != 0.0 && systems.rigid_ratio[1] != 0.0;
        for (entry, column) in COLUMNS
            .map(|column| &built.columns[column])
            .iter()
            .enumerate()
        {
            self.main[entry] = MAIN_ROWS.map(|row| column[row]);
            self.shafts[entry] = SHAFT_ROWS.map(|row| column[row]);
            for (to, row) in self.slips.iter_mut().zip(SLIPS) {
                to[entry] = column[row];
            }
        }
        self.take_off_constant_speeds();
        self.loss.pack(&built.loss, systems);
    }

    /// Leaves to angles and moments what speeds add to them that change.
    fn take_off_constant_speeds(&mut self) {
        let (angle, moment) = (self.t, 0.5 * self.t * self.t);
        let [.., angle_e, _, _, moment_e] = &mut self.main[2];
        (*angle_e, *moment_e) = (*angle_e - angle, *moment_e - moment);
        let [.., angle_w, moment_w, _] = &mut self.main[3];
        (*angle_w, *moment_w) = (*angle_w - angle, *moment_w - moment);
        for i in [0, 1] {
            let sign = if self.synchroniser_ratio[i] == 0.0 {
                -1.0
            } else {
                1.0
            };
            self.slips[i][SHAFTS + 2 + i] -= sign * angle;
            self.slips[2 + i][SHAFTS + 2 + i] -= sign * moment;
        }
    }

    /// A start for [`Self::motion`].
    ///
    /// `x`: state, shape (10). `v`: T_e, T_c1, T_c2, T_v [N·m], shape (4). `v_dot`: their ramps [N·m/s].
    #[inline(always)]
    pub fn start(&self, x: &State, v: &Torques, v_dot: &Torques) -> Start {
        let shaft = |i: usize| x[C + i] - self.ratio[i] * x[O];
        let entries = [
            x[TWIST_D],
            x[TWIST_O],
            x[E] - x[D],
            x[W] - x[O],
            v[0],
            v[3],
            v_dot[3],
            v_dot[0],
            x[TWIST_T],
            x[TWIST_T + 1],
            shaft(0),
            shaft(1),
            v[1],
            v[2],
            v_dot[1],
            v_dot[2],
        ];
        Start { x: *x, entries }
    }

    /// Motion from a start; torques of clutches and ramps that are zero cost nothing.
    #[inline(always)]
    pub fn motion(&self, start: &Start) -> Motion {
        let mut motion = self.motion_held(start);
        for entry in [6, 7, 14, 15] {
            if start.entries[entry] != 0.0 {
                self.add_entry(&mut motion, entry, start.entries[entry]);
            }
        }
        motion
    }

    /// Motion from a start as if no torque had a ramp.
    #[inline(always)]
    pub(crate) fn motion_held(&self, start: &Start) -> Motion {
        let (t, z, x) = (self.t, &start.entries, &start.x.data.0[0]);
        let angles = [x[E] * t, x[W] * t];
        let moments = [0.5 * t * angles[1], 0.5 * t * angles[0]];
        let mut motion = Motion {
            main: [
                0.0, 0.0, 0.0, 0.0, 0.0, 0.0, angles[0], angles[1], moments[0], moments[1],
            ],
            shafts: [0.0; 4],
        };
        if self.rigid {
            self.add_core(&mut motion.main, z);
            let [_, _, o, ..] = motion.main;
            (motion.shafts[0], motion.shafts[1]) = (self.ratio[0] * o, self.ratio[1] * o);
        } else {
            self.add_core(&mut motion.main, z);
            self.add_shafts(&mut motion, z);
        }
        for entry in [CLUTCHES, CLUTCHES + 1] {
            if z[entry] != 0.0 {
                self.add_entry(&mut motion, entry, z[entry]);
            }
        }
        motion
    }

    /// Adds what the first twists, speeds and torques do. A function of its own has registers for it.
    #[inline(never)]
    fn add_core(&self, main: &mut [f64; MAIN], z: &[f64; ENTRIES]) {
        let mut sum = *main;
        add_columns(&mut sum, &self.main[..CORE], &z[..CORE]);
        *main = sum;
    }

    /// Adds the motion of the shafts, and what they do to the rest.
    #[inline(never)]
    fn add_shafts(&self, motion: &mut Motion, z: &[f64; ENTRIES]) {
        let (mut main, mut shafts) = (motion.main, motion.shafts);
        add_columns(
            &mut main,
            &self.main[SHAFTS..CLUTCHES],
            &z[SHAFTS..CLUTCHES],
        );
        add_columns(
            &mut shafts,
            &self.shafts[SHAFTS..CLUTCHES],
            &z[SHAFTS..CLUTCHES],
        );
        add_columns(&mut shafts, &self.shafts[..CORE], &z[..CORE]);
        (motion.main, motion.shafts) = (main, shafts);
    }

    #[inline(always)]
    fn add_entry(&self, motion: &mut Motion, entry: usize, value: f64) {
        add(&mut motion.main, &self.main[entry], value);
        add(&mut motion.shafts, &self.shafts[entry], value);
    }

    /// Adds what a ramp [N·m/s] of torque `q` of T_e, T_c1, T_c2, T_v does to a motion without it.
    #[inline(always)]
    pub fn add_ramp(&self, motion: &mut Motion, q: usize, ramp: f64) {
        self.add_entry(motion, RAMPS[q], ramp);
    }

    /// ∂ω_w(t) / ∂T_v' [s²/(kg·m²)]: effect of the ramp of the load on the wheel speed.
    pub const fn wheel_speed_by_load_ramp(&self) -> f64 {
        self.main[RAMPS[3]][3]
    }

    /// Effect of the ramp of torque `q` on [`Motion::worked_speeds`] [s²/(kg·m²)], shape (3).
    pub(crate) const fn worked_speeds_by_ramp(&self, q: usize) -> [f64; 3] {
        let ([_, d, _, w, ..], [c1, c2, ..]) = (self.main[RAMPS[q]], self.shafts[RAMPS[q]]);
        [d - c1, d - c2, w]
    }

    /// Work of T_e, T_c1, T_c2, T_v on ω_e, slip 1, slip 2, ω_w [J], shape (4).
    ///
    /// `motion`: the motion from the start.
    #[inline(always)]
    pub fn work(&self, start: &Start, motion: &Motion) -> Torques {
        let [.., angle_e, angle_w, moment_w, moment_e] = motion.main;
        Torques::from([
            start.torque(0) * angle_e + start.ramp(0) * moment_e,
            self.friction(start, 0),
            self.friction(start, 1),
            start.torque(3) * angle_w + start.ramp(3) * moment_w,
        ])
    }

    /// Work of T_c1 or T_c2 [J].
    #[inline(always)]
    fn friction(&self, start: &Start, i: usize) -> f64 {
        let (torque, ramp) = (start.torque(1 + i), start.ramp(1 + i));
        let (t, z, x) = (self.t, &start.entries, &start.x);
        if torque == 0.0 && ramp == 0.0 {
            return 0.0;
        }
        let speed = match self.synchroniser_ratio[i] {
            0.0 => x[D] - x[C + i],
            g => x[C + i] - g * x[O],
        };
        let work = torque * (speed * t + dot(&self.slips[i], z));
        if ramp == 0.0 {
            return work;
        }
        work + ramp * (0.5 * speed * t * t + dot(&self.slips[2 + i], z))
    }

    /// Energy lost in dampers and meshes from a start [J].
    #[inline(always)]
    pub fn viscous_loss(&self, start: &Start) -> f64 {
        self.loss.of(&start.entries, self.rigid, start.x[O])
    }
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

/// `sum` + Σ `scales` · `columns`.
#[inline(always)]
fn add_columns<const N: usize>(sum: &mut [f64; N], columns: &[[f64; N]], scales: &[f64]) {
    for (column, scale) in columns.iter().zip(scales) {
        add(sum, column, *scale);
    }
}

/// Σ a b of an even number of entries, in two lanes.
#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 2];
    for ([a0, a1], [b0, b1]) in a.as_chunks::<2>().0.iter().zip(b.as_chunks::<2>().0) {
        lanes[0] += a0 * b0;
        lanes[1] += a1 * b1;
    }
    lanes[0] + lanes[1]
}
