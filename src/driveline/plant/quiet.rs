//! The ordinary step: inputs that are held, and nothing that could be an event in it.
//!
//! Such a step is one rung of the ladder. It takes no decisions, so it is what `plant.rs` and
//! `plant/block.rs` do block by block, without their questions. Where any of them might have another
//! answer, nothing is done and the step is taken there.

use crate::Params;
use crate::integrate::{Propagators, Rung};
use crate::plant::Plant;
use crate::plant::block::{LOAD, load_ramp, torques};
use crate::plant::matrices::{C, D, Row, SPEEDS, State, Systems, Torques, W, slip};
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Mode, ZERO_SLIP, stuck_set};
use crate::plant::ports::{Input, InputRate};
use crate::rung::start::{Entries, RAMPS, TORQUE};
use crate::rung::watch::Watch;

/// The ordinary step, from its start to its end.
struct Quiet<'a> {
    rung: &'a Rung,
    z: &'a Entries,
    x_end: &'a State,
}

impl Plant {
    /// Takes the step of the propagators, if it is plain that it holds no event; returns whether it did.
    #[inline(always)]
    pub(crate) fn step_quietly(
        &mut self,
        p: &Params,
        propagators: &Propagators,
        input: &Input,
        rate: &InputRate,
    ) -> bool {
        if !self.is_plain(p, input, rate) {
            return false;
        }
        self.grade.become_of(input.phi);
        let (set, systems) = (stuck_set(self.modes), &propagators.systems);
        let (rung, watches) = propagators.longest(set);
        self.grade.travel(&p.road, self.x[W]);
        let here = p.road.smooth_load_here(self.x[W], &self.grade);
        let (t_v, _) = here;
        let v = torques(p, self.modes, [1.0; 2], input.t_e, input.force, t_v);
        let mut z = rung.entries(&self.x, &v);
        let mut motion = rung.motion_held(&self.x, &z);
        z[RAMPS[LOAD]] = load_ramp(rung, here, motion.wheel_speed_change(), |change| {
            p.road.smooth_load_near(self.x[W] + change, &self.grade)
        });
        let x_end = rung.end_under(&mut motion, &self.x, z[RAMPS[LOAD]]);
        let step = Quiet {
            rung,
            z: &z,
            x_end: &x_end,
        };
        let quiet = [0, 1]
            .into_iter()
            .all(|i| self.is_quiet(p, input, i, &step, &watches[i], systems));
        if quiet {
            let work = rung.work_held(&self.x, &z, &motion);
            self.work.engine += work[0];
            self.work.friction = [0, 1].map(|i| self.work.friction[i] + work[1 + i]);
            self.work.load += work[3];
            self.work.viscous += rung.viscous_loss_held(&self.x, &z);
            self.x = x_end;
            self.hold_ratios(systems.rigid_ratio);
            remove_slip(systems, set, &mut self.x);
        }
        quiet
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
    fn is_quiet(
        &self,
        p: &Params,
        input: &Input,
        i: usize,
        step: &Quiet,
        watch: &Watch,
        systems: &Systems,
    ) -> bool {
        let (force, clutch, t) = (input.force[i], &p.clutch[i], step.rung.t);
        if self.modes[i] == Mode::Open {
            return force <= 0.0;
        }
        let [start, end, rate] = watch.read(step.z, step.rung.is_rigid());
        let rows = &systems.by_stuck[stuck_set(self.modes)].rows;
        if self.modes[i] == Mode::Stuck {
            let reach = clutch.mu_s * clutch.r_c_n * force;
            return force > 0.0
                && start.abs() < reach
                && end.abs() < reach
                && (start.abs() + rate.abs() * t <= reach
                    || rate * step.rate_at_end(&rows.torque_rate[i], Some(&rows.torque[i]))
                        >= 0.0);
        }
        let direction = self.modes[i].direction();
        let [slip, slip_end] = [&self.x, step.x_end].map(|x| direction * (x[D] - x[C + i]));
        force > 0.0
            && slip > ZERO_SLIP
            && slip_end >= 0.0
            && (slip + direction * rate * t >= 0.0
                || direction * step.rate_at_end(&rows.slip_rate[i], None) <= 0.0)
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

impl Quiet<'_> {
    /// What a row that reads a rate reads at the end; `by_ramp`: what reads the part of it from the load's ramp.
    #[cold]
    #[inline(never)]
    fn rate_at_end(&self, row: &Row, by_ramp: Option<&Row>) -> f64 {
        let (z, ramp) = (self.z, self.z[RAMPS[LOAD]]);
        let v = TORQUE.map(|at| z[at]);
        let v = Torques::from([v[0], v[1], v[2], v[3] + ramp * self.rung.t]);
        row.of(self.x_end, &v) + by_ramp.map_or(0.0, |row| row.of_torque(LOAD, ramp))
    }
}

/// Removes what round-off left of the slip of engaged clutches; momentum is kept.
#[inline(always)]
fn remove_slip(systems: &Systems, set: usize, x: &mut State) {
    let slip = slip(x);
    let impulse = &systems.by_stuck[set].projection;
    for i in [0, 1] {
        if set >> i & 1 == 1 {
            let column = &impulse.data.0[i];
            for speed in 0..SPEEDS {
                x[speed] -= column[speed] * slip[i];
            }
        }
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
            let quiet = plant.step_quietly(p, &propagators, input, &held);
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
            let propagators = Propagators::new(p, plant.coupling(), 1e-3);
            let mut after = plant;
            let plain = after.step_quietly(p, &propagators, input, rate);
            after.grade = plant.grade; // what is known of the road is no part of the state
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
