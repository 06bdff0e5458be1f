//! One block of the plant's motion: ramps of the torques over it, and the guards at its ends.
//!
//! What may end a smooth stretch is a guard: a value that has to stay ≥ 0, with its rate (slip in the
//! direction of sliding, capacity left on either side, normal force, wheel speed under the brake, what a
//! synchroniser has left to do). A block is tried at the longest level. If a guard is below −10⁻¹⁰ at its
//! end, or if the tangents at both ends meet below zero, so that the guard may have dipped and returned, the
//! block is given up and shorter ones are tried (`plant/search.rs`); at one tick it is taken, and the event happens at its
//! end. [`integrate`](crate::integrate) says when the tangents bound every dip.
//!
//! What an event finds is at most a tick old: a slip of one tick of relative acceleration, removed by an
//! impulse that keeps momentum; a torque above its capacity by one tick of its rate. After the event
//! [`resolve`](crate::plant::modes::resolve) takes the modes that are consistent.

use crate::Params;
use crate::integrate::{Motion, Rung, Start};
use crate::matrices::{Rows, State, System, Systems, TORQUES, Torques, W, slip};
use crate::plant::Plant;
use crate::plant::brake;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Crossing, Event, Guard, Mode, stuck_set};
use crate::plant::ports::{Input, InputRate};
use crate::plant::tie::share_guards;
use crate::road::{Grade, LOAD_SETTLED};

/// Index of T_v among the torques.
pub(crate) const LOAD: usize = TORQUES - 1;
/// Index of the brake among guards.
const BRAKE: usize = 2;
/// Newton steps on the load at the end of a block; each squares the error left.
const LOAD_ITERATIONS: u32 = 3;

/// v with friction torques in slipping clutches, shape (4).
///
/// `factor`: what becomes of μ_k [1], shape (2).
#[inline(always)]
pub(crate) fn torques(
    p: &Params,
    modes: [Mode; 2],
    factor: [f64; 2],
    t_e: f64,
    force: [f64; 2],
    t_v: f64,
) -> Torques {
    let friction = |i: usize| {
        modes[i].direction() * p.clutch[i].mu_k * force[i] * p.clutch[i].r_c_n * factor[i]
    };
    Torques::from([t_e, friction(0), friction(1), t_v])
}

/// A stretch of time without events, from its start to its end.
pub(crate) struct Block {
    pub(crate) t: f64,
    pub(crate) start: Start,
    pub(crate) motion: Motion,
    pub(crate) x_end: State,
    pub(crate) input: Input,
    pub(crate) input_end: Input,
    rate: InputRate,
    pub(crate) grade_end: Grade,
}

impl Block {
    /// The block over a rung, with the ramp of the load that meets (11) at its end.
    pub(crate) fn new(
        p: &Params,
        plant: &Plant,
        rung: &Rung,
        input: &Input,
        rate: &InputRate,
    ) -> Self {
        let mut block = Self::begin(p, plant, rung, input, rate, [1.0; 2]);
        let direction = plant.brake.direction();
        let ramp = load_ramp(
            rung,
            (block.start.torque(LOAD), 0.0),
            block.motion.wheel_speed_change(),
            |change| {
                let (grade, omega_w) = (&block.grade_end, block.start.x[W] + change);
                block.input_end.load_torque(p, grade, omega_w, direction)
            },
        );
        block.add_ramp(rung, LOAD, ramp);
        block
    }

    /// The block over a rung with a load that stays as it is.
    ///
    /// `factor`: what becomes of μ_k [1], shape (2).
    #[inline(always)]
    pub(crate) fn begin(
        p: &Params,
        plant: &Plant,
        rung: &Rung,
        input: &Input,
        rate: &InputRate,
        factor: [f64; 2],
    ) -> Self {
        let input_end = input.after(rate, rung.t);
        let mut grade = plant.grade.at(p, input.phi);
        let (t_v, _) = input.load_torque(p, &grade, plant.x[W], plant.brake.direction());
        let v = torques(p, plant.modes, factor, input.t_e, input.force, t_v);
        let v = plant.with_synchronisers(p, v);
        let v_dot = torques(p, plant.modes, factor, rate.t_e, rate.force, 0.0);
        let start = rung.start(&plant.x, &v, &v_dot);
        let motion = rung.motion(&start);
        grade.become_of(p, input_end.phi);
        Self {
            t: rung.t,
            start,
            motion,
            x_end: plant.x,
            input: *input,
            input_end,
            rate: *rate,
            grade_end: grade,
        }
    }

