//! The plant (1)-(11): driveline with two clutches that stick and slip, stepped exactly.
//!
//! In: engine torque, normal forces of the clutches, brake torque, grade. Out: speeds, torques,
//! clutch states, energies. Between events the motion is exact but for T_v(ω_w), which is a ramp over
//! each block of time that meets (11) at both ends: second order. Lock-up, break-away, change of the
//! sign of the slip and opening are located to h/2^12 and never smeared.
//!
//! ```
//! use dct_driveline::{Params, integrate::Propagators, plant::{Input, InputRate, Plant}};
//!
//! let p = Params::TABLE_1;
//! let input = Input { t_e: 60.0, force: [1500.0, 0.0], gear: [1, 2], ..Input::default() };
//! let propagators = Propagators::new(&p, input.gear, 1e-3);
//! let mut plant = Plant::start(&p, &input, 90.0, 0.0);
//! for _ in 0..100 {
//!     plant.step(&p, &propagators, &input, &InputRate::default());
//! }
//! let y = plant.outputs(&p, &propagators.systems, &input);
//! assert!(y.slip[0] < 90.0 && y.vehicle_speed > 0.0);
//! ```

use crate::Params;
use crate::integrate::{Augmented, LADDER, Propagators, Rung, TICKS};
use crate::plant_matrices::{C, D, E, O, STATES, State, Systems, TORQUES, Torques, W, slip};
use crate::plant_modes::{Crossing, Event, Guard, Load, Mode, project, resolve, stuck_set};

/// Events one step may hold; beyond them its rest is one smooth piece.
const MAX_EVENTS: u32 = 32;
/// Newton steps on the load at the end of a block; each squares the error left.
const LOAD_ITERATIONS: u32 = 3;

/// Inputs of the plant at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Input {
    /// T_e: engine torque [N·m].
    pub t_e: f64,
    /// F_n of both clutches [N], shape (2), ≥ 0.
    pub force: [f64; 2],
    /// Gears preselected on the odd and on the even shaft, shape (2); 0 is neutral.
    pub gear: [i32; 2],
    /// Brake torque at the wheels [N·m], ≥ 0; acts against the motion.
    pub t_brake: f64,
    /// φ: road grade [rad].
    pub phi: f64,
}

/// Time derivatives of the inputs; all zero where inputs are held over a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InputRate {
    /// Rate of the engine torque [N·m/s].
    pub t_e: f64,
    /// Rates of the normal forces [N/s], shape (2).
    pub force: [f64; 2],
    /// Rate of the brake torque [N·m/s].
    pub t_brake: f64,
    /// Rate of the grade [rad/s].
    pub phi: f64,
}

impl Input {
    /// The inputs `t` [s] later; forces and brake do not fall below zero.
    pub fn after(&self, rate: &InputRate, t: f64) -> Self {
        Self {
            t_e: self.t_e + rate.t_e * t,
            force: [0, 1].map(|i| (self.force[i] + rate.force[i] * t).max(0.0)),
            gear: self.gear,
            t_brake: (self.t_brake + rate.t_brake * t).max(0.0),
            phi: self.phi + rate.phi * t,
        }
    }

    /// T_v of (11) with the brake [N·m].
    fn load_torque(&self, p: &Params, omega_w: f64) -> f64 {
        p.road.load_torque(omega_w, self.phi) + self.t_brake * p.road.direction(omega_w)
    }

    /// ∂T_v/∂ω_w [N·m·s/rad].
    fn load_slope(&self, p: &Params, omega_w: f64) -> f64 {
        p.road.load_torque_slope(omega_w, self.phi) + self.t_brake * p.road.direction_slope(omega_w)
    }
}

/// Work done since the start of a run [J].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Work {
    /// By the engine.
    pub engine: f64,
    /// Lost in the clutches, shape (2).
    pub friction: [f64; 2],
    /// Lost in dampers and shafts.
    pub viscous: f64,
    /// Done against road load and brake.
    pub load: f64,
}

/// Everything a run carries from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plant {
    /// Speeds [rad/s] and twists [rad], shape (10); see [`crate::plant_matrices`].
    pub x: State,
    /// Modes of the two clutches, shape (2).
    pub modes: [Mode; 2],
    /// Work since the start.
    pub work: Work,
    /// Energy stored at the start [J].
    pub stored_at_start: f64,
}

/// State of a clutch as users see it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClutchState {
    /// No normal force.
    Disengaged = 1,
    /// Normal force and slip.
    Slipping = 2,
    /// Normal force and no slip.
    Engaged = 3,
}

