//! Brake and dry rolling resistance: friction between the wheels and the road that holds at standstill.
//!
//! Sliding, T_v of (11) carries T_b sgn ω_w beside the smooth road load. At ω_w = 0 the wheels are held
//! while the torque on them, T_o − r_w M_v g sin φ, stays within T_b; beyond it they slide in its
//! direction. Holding, release and passage through zero are located like the events of a clutch.
//! A wheel reads and moves no clutch torque at an instant, so its mode is chosen before theirs.
//!
//! Deviation: the paper has no brake, and (11) has no standstill.

use crate::Params;
use crate::matrices::springs::drive_shaft_torque;
use crate::matrices::{State, W};
use crate::plant::Plant;
use crate::plant::modes::{CAPACITY_MARGIN, Event, Guard, Mode};
use crate::plant::ports::{Input, InputRate};
use crate::road::{Grade, sign};

/// Wheel speed that counts as standstill [rad/s]: round-off of a held wheel.
const STANDSTILL: f64 = 1e-12;

impl Input {
    /// T_v of (11) with the brake [N·m].
    ///
    /// `direction`: sgn ω_w as the brake sees it.
    /// Returns its slope by ω_w [N·m·s/rad] as well.
    pub(crate) fn load_torque(
        &self,
        p: &Params,
        grade: &Grade,
        omega_w: f64,
        direction: f64,
    ) -> (f64, f64) {
        let (smooth, slope) = p.road.smooth_load(omega_w, grade);
        (smooth + direction * self.brake_capacity(p, grade), slope)
    }

    /// Largest dry friction torque at the wheels [N·m], ≥ 0.
    fn brake_capacity(&self, p: &Params, grade: &Grade) -> f64 {
        self.t_brake + p.road.dry_rolling() * grade.level
    }

    /// Rate of [`Self::brake_capacity`] [N·m/s].
    fn brake_capacity_rate(p: &Params, grade: &Grade, rate: &InputRate) -> f64 {
        let rolling = -p.road.dry_rolling() * grade.climb * rate.phi;
        rate.t_brake + rolling
    }
}

/// What would set standing wheels in motion [N·m]: T_o − r_w M_v g sin φ.
fn urge(p: &Params, grade: &Grade, x: &State) -> f64 {
    drive_shaft_torque(p, x) - grade.climb
}

/// The two guards of the brake: speed in the direction of sliding, or capacity left both ways.
///
/// `x_dot`: rate of the state `x`.
pub(crate) fn guards(
    p: &Params,
    grade: &Grade,
    mode: Mode,
    x: &State,
    x_dot: &State,
    input: &Input,
    rate: &InputRate,
) -> [Guard; 2] {
    let guard = |value, rate| Guard { value, rate };
    if mode != Mode::Stuck {
        let direction = mode.direction();
        return [
            guard(direction * x[W], direction * x_dot[W]),
            guard(0.0, 0.0),
        ];
    }
    let slope = grade.level * rate.phi;
    let (urge, urge_rate) = (urge(p, grade, x), drive_shaft_torque(p, x_dot) - slope);
    let (reach, reach_rate) = (
        input.brake_capacity(p, grade),
        Input::brake_capacity_rate(p, grade, rate),
    );
    [-1.0, 1.0].map(|sign| guard(reach + sign * urge, reach_rate + sign * urge_rate))
}

impl Plant {
    /// Takes the mode of the brake that is consistent after `event`; held wheels stand exactly still.
    pub(crate) fn resolve_brake(
        &mut self,
        p: &Params,
        input: &Input,
        rate: &InputRate,
        event: &Event,
    ) {
        self.grade.become_of(p, input.phi);
        let grade = &self.grade;
        let capacity = input.brake_capacity(p, grade);
        let standing =
            self.brake == Mode::Stuck || event.wheel_reached || self.x[W].abs() <= STANDSTILL;
        let urge = urge(p, grade, &self.x);
        self.brake = if capacity <= 0.0 && Input::brake_capacity_rate(p, grade, rate) <= 0.0 {
            Mode::Open
        } else if !standing {
            Mode::slipping(self.x[W])
        } else if event.wheel_broken || urge.abs() > capacity * (1.0 + CAPACITY_MARGIN) {
            Mode::slipping(urge)
        } else {
            Mode::Stuck
        };
        if self.brake == Mode::Stuck || event.wheel_reached {
            self.work.load += 0.5 * p.j_v * self.x[W] * self.x[W];
            self.x[W] = 0.0;
        }
    }

    /// T_b ω_w of the sliding brake [W], ≥ 0.
    pub(crate) fn brake_power(&self, t_brake: f64) -> f64 {
        if t_brake == 0.0 {
            return 0.0;
        }
        self.brake_direction() * t_brake * self.x[W]
    }

    /// Change of [`Self::brake_power`] [W] by those of the wheel speed and of T_b.
    pub(crate) fn brake_power_change(&self, input: &Input, d_omega_w: f64, d_t_brake: f64) -> f64 {
        self.brake_direction() * (input.t_brake * d_omega_w + d_t_brake * self.x[W])
    }

    /// sgn ω_w as the brake sees it [1]; 0 while it holds.
    pub(crate) fn brake_direction(&self) -> f64 {
        match self.brake {
            Mode::Open => sign(self.x[W]),
            mode => mode.direction(),
        }
    }
}
