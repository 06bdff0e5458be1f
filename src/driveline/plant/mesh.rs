//! Gear meshes that lose power: which way they are loaded, which way they turn, and when they jam.
//!
//! With an efficiency η below 1 a shaft drives the output by i_f T_t η^s instead of i_f T_t (8), so that
//!
//! ```text
//! s = sgn(T_t ω_o),      power lost = i_f T_t ω_o (1 − η^s) = (1 − η) |i_f T_t ω_o|  driving,
//!                                                             (1/η − 1) |i_f T_t ω_o|  driven
//! ```
//!
//! While no sign changes the driveline stays linear, with other matrices for each s. The torque T_t passes
//! its zero with a bend. At ω_o = 0 it would jump, like friction: the output stands jammed while
//!
//! ```text
//! Σ i_f T_t η^sgn(T_t) + g σ T_s − T_o  ≤  0  ≤  Σ i_f T_t η^−sgn(T_t) + g σ T_s − T_o
//! ```
//!
//! turns forward above it and backward below. Both sides depend on the state alone, so a mesh is resolved before
//! brake and clutches. Zeros of T_t and ω_o and the ends of a jam are located like the events of a clutch.
//!
//! Deviation: the paper has no efficiency; η = 1 is what it has, and costs nothing.

use crate::Params;
use crate::plant::Plant;
use crate::plant::block::Block;
use crate::plant::brake::drive_shaft_torque;
use crate::plant::matrices::{O, State, System};
use crate::plant::modes::{Crossing, Event, Guard, Mode, ZERO_SLIP};
use crate::plant::springs::transfer_torques;

/// How the gears that are in are loaded and turn; nothing is of interest unless one of them loses power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Meshes {
    /// sgn T_t of the shafts whose gear loses power; otherwise, and while the output is jammed, open, shape (2).
    pub load: [Mode; 2],
    /// sgn ω_o; stuck: the output is jammed, open: no gear loses power.
    pub output: Mode,
}

impl Meshes {
    /// No gear loses power.
    pub const IDEAL: Self = Self {
        load: [Mode::Open; 2],
        output: Mode::Open,
    };

    /// s of both shafts, shape (2): 1 where a shaft drives the output, −1 where it is driven, 0 without loss.
    pub(crate) fn power(self) -> [i8; 2] {
        let sign = |mode: Mode| match mode {
            Mode::Forward => 1,
            Mode::Backward => -1,
            Mode::Open | Mode::Stuck => 0,
        };
        self.load.map(|load| sign(load) * sign(self.output))
    }
}

impl Params {
    /// η^s: what becomes of the torque with which a shaft drives the output [1].
    ///
    /// `power`: s, see [`crate::plant::mesh`].
    pub(crate) fn mesh_factor(&self, shaft: usize, gear: i32, power: i8) -> f64 {
        match power {
            0 => 1.0,
            1.. => self.efficiency(shaft, gear),
            _ => 1.0 / self.efficiency(shaft, gear),
        }
    }
}

impl Plant {
    /// Takes the modes of the meshes that are consistent after `event`; a jammed output stands exactly still.
    #[inline(always)]
    pub(crate) fn resolve_meshes(&mut self, p: &Params, event: &Event) {
        if self.meshes != Meshes::IDEAL || p.gears_lose_power() {
            self.choose_meshes(p, event);
        }
    }

    #[cold]
    #[inline(never)]
    fn choose_meshes(&mut self, p: &Params, event: &Event) {
        let gear = self.gear_in();
        let loses = [0, 1].map(|i| p.efficiency(i, gear[i]) < 1.0);
        if loses == [false; 2] || p.rigid {
            self.meshes = Meshes::IDEAL;
            return;
        }
        let standing = self.meshes.output == Mode::Stuck
            || event.output_reached
            || self.x[O].abs() <= ZERO_SLIP;
        if standing {
            self.work.viscous += 0.5 * p.j_o * self.x[O] * self.x[O];
            self.x[O] = 0.0;
        }
        let torque = transfer_torques(p, gear, &self.x);
        let [forward, backward] = self.urges(p, &self.x);
        let output = match (standing, forward > 0.0, backward < 0.0) {
            (false, ..) => Mode::slipping(self.x[O]),
            (true, true, _) => Mode::Forward,
            (true, false, true) => Mode::Backward,
            (true, false, false) => Mode::Stuck,
        };
        let load = [0, 1].map(|i| match output {
            Mode::Stuck => Mode::Open,
            _ if loses[i] => Mode::slipping(torque[i]),
            _ => Mode::Open,
        });
        self.meshes = Meshes { load, output };
    }

