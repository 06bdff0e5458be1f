//! The ordinary step: inputs that are held, and nothing that could be an event in it.
//!
//! Such a step is one rung of the ladder. It takes no decisions, so it is what `plant.rs` and
//! `plant/block.rs` do block by block, without their questions. Where any of them might have another
//! answer, nothing is done and the step is taken there.

use crate::Params;
use crate::coupling::Ladders;
use crate::integrate::{Propagators, Rung};
use crate::plant::Plant;
use crate::plant::block::{LOAD, load_ramp, torques};
use crate::plant::matrices::{C, D, State, Systems, Torques, W};
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Mode, ZERO_SLIP, project, stuck_set};
use crate::plant::ports::{Input, InputRate};
use crate::rung::held::{COMPLIANT, Held, RIGID};
use crate::rung::start::{RAMPS, TORQUE};

impl Plant {
    /// Takes the step of the ladders, if it is plain that it holds no event; returns whether it did.
    #[inline(always)]
    pub(crate) fn step_quietly(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
    ) -> bool {
        if !self.is_plain(p, input, rate) {
            return false;
        }
        let propagators = ladders.of(p, self.gear.into());
        self.grade.become_of(&p.road, input.phi);
        let set = stuck_set(self.modes);
        if propagators.longest(set).0.is_rigid() {
            self.take::<RIGID>(p, propagators, set, input)
        } else {
            self.take::<COMPLIANT>(p, propagators, set, input)
        }
    }

    /// Takes a step of which only the clutches may say that it holds an event; returns whether it did.
    #[inline(never)] // a function of its own has registers for it
    fn take<const N: usize>(
        &mut self,
        p: &Params,
        propagators: &Propagators,
        set: usize,
        input: &Input,
    ) -> bool {
        let (rung, _) = propagators.longest(set);
        let here = self.grade.travel(&p.road, self.x[W]);
        let sliding = self.modes[0].slips() || self.modes[1].slips();
        let friction = if sliding {
            let v = torques(p, self.modes, [1.0; 2], 0.0, input.force, 0.0);
            [v[1], v[2]]
        } else {
            [0.0; 2]
        };
        let z = Held::entries(rung, &self.x, [input.t_e, here.0], friction);
        let mut held = Held::<N>::new(rung, &self.x, z, sliding);
        let ramp = load_ramp(rung, here, held.wheel_speed_change(), |change| {
            p.road.load_near(self.x[W] + change, &self.grade)
        });
        held.add_load_ramp(rung, ramp);
        let quiet = [0, 1]
            .into_iter()
            .all(|i| self.is_quiet(p, input, i, propagators, set, &held));
        if quiet {
            self.arrive(rung, &held, &propagators.systems, set);
        }
        quiet
    }

