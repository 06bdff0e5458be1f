//! The ordinary step: inputs that are held, and nothing that could be an event in it.
//!
//! Such a step is one rung of the ladder. It takes no decisions, so it is what `plant.rs` and
//! `plant/block.rs` do block by block, without their questions. Where any of them might have another
//! answer, nothing is done and the step is taken there.

use crate::Params;
use crate::integrate::Ladders;
use crate::integrate::{Propagators, Rung};
use crate::matrices::{C, D, State, Systems, Torques, W};
use crate::plant::Plant;
use crate::plant::block::{LOAD, load_ramp, torques};
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Mode, ZERO_SLIP, project, stuck_set};
use crate::plant::ports::Input;
use crate::rung::held::{Held, entries};
use crate::rung::lanes::Lanes;
use crate::rung::start::{COMPLIANT, RAMPS, RIGID, TORQUE};

impl Plant {
    /// Takes the step of the ladders with inputs that are held, if it is plain that it holds no event; else does
    /// nothing. Returns [`Self::size`] as far as the step changed it.
    #[inline(always)]
    pub fn step_plainly(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
    ) -> Option<f64> {
        self.grade.become_of(p, input.phi);
        let plain = self.grade.plain
            && self.has_clutches_only()
            && input.gear == self.gear
            && input.t_brake <= 0.0;
        if !plain {
            return None;
        }
        let propagators = ladders.of_gears(p, self.gear);
        let set = stuck_set(self.modes);
        if propagators.longest(set).rung.is_rigid() {
            self.take::<RIGID>(p, propagators, set, input)
        } else {
            self.take::<COMPLIANT>(p, propagators, set, input)
        }
    }

    /// Takes a step of which only the clutches may say that it holds an event, if they do not.
    #[inline(always)]
    pub(super) fn take<const N: usize>(
        &mut self,
        p: &Params,
        propagators: &Propagators,
        set: usize,
        input: &Input,
    ) -> Option<f64> {
        let longest = propagators.longest(set);
        let rung = longest.rung;
        let here = self.grade.travel(self.x[W]);
        let sliding = self.modes[0].slips() || self.modes[1].slips();
        let friction = if sliding {
            let v = torques(p, self.modes, [1.0; 2], 0.0, input.force, 0.0);
            [v[1], v[2]]
        } else {
            [0.0; 2]
        };
        let mut z = entries::<N>(rung, &self.x, [input.t_e, here.0], friction);
        z[RAMPS[LOAD]] = self.load_ramp(p, rung, here, longest.wheel_speed_change(&z, sliding));
        let holds = |i: usize| self.holds(p, input, i, propagators, set, &z);
        let quiet = holds(0) && holds(1);
        quiet.then(|| {
            self.arrive(rung, &z, sliding, &propagators.systems, set);
            self.moved()
        })
    }

    /// Ramp of T_v [N·m/s] that meets (11) at the end of the step, see [`load_ramp`].
    ///
    /// `here`: T_v at the start [N·m], and its slope. `held`: change of ω_w if T_v stays as it is [rad/s].
    #[inline(always)]
    fn load_ramp(&self, p: &Params, rung: &Rung, here: (f64, f64), held: f64) -> f64 {
        let gain = rung.wheel_speed_by_load_ramp();
        self.grade
            .fast_ramp(self.x[W], here.1, held, gain, rung.t)
            .unwrap_or_else(|| self.slow_ramp(p, rung, here, held))
    }

    #[cold]
    #[inline(never)] // most steps do not need it
    fn slow_ramp(&self, p: &Params, rung: &Rung, here: (f64, f64), held: f64) -> f64 {
        let gain = rung.wheel_speed_by_load_ramp();
        let ramp = self.grade.slow_ramp(self.x[W], here, held, gain, rung.t);
        ramp.unwrap_or_else(|| {
            let load = |change| p.road.smooth_load(self.x[W] + change, &self.grade);
            load_ramp(rung, here, held, load)
        })
    }