    /// Torque on the output while it turns forward and while it turns backward [N·m], shape (2).
    fn urges(&self, p: &Params, x: &State) -> [f64; 2] {
        let (gear, t_o) = (self.gear_in(), drive_shaft_torque(p, x));
        let (torque, g) = (transfer_torques(p, gear, x), p.g(self.gear));
        let rubs = self.synchroniser_torque(p);
        [1, -1].map(|turns: i8| {
            let of = |i: usize| {
                let power = if torque[i] < 0.0 { -turns } else { turns };
                p.i_f[i] * torque[i] * p.mesh_factor(i, gear[i], power) + g[i] * rubs[i]
            };
            of(0) + of(1) - t_o
        })
    }

    /// The urges of a jammed output, and their rates [N·m/s] with the state's rate.
    fn urge_rates(&self, p: &Params, x: &State, x_dot: &State) -> [f64; 2] {
        let (gear, t_o) = (self.gear_in(), drive_shaft_torque(p, x_dot));
        let sign = transfer_torques(p, gear, x);
        let rate = transfer_torques(p, gear, x_dot);
        [1, -1].map(|turns: i8| {
            let of = |i: usize| {
                let power = if sign[i] < 0.0 { -turns } else { turns };
                p.i_f[i] * rate[i] * p.mesh_factor(i, gear[i], power)
            };
            of(0) + of(1) - t_o
        })
    }

    /// Guards of the meshes: loads of both shafts, then the output's speed or both ends of its jam.
    fn mesh_guards(&self, p: &Params, x: &State, x_dot: &State) -> [Guard; 4] {
        let guard = |sign: f64, value: f64, rate: f64| Guard {
            value: sign * value,
            rate: sign * rate,
        };
        let gear = self.gear_in();
        let (torque, rate) = (
            transfer_torques(p, gear, x),
            transfer_torques(p, gear, x_dot),
        );
        let load = |i: usize| guard(self.meshes.load[i].direction(), torque[i], rate[i]);
        if self.meshes.output == Mode::Stuck {
            let (urge, rate) = (self.urges(p, x), self.urge_rates(p, x, x_dot));
            let ends = [guard(-1.0, urge[0], rate[0]), guard(1.0, urge[1], rate[1])];
            return [Guard::QUIET, Guard::QUIET, ends[0], ends[1]];
        }
        let turns = guard(self.meshes.output.direction(), x[O], x_dot[O]);
        [load(0), load(1), turns, Guard::QUIET]
    }
}

impl Block {
    /// The worst crossing of a guard of the meshes, and whether the output came to standstill.
    #[cold]
    #[inline(never)]
    pub(crate) fn mesh_crossing(
        &self,
        p: &Params,
        system: &System,
        plant: &Plant,
    ) -> (Crossing, bool) {
        let guards = |t: f64| {
            let (x, v) = self.at(t);
            plant.mesh_guards(p, &x, &system.derivative(&x, &v))
        };
        let (start, end) = (guards(0.0), guards(self.t));
        let crossing = [0, 1, 2, 3].map(|k| start[k].crossing(end[k], self.t));
        let worst = [Crossing::Found, Crossing::Possible]
            .into_iter()
            .find(|worst| crossing.contains(worst));
        let reached = crossing[2] == Crossing::Found && plant.meshes.output != Mode::Stuck;
        (worst.unwrap_or(Crossing::None), reached)
    }
}