impl From<Mode> for ClutchState {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Open => Self::Disengaged,
            Mode::Forward | Mode::Backward => Self::Slipping,
            Mode::Stuck => Self::Engaged,
        }
    }
}

/// Outputs of the plant at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// ω_e [rad/s].
    pub omega_e: f64,
    /// ω_d [rad/s].
    pub omega_d: f64,
    /// ω_c1, ω_c2 [rad/s], shape (2).
    pub omega_c: [f64; 2],
    /// ω_o [rad/s].
    pub omega_o: f64,
    /// ω_w [rad/s].
    pub omega_w: f64,
    /// V = r_w ω_w [m/s].
    pub vehicle_speed: f64,
    /// dV/dt [m/s²].
    pub vehicle_acceleration: f64,
    /// T_d of (3) [N·m].
    pub t_d: f64,
    /// T_c1, T_c2 [N·m], shape (2); positive when the engine drives the gearbox.
    pub t_c: [f64; 2],
    /// T_t1, T_t2 [N·m], shape (2).
    pub t_t: [f64; 2],
    /// T_o of (10) [N·m].
    pub t_o: f64,
    /// T_v of (11) with the brake [N·m]; positive when it brakes forward motion.
    pub t_v: f64,
    /// ω_d − ω_ci [rad/s], shape (2); 0 in an engaged clutch.
    pub slip: [f64; 2],
    /// States of the clutches, shape (2).
    pub state: [ClutchState; 2],
    /// Friction power [W], shape (2), ≥ 0.
    pub friction_power: [f64; 2],
    /// Friction energy since the start [J], shape (2).
    pub friction_energy: [f64; 2],
    /// Energy balance since the start: work in − stored − lost [J]; 0 but for round-off.
    pub energy_residual: f64,
}

impl Plant {
    /// The plant at the start of a run: ω_d = ω_e, ω_o = ω_w = V/r_w, ω_ci = g_i ω_o, twists 0.
    ///
    /// `omega_e`: engine speed [rad/s]. `v`: vehicle speed [m/s].
    pub fn start(p: &Params, input: &Input, omega_e: f64, v: f64) -> Self {
        let systems = Systems::new(p, input.gear);
        let omega_w = v / p.road.r_w;
        let g = p.g(input.gear);
        let mut x = State::zeros();
        (x[E], x[D], x[O], x[W]) = (omega_e, omega_e, omega_w, omega_w);
        (x[C], x[C + 1]) = (g[0] * omega_w, g[1] * omega_w);
        let mut plant = Self {
            x,
            modes: [Mode::Open; 2],
            work: Work::default(),
            stored_at_start: systems.stored_energy(&x),
        };
        plant.resolve(p, &systems, input, &InputRate::default(), &Event::default());
        plant
    }

    /// Advances the plant by one communication step `propagators.h`.
    ///
    /// `input`: inputs at the start of the step. `rate`: their derivatives over it.
    pub fn step(&mut self, p: &Params, propagators: &Propagators, input: &Input, rate: &InputRate) {
        self.step_observed(p, propagators, input, rate, |_, _, _| {});
    }

    /// Like [`Self::step`], and reports every instant at which clutches change their modes.
    ///
    /// `report`: called with the time since the start of the step [s], the modes before and after.
    pub fn step_observed(
        &mut self,
        p: &Params,
        propagators: &Propagators,
        input: &Input,
        rate: &InputRate,
        mut report: impl FnMut(f64, [Mode; 2], [Mode; 2]),
    ) {
        let (mut now, mut rate) = (input.after(rate, 0.0), *rate);
        let (mut done, mut piece, mut events) = (0, 0, 0);
        let mut cap = LADDER;
        let before = self.modes;
        self.resolve(p, &propagators.systems, &now, &rate, &Event::default());
        report(0.0, before, self.modes);
        while done < TICKS {
            let level = level(done - piece, TICKS - done).min(cap);
            let rung = propagators.rung(stuck_set(self.modes), level);
            let block = Block::new(p, self, rung, &now, &rate);
            let (crossing, event) = block.events(p, &propagators.systems, self.modes);
            if crossing != Crossing::None && level > 0 && events < MAX_EVENTS {
                cap = level - 1;
                continue;
            }
            self.accept(&propagators.systems, rung, &block);
            (now, cap, done) = (block.input_end, LADDER, done + (1 << level));
            if !event.is_none() && events < MAX_EVENTS {
                for i in (0..2).filter(|i| event.opened[*i]) {
                    (now.force[i], rate.force[i]) = (0.0, 0.0);
                }
                let before = self.modes;
                self.resolve(p, &propagators.systems, &now, &rate, &event);
                report(
                    propagators.h * f64::from(done) / f64::from(TICKS),
                    before,
                    self.modes,
                );
                (piece, events) = (done, events + 1);
            }
        }
    }

