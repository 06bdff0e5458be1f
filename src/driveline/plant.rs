//! The plant (1)-(11): driveline with two clutches that stick and slip, stepped exactly.
//!
//! In: engine torque, normal forces of the clutches, brake torque, grade. Out: speeds, torques,
//! clutch states, energies. Between events the motion is exact but for T_v(ω_w), which is a ramp over
//! each block of time that meets (11) at both ends: second order; so does friction that varies with slip.
//! Lock-up, break-away, change of the sign of the slip and opening are located to h/4^6 and never smeared. Tests hold it
//! to an independent reference, with limits of 10⁻³ rad/s, 10⁻² N·m and 0.1 ms and an order of 1.9 to 2.1.
//!
//! # Method and order
//!
//! A block of length t is one product with exp(M t). The only thing that is approximated in it is what is not linear, a
//! torque τ(ω) that acts on an inertia J: it is replaced by the ramp through its values at both ends, the trapezoidal rule on
//! the exact flow. Over a block that leaves τ'' t³/(12 J) in the speed, over a run
//!
//! ```text
//! h²/12 · (τ'(end) − τ'(start))/J,
//! ```
//!
//! second order, with the constant 2.6 rad/s/s² on the launch of `tests/golden` (67 N·m/s² in T_o): 2.6·10⁻⁶ rad/s at 1 ms.
//! The load brakes, so the rule has no limit of stability; blocks are cut where friction answers to slip by more than a quarter.
//!
//! | source | error over a run |
//! | --- | --- |
//! | linear driveline, torques that are held or ramps | none but round-off: see [`integrate`] |
//! | T_v of (11) | as above, with h the step, or the blocks where it is cut |
//! | friction over slip | the same with blocks of at most 1 ms and h/4; a kink of the curve adds Δτ' t²/(8 J) once |
//! | force map with a moving actuator: straight to the force at the end of the step | h² between its points |
//! | instants of events | at most a tick, h/4096, always late: 0.24 µs at 1 ms |
//! | what the old modes do until an event is found | its lateness squared; of two clutches in the same tick, its lateness |
//! | inputs held over a step while they change | h, not of this method: `InputRate` has their slopes |
//!
//! Newton's method finds the ramp of the load; it stops when the correction of ω_w is below 10⁻⁸ rad/s, whose square is
//! what is left. Three steps at most: of 634 000 blocks by chance that needed a second one 338 took the third, and all settled.
//!
//! # Events
//!
//! Guards end a block; how they are located, and when they may be missed, stands in [`integrate`]. At an instant:
//!
//! - Everything found in the same tick happens at its end, together. Slips that came to 0 are removed by one impulse, which
//!   keeps momentum, then brake, meshes and clutches take modes: of all sets {stuck, forward, backward} at zero slip
//!   the consistent one, most clutches stuck first, of two the more loaded one slips. One that just broke away may not stick.
//!   If round-off leaves no set, clutches slip where the torque that would hold them points.
//! - What the new modes bring about in turn is found a tick later at the earliest. So an instant ends: a step has no more
//!   than 4096 events. It takes 32; after them its rest is smooth, and the next step begins with modes that are
//!   consistent. Seven were the most in 1.3 million steps by chance. A clutch does not chatter: its sliding motion at zero
//!   slip is a mode of its own.
//! - What the old modes did for the δ by which an event is late is undone to first order (`plant/late.rs`).
//!
//! An ordinary step asks none of this: `plant/quiet.rs` takes it at the top rung where both ends of each
//! guard are clear, and gives the same numbers to round-off.
//!
//! The plant carries no time. A step has 4096 ticks, counted; h k/4096 is one rounding. An hour of steps repeats to 10⁻⁹ s.
//!
//! [`integrate`]: crate::integrate
//!
//! ```
//! use dct_driveline::{Params, integrate::Propagators, plant::{Input, InputRate, Plant}};
//!
//! let p = Params::TABLE_1;
//! let input = Input { t_e: 60.0, force: [1500.0, 0.0], gear: [1, 2], ..Input::default() };
//! let mut propagators = Propagators::new(&p, input.gear, 1e-3);
//! let mut plant = Plant::start(&p, &input, 90.0, 0.0);
//! for _ in 0..100 {
//!     plant.step(&p, &mut propagators, &input, &InputRate::default());
//! }
//! let y = plant.outputs(&p, &propagators.systems, &input);
//! assert!(y.slip[0] < 90.0 && y.vehicle_speed > 0.0);
//! ```