    /// Adds a ramp [N·m/s] to torque `q` of T_e, T_c1, T_c2, T_v.
    pub(crate) fn add_ramp(&mut self, rung: &Rung, q: usize, ramp: f64) {
        rung.add_ramp(&mut self.motion, q, ramp);
        self.start.add_ramp(q, ramp);
        self.x_end = self.motion.end(&self.start.x);
    }

    /// Work of a brake that slides forward all over the block [J].
    pub(crate) fn brake_work(&self) -> f64 {
        let [angle, moment] = self.motion.wheel_angles();
        let (start, end) = (self.input.t_brake, self.input_end.t_brake);
        start * angle + (end - start) / self.t * moment
    }

    /// Whether a quick look proves that no guard is crossed; [`Self::events`] looks closely.
    ///
    /// A guard whose rate has one sign at both ends does not dip between them.
    pub(crate) fn is_quiet(&self, p: &Params, rows: &Rows, plant: &Plant) -> bool {
        let (x, v) = (self.start.x, self.torques(0.0));
        let v_end = self.torques(self.t);
        plant.brake == Mode::Open
            && [0, 1].into_iter().all(|i| match plant.modes[i] {
                Mode::Open => plant.synchroniser[i] == Mode::Open,
                Mode::Stuck => {
                    let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n * self.input.force[i];
                    let torque = rows.torque[i].of(&self.x_end, &v_end);
                    let ramp = rows.torque[i].of_torques(&self.torques_rate());
                    let rate = rows.torque_rate[i].of(&x, &v) + ramp;
                    let rate_end = rows.torque_rate[i].of(&self.x_end, &v_end) + ramp;
                    self.rate.force[i] == 0.0 && torque.abs() < reach && rate * rate_end >= 0.0
                }
                sliding => {
                    let direction = sliding.direction();
                    let rate = |x, v| direction * rows.slip_rate[i].of(x, v);
                    direction * slip(&self.x_end)[i] >= 0.0
                        && self.rate.force[i] >= 0.0
                        && (rate(&x, &v) >= 0.0 || rate(&self.x_end, &v_end) <= 0.0)
                }
            })
    }

    /// What [`Self::events`] finds, after a quick look, or a close one.
    #[inline(always)]
    pub(crate) fn look(
        &self,
        p: &Params,
        systems: &Systems,
        plant: &Plant,
    ) -> (Crossing, Event, Option<f64>) {
        let rows = &systems.by_stuck[stuck_set(plant.modes)].rows;
        if self.is_quiet(p, rows, plant) && plant.meshes == Meshes::IDEAL {
            (Crossing::None, Event::default(), None)
        } else {
            self.events(p, systems, plant)
        }
    }

    /// State and torques at `t` = 0 or at the end [s].
    pub(crate) fn at(&self, t: f64) -> (State, Torques) {
        let x = if t > 0.0 { self.x_end } else { self.start.x };
        (x, self.torques(t))
    }

    /// v at `t` [s] after the start, shape (4).
    fn torques(&self, t: f64) -> Torques {
        Torques::from([0, 1, 2, 3].map(|q| self.start.torque(q) + self.start.ramp(q) * t))
    }

    /// v' over the block, shape (4).
    pub(crate) fn torques_rate(&self) -> Torques {
        Torques::from([0, 1, 2, 3].map(|q| self.start.ramp(q)))
    }