    /// Outputs at the present instant with the inputs that act at it.
    pub fn outputs(&self, p: &Params, systems: &Systems, input: &Input) -> Output {
        let x = &self.x;
        let t_v = input.load_torque(p, x[W]);
        let v = torques(p, self.modes, input.t_e, input.force, t_v);
        let system = &systems.by_stuck[stuck_set(self.modes)];
        let x_dot = system.derivative(x, &v);
        let t_c = system.clutch_torque(x, &v);
        let slip = self.slip();
        let [t_d, mut t_t @ .., t_o]: [f64; 4] = (systems.spring_torque * x).into();
        for i in (0..2).filter(|i| systems.rigid_ratio[*i] != 0.0) {
            t_t[i] = p.i_t(i, systems.gear[i]) * (t_c[i] - p.j_ct[i] * x_dot[C + i]);
        }
        Output {
            omega_e: x[E],
            omega_d: x[D],
            omega_c: [x[C], x[C + 1]],
            omega_o: x[O],
            omega_w: x[W],
            vehicle_speed: p.road.r_w * x[W],
            vehicle_acceleration: p.road.r_w * x_dot[W],
            t_d,
            t_c,
            t_t,
            t_o,
            t_v,
            slip,
            state: self.modes.map(ClutchState::from),
            friction_power: [t_c[0] * slip[0], t_c[1] * slip[1]],
            friction_energy: self.work.friction,
            energy_residual: self.energy_residual(systems),
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
            load,
        } = self.work;
        let stored = systems.stored_energy(&self.x) - self.stored_at_start;
        engine - stored - one - two - viscous - load
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
        if event.reached != [false; 2] {
            let reached = event.reached.map(usize::from);
            project(
                systems,
                stuck_set(self.modes) | reached[0] | reached[1] << 1,
                &mut self.x,
            );
        }
        let pressed =
            [0, 1].map(|i| input.force[i] > 0.0 || !event.opened[i] && rate.force[i] > 0.0);
        let t_v = input.load_torque(p, self.x[W]);
        let load = Load::new(
            p,
            Torques::from([input.t_e, 0.0, 0.0, t_v]),
            input.force,
            pressed,
        );
        self.modes = resolve(systems, &self.x, &load, self.modes, event);
        project(systems, stuck_set(self.modes), &mut self.x);
    }

    /// Moves to the end of a block and books its work.
    fn accept(&mut self, systems: &Systems, rung: &Rung, block: &Block) {
        let work = rung.work(&block.z);
        self.work.engine += work[0];
        self.work.friction[0] += work[1];
        self.work.friction[1] += work[2];
        self.work.load += work[3];
        self.work.viscous += rung.viscous_loss(&block.z);
        self.x = block.x_end;
        for (i, ratio) in systems.rigid_ratio.into_iter().enumerate() {
            if ratio != 0.0 {
                self.x[C + i] = ratio * self.x[O];
            }
        }
        project(systems, stuck_set(self.modes), &mut self.x);
    }
}

/// Level of the longest block that starts `offset` ticks into a piece and fits into `rest` ticks.
fn level(offset: u32, rest: u32) -> usize {
    let aligned = if offset == 0 {
        u32::BITS
    } else {
        offset.trailing_zeros()
    };
    aligned.min(rest.ilog2()) as usize
}

/// v with friction torques in slipping clutches, shape (4).
fn torques(p: &Params, modes: [Mode; 2], t_e: f64, force: [f64; 2], t_v: f64) -> Torques {
    let friction =
        |i: usize| modes[i].direction() * p.clutch[i].mu_k * force[i] * p.clutch[i].r_c_n;
    Torques::from([t_e, friction(0), friction(1), t_v])
}

/// A stretch of time without events, from z(0) to its end.
struct Block {
    t: f64,
    z: Augmented,
    x_end: State,
    input: Input,
    input_end: Input,
    rate: InputRate,
}