mod block;
mod brake;
mod course;
mod friction;
mod gear;
mod late;
pub mod mesh;
mod mesh_rigid;
pub mod modes;
mod outputs;
mod ports;
mod quiet;
mod quiet_mesh;
mod search;
mod tangent;
mod tie;

use crate::Params;
use crate::integrate::{Ladders, Rung};
use crate::matrices::{C, D, E, O, STATES, State, Systems, Torques, W, slip};
use crate::plant::block::Block;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Event, Load, Mode, ZERO_SLIP, project, resolve, stuck_set};
pub use crate::plant::ports::{ClutchState, Input, InputRate, Output, Work};
use crate::road::Grade;
use crate::thermal::Thermal;

/// Everything a run carries from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    /// Speeds [rad/s] and twists [rad], shape (10); see [`crate::matrices`].
    pub x: State,
    /// Modes of the two clutches, shape (2).
    pub modes: [Mode; 2],
    /// Mode of the brake: it slides, or it holds the wheels.
    pub brake: Mode,
    /// Gears that are in or that shafts are synchronised to, shape (2); 0 is neutral.
    pub gear: [i32; 2],
    /// Modes of the synchronisers, shape (2): sgn(ω_ci − g_i ω_o) while a gear comes in, otherwise open.
    pub synchroniser: [Mode; 2],
    /// Loads and direction of gear meshes that lose power.
    pub meshes: Meshes,
    /// Temperatures of the clutches [K], shape (2).
    pub temperature: [f64; 2],
    /// Work since the start.
    pub work: Work,
    /// Energy stored at the start, and brought since then by the wheels of gears [J].
    pub stored_at_start: f64,
    /// The road at the start of the last step, so that what it is made of is not computed anew; no state, for one of
    /// another road, or of none, is.
    pub grade: Grade,
}

impl Plant {
    /// Nothing moves, the clutches are open, gears 1 and 2 are in.
    pub const AT_REST: Self = Self {
        x: State::from_array_storage(nalgebra::ArrayStorage([[0.0; STATES]])),
        modes: [Mode::Open; 2],
        brake: Mode::Open,
        gear: [1, 2],
        synchroniser: [Mode::Open; 2],
        meshes: Meshes::IDEAL,
        temperature: [Thermal::OFF.ambient; 2],
        work: Work {
            engine: 0.0,
            friction: [0.0; 2],
            viscous: 0.0,
            synchroniser: 0.0,
            load: 0.0,
            brake: 0.0,
        },
        stored_at_start: 0.0,
        grade: Grade::NONE,
    };

    /// The plant at the start of a run: ω_d = ω_e, ω_o = ω_w = V/r_w, ω_ci = g_i ω_o, twists 0; the gears
    /// preselected are in. A slip that is nothing but rounding is none: ω_d = ω_ci.
    ///
    /// `omega_e`: engine speed [rad/s]. `v`: vehicle speed [m/s].
    pub fn start(p: &Params, input: &Input, omega_e: f64, v: f64) -> Self {
        Self::start_with(p, &Systems::new(p, input.gear), input, omega_e, v)
    }

    /// Like [`Self::start`] with the matrices of the driveline at hand, its wheels free to turn.
    pub fn start_with(p: &Params, systems: &Systems, input: &Input, omega_e: f64, v: f64) -> Self {
        let omega_w = v / p.road.r_w;
        let g = p.g(input.gear);
        let mut x = State::zeros();
        (x[E], x[D], x[O], x[W]) = (omega_e, omega_e, omega_w, omega_w);
        (x[C], x[C + 1]) = (g[0] * omega_w, g[1] * omega_w);
        for i in [0, 1] {
            if slip(&x)[i].abs() <= ZERO_SLIP {
                x[D] = x[C + i]; // so that nothing is left for a clutch to take away: speeds start from these numbers alone
            }
        }
        let mut plant = Self {
            x,
            gear: input.gear,
            temperature: [0, 1].map(|i| p.clutch[i].thermal.at_start()),
            stored_at_start: systems.stored_energy(&x),
            grade: Grade::NONE.at(p, input.phi),
            ..Self::AT_REST
        };
        let mut place = None;
        let p = p.with_static_friction(&mut place, plant.temperature);
        let (held, none) = (InputRate::default(), Event::default());
        plant.resolve_meshes(p, &none);
        plant.resolve_brake(p, input, &held, &none);
        plant.resolve(p, systems, input, &held, &none);
        if plant.has_rigid_meshes(p) {
            plant.guess_rigid_meshes(p, systems, input);
        }
        plant
    }