    /// Books a step and takes its end.
    #[inline(never)] // a function of its own has registers for it
    fn arrive<const N: usize>(
        &mut self,
        rung: &Rung,
        z: &Lanes<N>,
        sliding: bool,
        systems: &Systems,
        set: usize,
    ) {
        let held = Held::new(rung, &self.x, z, sliding);
        let [engine, load] = held.work();
        self.work.engine += engine;
        self.work.load += load;
        self.work.viscous += held.viscous_loss(rung, &self.x);
        if let Some([one, two]) = held.friction_work(rung, &self.x) {
            self.work.friction[0] += one;
            self.work.friction[1] += two;
        }
        held.end(rung, &mut self.x);
        if N == COMPLIANT {
            self.hold_ratios(systems.rigid_ratio);
        }
        remove_slip(systems, set, &mut self.x);
    }

    /// Whether neither brake nor synchroniser nor mesh has a mode.
    #[inline(always)]
    fn has_clutches_only(&self) -> bool {
        const { assert!(Mode::Open as u8 == 0) };
        let ([one, two], Meshes { load, output }) = (self.synchroniser, self.meshes);
        // Side by side in memory: one number.
        let four = u32::from_ne_bytes([one, two, load[0], load[1]].map(|mode| mode as u8));
        four | u32::from(self.brake as u8 | output as u8) == 0
    }

    /// Whether clutch `i` plainly stays what it is from one end of the step to the other.
    #[inline(always)]
    fn holds<const N: usize>(
        &self,
        p: &Params,
        input: &Input,
        i: usize,
        propagators: &Propagators,
        set: usize,
        z: &Lanes<N>,
    ) -> bool {
        let force = input.force[i];
        match self.modes[i] {
            Mode::Open => force <= 0.0,
            Mode::Stuck => {
                let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n * force;
                let watch = &propagators.longest(set).watches[i];
                watch.most(z) < reach || self.sticks(reach, i, propagators, set, z)
            }
            slips => force > 0.0 && self.slides(slips.direction(), i, propagators, set, z),
        }
    }

    /// Whether engaged clutch `i` plainly stays so, by a closer look: its torque within `reach` [N·m] at both ends, and
    /// between them where it goes one way.
    #[cold]
    #[inline(never)]
    fn sticks<const N: usize>(
        &self,
        reach: f64,
        i: usize,
        propagators: &Propagators,
        set: usize,
        z: &Lanes<N>,
    ) -> bool {
        let longest = propagators.longest(set);
        let [start, end, rate] = longest.watches[i].read(z);
        let rate_at_end = || {
            let (x, v) = self.end(longest.rung, z);
            let rows = &propagators.systems.by_stuck[set].rows;
            rows.torque_rate[i].of(&x, &v) + rows.torque[i].of_torque(LOAD, z[RAMPS[LOAD]])
        };
        start.abs() < reach
            && end.abs() < reach
            && (start.abs() + rate.abs() * longest.rung.t <= reach || rate * rate_at_end() >= 0.0)
    }

    /// Whether clutch `i` plainly slides on in a direction.
    #[inline(never)] // most steps have none
    fn slides<const N: usize>(
        &self,
        direction: f64,
        i: usize,
        propagators: &Propagators,
        set: usize,
        z: &Lanes<N>,
    ) -> bool {
        let longest = propagators.longest(set);
        let slip = direction * (self.x[D] - self.x[C + i]);
        let [change, rate] = longest.watches[i].slip(z).map(|value| direction * value);
        let rate_at_end = || {
            let (x, v) = self.end(longest.rung, z);
            direction * propagators.systems.by_stuck[set].rows.slip_rate[i].of(&x, &v)
        };
        slip > ZERO_SLIP
            && slip + change >= 0.0
            && (slip + rate * longest.rung.t >= 0.0 || rate_at_end() <= 0.0)
    }

    /// State and torques at the end.
    fn end<const N: usize>(&self, rung: &Rung, z: &Lanes<N>) -> (State, Torques) {
        let mut x = self.x;
        Held::new(rung, &self.x, z, true).end(rung, &mut x);
        let mut v = Torques::from(TORQUE.map(|at| z[at]));
        v[LOAD] += z[RAMPS[LOAD]] * rung.t;
        (x, v)
    }

    /// Books the work of the torques.
    #[inline(always)]
    pub(crate) fn book(&mut self, work: &Torques) {
        self.work.engine += work[0];
        for i in [0, 1] {
            *if self.synchroniser[i] == Mode::Open {
                &mut self.work.friction[i]
            } else {
                &mut self.work.synchroniser
            } += work[1 + i];
        }
        self.work.load += work[3];
    }
}