    /// Books a step and takes its end.
    #[inline(always)]
    fn arrive<const N: usize>(
        &mut self,
        rung: &Rung,
        held: &Held<N>,
        systems: &Systems,
        set: usize,
    ) {
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

    /// Whether no part but the clutches may have an event, and what acts on them is held.
    #[inline(always)]
    fn is_plain(&self, p: &Params, input: &Input, rate: &InputRate) -> bool {
        self.brake == Mode::Open
            && self.synchroniser == [Mode::Open; 2]
            && self.meshes == Meshes::IDEAL
            && input.gear == self.gear
            && input.t_brake <= 0.0
            && p.road.v_eps > 0.0
            && rate.is_held()
            && !p.friction_varies()
    }

    /// Whether clutch `i` plainly stays what it is from one end of the step to the other.
    #[inline(always)]
    fn is_quiet<const N: usize>(
        &self,
        p: &Params,
        input: &Input,
        i: usize,
        propagators: &Propagators,
        set: usize,
        held: &Held<N>,
    ) -> bool {
        let (force, (rung, watches)) = (input.force[i], propagators.longest(set));
        match self.modes[i] {
            Mode::Open => force <= 0.0,
            Mode::Stuck => {
                let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n * force;
                watches[i].most(&held.z) < reach || self.sticks(reach, i, propagators, set, held)
            }
            sliding => {
                let direction = sliding.direction();
                let slip = direction * (self.x[D] - self.x[C + i]);
                let slip_end = slip + direction * held.slip_change(rung, i);
                let rate = direction * watches[i].rate(&held.z);
                force > 0.0
                    && slip > ZERO_SLIP
                    && slip_end >= 0.0
                    && (slip + rate * rung.t >= 0.0
                        || direction * self.slip_rate_at_end(i, propagators, set, held) <= 0.0)
            }
        }
    }

    /// Whether clutch `i` plainly stays engaged, by a closer look: its torque within `reach` [N·m] at both ends, and
    /// between them where it goes one way.
    #[cold]
    #[inline(never)]
    fn sticks<const N: usize>(
        &self,
        reach: f64,
        i: usize,
        propagators: &Propagators,
        set: usize,
        held: &Held<N>,
    ) -> bool {
        let (rung, watches) = propagators.longest(set);
        let [start, end, rate] = watches[i].read(&held.z);
        start.abs() < reach
            && end.abs() < reach
            && (start.abs() + rate.abs() * rung.t <= reach
                || rate * self.torque_rate_at_end(i, propagators, set, held) >= 0.0)
    }

    /// Rate of the torque of engaged clutch `i` at the end [N·m/s].
    fn torque_rate_at_end<const N: usize>(
        &self,
        i: usize,
        propagators: &Propagators,
        set: usize,
        held: &Held<N>,
    ) -> f64 {
        let (x, v) = self.end(propagators.longest(set).0, held);
        let rows = &propagators.systems.by_stuck[set].rows;
        let by_ramp = rows.torque[i].of_torque(LOAD, held.z[RAMPS[LOAD]]);
        rows.torque_rate[i].of(&x, &v) + by_ramp
    }

    /// Rate of the slip of clutch `i` at the end [rad/s²].
    #[cold]
    #[inline(never)]
    fn slip_rate_at_end<const N: usize>(
        &self,
        i: usize,
        propagators: &Propagators,
        set: usize,
        held: &Held<N>,
    ) -> f64 {
        let (x, v) = self.end(propagators.longest(set).0, held);
        propagators.systems.by_stuck[set].rows.slip_rate[i].of(&x, &v)
    }

    /// State and torques at the end.
    fn end<const N: usize>(&self, rung: &Rung, held: &Held<N>) -> (State, Torques) {
        let (z, mut x) = (&held.z, self.x);
        held.end(rung, &mut x);
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
        x[D] = x[C + (set >> 1)];
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, InputRate, Mode, Plant, Propagators};
    use crate::Params;

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
            let held = InputRate::default();
            let quiet = plant.step_quietly(p, &mut propagators, input, &held);
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
        let plain = |plant: Plant, p: &Params, input: &Input, rate: &InputRate| {
            let mut propagators = Propagators::new(p, plant.coupling(), 1e-3);
            let mut after = plant;
            let plain = after.step_quietly(p, &mut propagators, input, rate);
            assert!(plain || after == plant);
            plain
        };
        let held = InputRate::default();
        assert!(plain(plant, &p, &input, &held));
        assert!(!plain(plant, &p, &input, &BY_BLOCKS));
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
            assert!(!plain(plant, &p, &input, &held));
        }
        let preselected = Input {
            gear: [1, 0],
            ..input
        };
        assert!(!plain(plant, &p, &preselected, &held));
        let synchronising = Plant {
            synchroniser: [Mode::Open, Mode::Forward],
            ..plant
        };
        assert!(!plain(synchronising, &p, &input, &held));
        let held_wheels = Plant {
            brake: Mode::Stuck,
            ..plant
        };
        assert!(!plain(held_wheels, &p, &input, &held));
        let mut dry = p;
        dry.road.v_eps = 0.0;
        assert!(!plain(plant, &dry, &input, &held));
        let mut slow = plant;
        slow.x[1] = slow.x[2] + 1e-6;
        assert!(!plain(
            slow,
            &p,
            &Input {
                t_e: -500.0,
                ..input
            },
            &held
        ));
    }
}