    /// Advances the plant by the communication step of `ladders`.
    ///
    /// `input`: inputs at the start of the step. `rate`: their derivatives over it.
    pub fn step(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
    ) {
        self.step_observed(p, ladders, input, rate, |_, _, _| {});
    }

    /// Like [`Self::step`], and reports every instant at which clutches, brake, synchronisers or the
    /// output change their modes.
    ///
    /// `report`: called with the time since the start of the step [s] and [`Self::all_modes`] before
    /// and after.
    pub fn step_observed(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
        mut report: impl FnMut(f64, [Mode; 6], [Mode; 6]),
    ) {
        if !rate.is_held() || self.step_plainly(p, ladders, input).is_none() {
            self.step_in_blocks(p, ladders, input, rate, &mut report);
        }
    }

    /// ω_d − ω_ci [rad/s], shape (2); exactly 0 in an engaged clutch.
    pub fn slip(&self) -> [f64; 2] {
        let slip = slip(&self.x);
        [0, 1].map(|i| {
            if self.modes[i] == Mode::Stuck {
                0.0
            } else {
                slip[i]
            }
        })
    }

    /// Work in − stored − lost since the start [J].
    pub fn energy_residual(&self, systems: &Systems) -> f64 {
        let Work {
            engine,
            friction: [one, two],
            viscous,
            synchroniser,
            load,
            brake,
        } = self.work;
        let stored = systems.stored_energy(&self.x) - self.stored_at_start;
        engine - stored - one - two - viscous - synchroniser - load - brake
    }

    /// Takes the modes of meshes, brake and clutches that are consistent after `event`.
    fn resolve_all(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
        event: &Event,
    ) {
        if self.has_rigid_meshes(p) {
            self.resolve_rigid(p, ladders, input, rate, event);
            return;
        }
        self.resolve_meshes(p, event);
        self.resolve_brake(p, input, rate, event);
        let systems = &ladders.of(p, self.coupling()).systems;
        self.resolve(p, systems, input, rate, event);
    }

    /// Takes the modes that are consistent after `event` and removes the slip of engaged clutches.
    fn resolve(
        &mut self,
        p: &Params,
        systems: &Systems,
        input: &Input,
        rate: &InputRate,
        event: &Event,
    ) {
        if event.is_none() && self.stands(input, rate) {
            return;
        }
        if event.reached != [false; 2] {
            let (before, reached) = (
                systems.stored_energy(&self.x),
                event.reached.map(usize::from),
            );
            let set = stuck_set(self.modes) | reached[0] | reached[1] << 1;
            project(systems, set, &mut self.x);
            self.work.viscous += before - systems.stored_energy(&self.x); // its impulse goes through the meshes
        }
        let pressed =
            [0, 1].map(|i| input.force[i] > 0.0 || !event.opened[i] && rate.force[i] > 0.0);
        self.grade.become_of(p, input.phi);
        let (t_v, _) = input.load_torque(p, &self.grade, self.x[W], self.brake.direction());
        let load = Load::new(
            p,
            self.with_synchronisers(p, Torques::from([input.t_e, 0.0, 0.0, t_v])),
            input.force,
            self.friction_factor(p),
            pressed,
        );
        self.modes = resolve(systems, &self.x, &load, self.modes, event);
        project(systems, stuck_set(self.modes), &mut self.x);
    }

    /// Whether both clutches are open or slip for certain, so that no other modes can come.
    fn stands(&self, input: &Input, rate: &InputRate) -> bool {
        let slip = slip(&self.x);
        [0, 1].into_iter().all(|i| match self.modes[i] {
            Mode::Open => input.force[i] <= 0.0 && rate.force[i] <= 0.0,
            Mode::Stuck => false,
            sliding => input.force[i] > 0.0 && sliding.direction() * slip[i] > ZERO_SLIP,
        })
    }

    /// Moves to the end of a block and books its work.
    fn accept(&mut self, p: &Params, systems: &Systems, rung: &Rung, block: &Block) {
        let before = self.work.friction;
        self.book(&rung.work(&block.start, &block.motion));
        self.work.viscous += rung.viscous_loss(&block.start);
        if self.brake.direction() != 0.0 {
            let lost = self.brake.direction() * block.brake_work();
            self.work.load -= lost;
            self.work.brake += lost;
        }
        if p.friction_varies() {
            self.warm(p, before, rung.t);
        }
        self.x = block.x_end;
        self.hold_ratios(systems.rigid_ratio);
        project(systems, stuck_set(self.modes), &mut self.x);
    }
}