    /// The worst crossing of any guard in the block, the events found at its end, and what share of it is over when
    /// the first of clutches and brake happens, if there is one.
    pub(crate) fn events(
        &self,
        p: &Params,
        systems: &Systems,
        plant: &Plant,
    ) -> (Crossing, Event, Option<f64>) {
        let (mut worst, mut first) = (Crossing::None, None);
        let mut event = Event::default();
        let mut start = self.guards(p, systems, plant, 0.0);
        let mut end = self.guards(p, systems, plant, self.t);
        if plant.is_strained(p) {
            share_guards(&mut start, &mut end);
        }
        for i in [0, 1, 2] {
            let crossing = [0, 1].map(|k| start[i][k].crossing(end[i][k], self.t));
            let found = crossing.map(|crossing| crossing == Crossing::Found);
            if crossing.contains(&Crossing::Possible) && worst == Crossing::None {
                worst = Crossing::Possible;
            }
            for k in (0..2).filter(|k| found[*k]) {
                worst = Crossing::Found;
                let share = start[i][k].share_to_zero(end[i][k], self.t);
                first = Some(first.unwrap_or(1.0_f64).min(share));
            }
            event.note(i, found, plant.modes, plant.brake);
        }
        if plant.meshes != Meshes::IDEAL {
            let system = &systems.by_stuck[stuck_set(plant.modes)];
            let (crossing, reached) = self.mesh_crossing(p, system, plant);
            event.output_reached = reached;
            event.mesh = crossing == Crossing::Found;
            if worst != Crossing::Found && crossing != Crossing::None {
                worst = crossing;
            }
        }
        (worst, event, first)
    }

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
            let rate = (&system.derivative(&x, &v), &self.torques_rate());
            plant.mesh_guards(p, system, (&x, &v), rate)
        };
        let (start, end) = (guards(0.0), guards(self.t));
        let crossing = [0, 1, 2, 3].map(|k| start[k].crossing(end[k], self.t));
        let worst = [Crossing::Found, Crossing::Possible]
            .into_iter()
            .find(|worst| crossing.contains(worst));
        let reached = crossing[2] == Crossing::Found && plant.meshes.output != Mode::Stuck;
        (worst.unwrap_or(Crossing::None), reached)
    }

    /// Guards of both clutches and the brake at `t` = 0 or at the end of the block, shape (3, 2).
    ///
    /// Slipping: slip in its direction, normal force. Stuck: capacity left forward and backward. Open: what
    /// the synchroniser has left to do.
    pub(crate) fn guards(
        &self,
        p: &Params,
        systems: &Systems,
        plant: &Plant,
        t: f64,
    ) -> [[Guard; 2]; 3] {
        let system = &systems.by_stuck[stuck_set(plant.modes)];
        let (x, v) = self.at(t);
        let mut guards = [[Guard::QUIET; 2]; 3];
        if plant.brake != Mode::Open {
            let input = if t > 0.0 {
                &self.input_end
            } else {
                &self.input
            };
            let grade = self.grade_end.at(p, input.phi);
            let x_dot = system.derivative(&x, &v);
            guards[BRAKE] = brake::guards(p, &grade, plant.brake, &x, &x_dot, input, &self.rate);
        }
        for i in [0, 1] {
            guards[i] = match plant.modes[i] {
                Mode::Open if plant.synchroniser[i] == Mode::Open => continue,
                Mode::Open => {
                    let x_dot = system.derivative(&x, &v);
                    let ratio = systems.synchroniser_ratio[i];
                    [plant.synchroniser_guard(i, ratio, &x, &x_dot), Guard::QUIET]
                }
                mode => self.clutch_guards(p, &system.rows, (i, mode), t, (&x, &v)),
            };
        }
        guards
    }

    /// Guards of a clutch with a normal force: slip in its direction and the force, or capacity left both ways.
    fn clutch_guards(
        &self,
        p: &Params,
        rows: &Rows,
        (i, mode): (usize, Mode),
        t: f64,
        (x, v): (&State, &Torques),
    ) -> [Guard; 2] {
        let rate = self.rate.force[i];
        let force = (self.input.force[i] + rate * t, rate);
        if mode == Mode::Stuck {
            let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n;
            let ramp = rows.torque[i].of_torques(&self.torques_rate());
            let torque = (rows.torque[i].of(x, v), rows.torque_rate[i].of(x, v) + ramp);
            return [-1.0, 1.0].map(|sign| weighted(reach, force, sign, torque));
        }
        let slip = (slip(x)[i], rows.slip_rate[i].of(x, v));
        [
            weighted(0.0, force, mode.direction(), slip),
            weighted(1.0, force, 0.0, slip),
        ]
    }
}

/// Guard a·x + b·y of two quantities, each with its rate.
fn weighted(a: f64, x: (f64, f64), b: f64, y: (f64, f64)) -> Guard {
    Guard {
        value: a * x.0 + b * y.0,
        rate: a * x.1 + b * y.1,
    }
}

/// Ramp of T_v [N·m/s] that meets (11) at the end of the rung, by Newton's method from the tangent at the start.
///
/// `start`: T_v at the start [N·m], and its slope over ω_w if it is to begin with it, else 0. `held`: change of ω_w
/// if T_v stays as it is [rad/s]. `load`: T_v [N·m] and its slope after a change of ω_w.
#[inline(always)]
pub(crate) fn load_ramp(
    rung: &Rung,
    start: (f64, f64),
    held: f64,
    load: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let (gain, (t_v, slope)) = (rung.wheel_speed_by_load_ramp(), start);
    let mut ramp = slope * held / (rung.t - slope * gain);
    for _ in 0..LOAD_ITERATIONS {
        let (end, slope) = load(held + gain * ramp);
        let change = (end - t_v - ramp * rung.t) / (slope * gain - rung.t);
        ramp -= change;
        if (gain * change).abs() < LOAD_SETTLED {
            break;
        }
    }
    ramp
}
