//! What an importer sets, and what becomes of it: inputs of the driveline with their rates.

use super::Plant;
use dct_driveline::Params;
use dct_driveline::params::Actuation;
use dct_driveline::plant::{self as driveline, InputRate};

/// What an importer sets.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Inputs {
    /// T_e [N·m].
    pub(super) engine_torque: f64,
    /// θ_m1, θ_m2 [m].
    pub(super) position: [f64; 2],
    /// Pressures of wet clutches [Pa].
    pub(super) pressure: [f64; 2],
    /// Brake torque [N·m].
    pub(super) brake_torque: f64,
    /// φ [rad].
    pub(super) grade: f64,
}

/// Where the actuators were last, and the normal forces there.
#[derive(Clone)]
pub(super) struct Pressed {
    position: [f64; 2],
    pressure: [f64; 2],
    /// F_n of both clutches [N].
    force: [f64; 2],
    /// Where their maps were read: behind which points.
    piece: [usize; 2],
}

impl Pressed {
    /// Nowhere yet: no actuator is there.
    pub(super) const NOWHERE: Self = Self {
        position: [f64::NAN; 2],
        pressure: [f64::NAN; 2],
        force: [0.0; 2],
        piece: [0; 2],
    };

    /// Whether the actuators are where they were.
    #[inline(always)]
    fn is_of(&self, u: &Inputs) -> bool {
        let pairs = [
            (self.position[0], u.position[0]),
            (self.position[1], u.position[1]),
            (self.pressure[0], u.pressure[0]),
            (self.pressure[1], u.pressure[1]),
        ];
        let differ = |bits, (was, is): (f64, f64)| bits | was.to_bits() ^ is.to_bits();
        pairs.into_iter().fold(0, differ) == 0
    }
}

impl Inputs {
    /// What moves clutch `i`.
    #[inline(always)]
    fn actuation(&self, i: usize) -> Actuation {
        Actuation {
            position: self.position[i],
            pressure: self.pressure[i],
        }
    }

    /// Whether all of them are zero.
    #[inline(always)]
    pub(super) fn is_zero(&self) -> bool {
        let ([one, two], [three, four]) = (self.position, self.pressure);
        let values = [
            self.engine_torque,
            one,
            two,
            three,
            four,
            self.brake_torque,
            self.grade,
        ];
        values.iter().fold(0, |bits, value| bits | value.to_bits()) << 1 == 0 // but for signs of zeros
    }
}

impl Plant {
    /// Inputs of the driveline at the communication point.
    #[inline(always)]
    pub(super) fn input(&mut self) -> driveline::Input {
        if !self.pressed.is_of(&self.u) {
            self.press();
        }
        driveline::Input {
            t_e: self.u.engine_torque,
            force: self.pressed.force,
            gear: self.gear,
            t_brake: self.u.brake_torque,
            phi: self.u.grade,
        }
    }

    #[inline(never)] // actuators rest most of the time
    fn press(&mut self) {
        let (u, was) = (&self.u, &mut self.pressed);
        (was.position, was.pressure) = (u.position, u.pressure);
        for i in [0, 1] {
            was.force[i] = self.p.clutch[i].force_near(u.actuation(i), &mut was.piece[i]);
        }
    }

    /// Rates of the driveline's inputs over a step; the force goes straight to that of its end.
    pub(super) fn rate(&self, start: &driveline::Input, step: f64) -> InputRate {
        if self.u_rate.is_zero() {
            return InputRate::default();
        }
        let end = |value: [f64; 2], rate: [f64; 2]| [0, 1].map(|i| value[i] + rate[i] * step);
        let position = end(self.u.position, self.u_rate.position);
        let force = force(
            &self.p,
            position,
            end(self.u.pressure, self.u_rate.pressure),
        );
        InputRate {
            t_e: self.u_rate.engine_torque,
            force: [0, 1].map(|i| (force[i] - start.force[i]) / step),
            t_brake: self.u_rate.brake_torque,
            phi: self.u_rate.grade,
        }
    }

    /// Change of the driveline's inputs for a change `du` of what the importer sets.
    pub(super) fn input_change(&self, du: &Inputs) -> InputRate {
        InputRate {
            t_e: du.engine_torque,
            force: [0, 1]
                .map(|i| self.p.clutch[i].force_rate(self.u.actuation(i), du.actuation(i))),
            t_brake: du.brake_torque,
            phi: du.grade,
        }
    }
}

/// F_n of both clutches [N].
#[inline(always)]
fn force(p: &Params, position: [f64; 2], pressure: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| {
        let actuation = Actuation {
            position: position[i],
            pressure: pressure[i],
        };
        p.clutch[i].force(actuation)
    })
}
