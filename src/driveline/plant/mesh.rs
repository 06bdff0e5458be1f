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
//! turns forward above it and backward below. Behind compliant shafts both sides depend on the state alone, so a mesh is
//! resolved before brake and clutches; with rigid ones `plant/mesh_rigid.rs` resolves all of them together. Zeros of T_t and ω_o and the ends of a jam are located like the events of a clutch.
//!
//! Deviation: the paper has no efficiency; η = 1 is what it has, and costs nothing.

use crate::Params;
use crate::matrices::springs::{drive_shaft_torque, transfer_torques};
use crate::matrices::{C, O, State, System, Torques, rigid_ratio};
use crate::plant::Plant;
use crate::plant::modes::{Event, Guard, Mode, ZERO_SLIP};

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

    /// The output stands in gears that lose power.
    pub const JAMMED: Self = Self {
        load: [Mode::Open; 2],
        output: Mode::Stuck,
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
        let loses = p.gears_that_lose(self.gear_in());
        if loses == [false; 2] || p.rigid {
            self.meshes = Meshes::IDEAL;
            return;
        }
        let standing = self.output_stands(event);
        if standing {
            self.stop_output(p);
        }
        let torque = transfer_torques(p, self.gear_in(), &self.x);
        let torque = [0, 1].map(|i| p.i_f[i] * torque[i]);
        let [forward, backward] = self.urges(p, &self.x, torque);
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

    /// Whether the output stands, and might jam, after `event`.
    pub(crate) fn output_stands(&self, event: &Event) -> bool {
        let speed = self.x[O].abs();
        self.meshes.output == Mode::Stuck || event.output_reached || speed <= ZERO_SLIP
    }

    /// Takes from the output, and from shafts that follow it, what speed it has left.
    pub(crate) fn stop_output(&mut self, p: &Params) {
        let (gear, mut inertia) = (self.gear_in(), p.j_o);
        let (g, j_ct) = (rigid_ratio(p, self.coupling()), p.j_ct_in(gear));
        for i in (0..2).filter(|i| g[*i] != 0.0) {
            (inertia, self.x[C + i]) = (inertia + g[i] * g[i] * j_ct[i], 0.0);
        }
        self.work.viscous += 0.5 * inertia * self.x[O] * self.x[O];
        self.x[O] = 0.0;
    }

    /// Torque on the output while it turns forward and while it turns backward [N·m], shape (2).
    ///
    /// `torque`: i_f T_t [N·m], shape (2).
    pub(crate) fn urges(&self, p: &Params, x: &State, torque: [f64; 2]) -> [f64; 2] {
        let (g, rubs) = (p.g(self.gear), self.synchroniser_torque(p));
        let rest = g[0] * rubs[0] + g[1] * rubs[1] - drive_shaft_torque(p, x);
        self.passed_on(p, torque, torque)
            .map(|passed| passed + rest)
    }

    /// What the gears pass on of torques with these signs, the output turning forward and backward [N·m], shape (2).
    fn passed_on(&self, p: &Params, sign: [f64; 2], torque: [f64; 2]) -> [f64; 2] {
        let gear = self.gear_in();
        [1, -1].map(|turns: i8| {
            let of = |i: usize| {
                let power = if sign[i] < 0.0 { -turns } else { turns };
                torque[i] * p.mesh_factor(i, gear[i], power)
            };
            of(0) + of(1)
        })
    }

    /// Guards of the meshes: loads of both shafts, then the output's speed or both ends of its jam.
    ///
    /// `x`, `v`: state and torques. `rate`: their rates.
    pub(crate) fn mesh_guards(
        &self,
        p: &Params,
        system: &System,
        (x, v): (&State, &Torques),
        rate: (&State, &Torques),
    ) -> [Guard; 4] {
        let guard = |sign: f64, value: f64, rate: f64| Guard {
            value: sign * value,
            rate: sign * rate,
        };
        let torque = system.rows.mesh.map(|row| row.of(x, v));
        let torque_rate = system.rows.mesh.map(|row| row.of(rate.0, rate.1));
        let load = |i: usize| guard(self.meshes.load[i].direction(), torque[i], torque_rate[i]);
        if self.meshes.output != Mode::Stuck {
            let turns = guard(self.meshes.output.direction(), x[O], rate.0[O]);
            return [load(0), load(1), turns, Guard::QUIET];
        }
        if self.is_tied(p) {
            return [Guard::QUIET; 4];
        }
        let urge = self.urges(p, x, torque);
        let urge_rate = self.passed_on(p, torque, torque_rate);
        let end = |sign: f64, k: usize| {
            let rate = urge_rate[k] - drive_shaft_torque(p, rate.0);
            guard(sign, urge[k], rate)
        };
        [Guard::QUIET, Guard::QUIET, end(-1.0, 0), end(1.0, 1)]
    }
}