/// Removes what round-off left of the slip of engaged clutches: of both by impulses that keep momentum, of one
/// with that of the damper's side, which is as small.
#[inline(always)]
fn remove_slip(systems: &Systems, set: usize, x: &mut State) {
    if set == 3 {
        project(systems, set, x);
    } else if set != 0 {
        x[D] = x[C + (set >> 1 & 1)];
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, Mode, Plant, Propagators};
    use crate::Params;
    use crate::plant::InputRate;

    /// Round-off of a step: slip of an engaged clutch is removed in another order.
    const ROUND_OFF: f64 = 1e-9;
    /// Changes nothing, but is no held input: such a step is taken block by block.
    const BY_BLOCKS: InputRate = InputRate {
        t_e: f64::MIN_POSITIVE,
        force: [0.0; 2],
        t_brake: 0.0,
        phi: 0.0,
    };

    fn variants() -> [Params; 2] {
        [false, true].map(|rigid| Params {
            rigid,
            ..Params::TABLE_1
        })
    }

    /// Steps two plants side by side and returns how many steps were plain.
    fn plain_steps(p: &Params, input: &Input, steps: u32) -> u32 {
        let mut propagators = Propagators::new(p, input.gear, 1e-3);
        let mut plant = Plant::start(p, input, 90.0, 2.0);
        let mut plain = 0;
        for _ in 0..steps {
            let mut other = plant;
            let quiet = plant.step_plainly(p, &mut propagators, input).is_some();
            plain += u32::from(quiet);
            other.step(p, &mut propagators, input, &BY_BLOCKS);
            if !quiet {
                plant = other;
            }
            assert!((plant.x - other.x).amax() < ROUND_OFF);
            assert_eq!(plant.modes, other.modes);
            let apart = plant.energy_residual(&propagators.systems)
                - other.energy_residual(&propagators.systems);
            assert!(apart.abs() < ROUND_OFF * plant.work.engine.abs().max(1.0));
        }
        plain
    }

    #[test]
    fn a_plain_step_is_what_blocks_make_of_it() {
        let launch = Input {
            t_e: 60.0,
            force: [2500.0, 0.0],
            gear: [1, 2],
            ..Input::default()
        };
        let both = Input {
            force: [400.0, 600.0],
            phi: 0.03,
            ..launch
        };
        for p in variants() {
            for input in [launch, both] {
                let plain = plain_steps(&p, &input, 3000);
                assert!((2900..3000).contains(&plain), "{plain}");
            }
        }
    }

    #[test]
    fn what_may_hold_an_event_is_left_to_blocks() {
        let p = Params::TABLE_1;
        let input = Input {
            force: [2500.0, 0.0],
            gear: [1, 2],
            ..Input::default()
        };
        let plant = Plant::start(&p, &input, 90.0, 2.0);
        let plain = |plant: Plant, p: &Params, input: &Input| {
            let mut propagators = Propagators::new(p, plant.coupling(), 1e-3);
            let mut after = plant;
            let plain = after.step_plainly(p, &mut propagators, input).is_some();
            assert!(plain || after == plant);
            plain
        };
        assert!(plain(plant, &p, &input));
        let (braked, other) = (
            Input {
                t_brake: 1.0,
                ..input
            },
            Input {
                force: [2500.0, 1.0],
                ..input
            },
        );
        let released = Input {
            force: [0.0; 2],
            ..input
        };
        for input in [braked, other, released] {
            assert!(!plain(plant, &p, &input));
        }
        let preselected = Input {
            gear: [1, 0],
            ..input
        };
        assert!(!plain(plant, &p, &preselected));
        let synchronising = Plant {
            synchroniser: [Mode::Open, Mode::Forward],
            ..plant
        };
        assert!(!plain(synchronising, &p, &input));
        let held_wheels = Plant {
            brake: Mode::Stuck,
            ..plant
        };
        assert!(!plain(held_wheels, &p, &input));
        let mut dry = p;
        dry.road.v_eps = 0.0;
        assert!(!plain(Plant::start(&dry, &input, 90.0, 2.0), &dry, &input));
        let mut slow = plant;
        slow.x[1] = slow.x[2] + 1e-6;
        assert!(!plain(
            slow,
            &p,
            &Input {
                t_e: -500.0,
                ..input
            }
        ));
    }
}
