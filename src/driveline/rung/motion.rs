//! Where a rung leads, row by row.

use crate::matrices::{C, D, E, O, STATES, State, TORQUES, TWIST_D, TWIST_O, TWIST_T, W};

/// First row of the angles.
pub(crate) const ANGLE: usize = STATES;
/// First row of the moments.
pub(crate) const MOMENT: usize = ANGLE + TORQUES;
/// Rows that are built: the state, angles, moments.
pub(crate) const ROWS: usize = MOMENT + TORQUES;

/// Rows of every step: states but for those of the shafts, angles of ω_e and ω_w, moments of ω_w and ω_e.
pub(crate) const MAIN: usize = 10;
/// With those of the shafts.
pub(crate) const ALL: usize = MAIN + 4;
/// The same among all rows that are built.
pub(crate) const KEPT: [usize; ALL] = [
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
    C,
    C + 1,
    TWIST_T,
    TWIST_T + 1,
];
/// The rows of slipping clutches: angles and moments of the slips.
pub(crate) const SLIPS: [usize; 4] = [ANGLE + 1, ANGLE + 2, MOMENT + 1, MOMENT + 2];

/// Where a rung leads: change of the state, angles and moments of ω_e and ω_w.
#[derive(Debug, Clone, Copy)]
pub struct Motion(pub(crate) [f64; ALL]);

impl Motion {
    /// x(t), from x(0).
    #[inline(always)]
    pub fn end(&self, x: &State) -> State {
        let [
            e,
            d,
            o,
            w,
            twist_d,
            twist_o,
            _,
            _,
            _,
            _,
            c1,
            c2,
            twist_1,
            twist_2,
        ] = self.0;
        let change = [e, d, c1, c2, o, w, twist_d, twist_1, twist_2, twist_o];
        let x = &x.data.0[0];
        State::from(core::array::from_fn::<f64, STATES, _>(|i| x[i] + change[i]))
    }

    /// ω_w(t) [rad/s], from x(0).
    pub fn wheel_speed(&self, x: &State) -> f64 {
        x[W] + self.0[3]
    }

    /// ω_w(t) − ω_w(0) [rad/s].
    pub(crate) const fn wheel_speed_change(&self) -> f64 {
        self.0[3]
    }

    /// ∫ ω_w dτ [rad] and ∫ τ ω_w dτ [rad·s], shape (2): what a constant torque and a ramp on the wheels work on.
    pub(crate) const fn wheel_angles(&self) -> [f64; 2] {
        [self.0[7], self.0[8]]
    }

    /// Slip 1, slip 2 and ω_w at the end [rad/s], shape (3): what T_c1, T_c2 and T_v work on.
    pub(crate) fn worked_speeds(&self, x: &State) -> [f64; 3] {
        let x = self.end(x);
        [x[D] - x[C], x[D] - x[C + 1], x[W]]
    }
}