impl Block {
    fn new(p: &Params, plant: &Plant, rung: &Rung, input: &Input, rate: &InputRate) -> Self {
        let input_end = input.after(rate, rung.t);
        let t_v = input.load_torque(p, plant.x[W]);
        let v = torques(p, plant.modes, input.t_e, input.force, t_v);
        let v_dot = torques(p, plant.modes, rate.t_e, rate.force, 0.0);
        let mut z = Augmented::zeros();
        z.fixed_rows_mut::<STATES>(0).copy_from(&plant.x);
        z.fixed_rows_mut::<TORQUES>(STATES).copy_from(&v);
        z.fixed_rows_mut::<TORQUES>(STATES + TORQUES)
            .copy_from(&v_dot);
        z[STATES + 2 * TORQUES - 1] = load_ramp(p, rung, &z, &input_end);
        Self {
            t: rung.t,
            z,
            x_end: rung.end(&z),
            input: *input,
            input_end,
            rate: *rate,
        }
    }

    /// The worst crossing of any guard in the block, and the events found at its end.
    fn events(&self, p: &Params, systems: &Systems, modes: [Mode; 2]) -> (Crossing, Event) {
        let mut worst = Crossing::None;
        let mut event = Event::default();
        let start = self.guards(p, systems, modes, 0.0);
        let end = self.guards(p, systems, modes, self.t);
        for i in [0, 1] {
            let crossing = [0, 1].map(|k| start[i][k].crossing(end[i][k], self.t));
            let found = crossing.map(|crossing| crossing == Crossing::Found);
            if crossing.contains(&Crossing::Possible) && worst == Crossing::None {
                worst = Crossing::Possible;
            }
            if found != [false; 2] {
                worst = Crossing::Found;
            }
            event.reached[i] = found[0] && modes[i] != Mode::Stuck;
            event.broken[i] = (found[0] || found[1]) && modes[i] == Mode::Stuck;
            event.opened[i] = found[1] && modes[i] != Mode::Stuck;
        }
        (worst, event)
    }

    /// Guards of both clutches at `t` = 0 or at the end of the block, shape (2, 2).
    ///
    /// Slipping: slip in its direction, normal force. Stuck: capacity left forward and backward.
    fn guards(&self, p: &Params, systems: &Systems, modes: [Mode; 2], t: f64) -> [[Guard; 2]; 2] {
        let system = &systems.by_stuck[stuck_set(modes)];
        let v_dot: Torques = self.z.fixed_rows::<TORQUES>(STATES + TORQUES).into_owned();
        let v: Torques = self.z.fixed_rows::<TORQUES>(STATES) + v_dot * t;
        let x: State = if t > 0.0 {
            self.x_end
        } else {
            self.z.fixed_rows::<STATES>(0).into_owned()
        };
        let x_dot = system.derivative(&x, &v);
        let (slip, slip_dot) = (slip(&x), slip(&x_dot));
        let (torque, torque_dot) = (
            system.clutch_torque(&x, &v),
            system.clutch_torque(&x_dot, &v_dot),
        );
        [0, 1].map(|i| {
            let (force, force_dot) = (
                self.input.force[i] + self.rate.force[i] * t,
                self.rate.force[i],
            );
            let sign = modes[i].direction();
            let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n;
            let (peak, peak_dot) = (reach * force, reach * force_dot);
            match modes[i] {
                Mode::Open => {
                    [Guard {
                        value: 0.0,
                        rate: 0.0,
                    }; 2]
                }
                Mode::Forward | Mode::Backward => [
                    Guard {
                        value: sign * slip[i],
                        rate: sign * slip_dot[i],
                    },
                    Guard {
                        value: force,
                        rate: force_dot,
                    },
                ],
                Mode::Stuck => [
                    Guard {
                        value: peak - torque[i],
                        rate: peak_dot - torque_dot[i],
                    },
                    Guard {
                        value: peak + torque[i],
                        rate: peak_dot + torque_dot[i],
                    },
                ],
            }
        })
    }
}

/// Ramp of T_v [N·m/s] that meets (11) at the end of the rung, by Newton's method.
fn load_ramp(p: &Params, rung: &Rung, z: &Augmented, input_end: &Input) -> f64 {
    let t_v = z[STATES + TORQUES - 1];
    let held = rung.wheel_speed(z);
    let gain = rung.wheel_speed_by_load_ramp();
    let mut ramp = 0.0;
    for _ in 0..LOAD_ITERATIONS {
        let omega_w = held + gain * ramp;
        let miss = input_end.load_torque(p, omega_w) - t_v - ramp * rung.t;
        ramp -= miss / (input_end.load_slope(p, omega_w) * gain - rung.t);
    }
    ramp
}
