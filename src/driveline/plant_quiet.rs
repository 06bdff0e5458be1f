//! The ordinary step: inputs that are held, and nothing that could be an event in it.
//!
//! Such a step is one rung of the ladder. It takes no decisions, so it is what `plant.rs` and
//! `plant_block.rs` do block by block, without their questions. Where any of them might have another
//! answer, nothing is done and the step is taken there.

use crate::Params;
use crate::integrate::{LADDER, Propagators, Rung, Start};
use crate::plant::Plant;
use crate::plant_block::{LOAD, load_ramp, torques};
use crate::plant_matrices::{
    C, D, Rows, SPEEDS, STATES, State, Systems, TORQUES, Torques, W, slip,
};
use crate::plant_modes::{Mode, ZERO_SLIP, stuck_set};
use crate::plant_ports::{Input, InputRate};

/// State and torques at one end of the step, in the order of a row.
type Instant = [f64; STATES + TORQUES];

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
        let plain = self.brake == Mode::Open
            && self.synchroniser == [Mode::Open; 2]
            && input.gear == self.gear
            && input.t_brake <= 0.0
            && p.road.v_eps > 0.0
            && *rate == InputRate::default()
            && !p.friction_varies();
        if !plain {
            return false;
        }
        self.grade = self.grade.at(input.phi);
        let (set, systems) = (stuck_set(self.modes), &propagators.systems);
        let (rung, rows) = (propagators.rung(set, LADDER), &systems.by_stuck[set].rows);
        let load = |omega_w| p.road.smooth_load(omega_w, self.grade);
        let (t_v, _) = load(self.x[W]);
        let v = torques(p, self.modes, [1.0; 2], input.t_e, input.force, t_v);
        let mut start = rung.start(&self.x, &v, &Torques::zeros());
        let mut motion = rung.motion_held(&start);
        let ramp = load_ramp(rung, &start, &motion, load);
        rung.add_ramp(&mut motion, LOAD, ramp);
        start.add_ramp(LOAD, ramp);
        let x_end = motion.end(&start);
        let mut ends = [instant(&self.x, &v), instant(&x_end, &v)];
        ends[1][STATES + LOAD] += ramp * rung.t;
        let quiet = self.is_quiet(p, rows, input, 0, &ends, ramp)
            && self.is_quiet(p, rows, input, 1, &ends, ramp);
        if quiet {
            self.book(rung, &start, &rung.work(&start, &motion));
            self.x = x_end;
            self.hold_ratios(systems.rigid_ratio);
            remove_slip(systems, set, &mut self.x);
        }
        quiet
    }

    /// Whether clutch `i` plainly stays what it is from one end of the step to the other.
    ///
    /// `ramp`: of the load [N·m/s].
    #[inline(always)]
    fn is_quiet(
        &self,
        p: &Params,
        rows: &Rows,
        input: &Input,
        i: usize,
        ends: &[Instant; 2],
        ramp: f64,
    ) -> bool {
        let pressed = input.force[i] > 0.0;
        match self.modes[i] {
            Mode::Open => input.force[i] <= 0.0,
            Mode::Stuck => {
                let reach = p.clutch[i].mu_s * p.clutch[i].r_c_n * input.force[i];
                let ramp = rows.torque[i].of_torque(LOAD, ramp);
                let rate = |k: usize| rows.torque_rate[i].at(&ends[k]) + ramp;
                pressed
                    && rows.torque[i].at(&ends[0]).abs() < reach
                    && rows.torque[i].at(&ends[1]).abs() < reach
                    && rate(0) * rate(1) >= 0.0
            }
            sliding => {
                let direction = sliding.direction();
                let [start, end] = [0, 1].map(|k| direction * (ends[k][D] - ends[k][C + i]));
                let rate = |k: usize| direction * rows.slip_rate[i].at(&ends[k]);
                pressed && start > ZERO_SLIP && end >= 0.0 && (rate(0) >= 0.0 || rate(1) <= 0.0)
            }
        }
    }

    /// Books work and losses over a rung.
    #[inline(always)]
    pub(crate) fn book(&mut self, rung: &Rung, start: &Start, work: &Torques) {
        self.work.engine += work[0];
        for i in [0, 1] {
            *if self.synchroniser[i] == Mode::Open {
                &mut self.work.friction[i]
            } else {
                &mut self.work.synchroniser
            } += work[1 + i];
        }
        self.work.load += work[3];
        self.work.viscous += rung.viscous_loss(start);
    }
}

fn instant(x: &State, v: &Torques) -> Instant {
    let mut all = [0.0; STATES + TORQUES];
    let (states, torques) = all.split_at_mut(STATES);
    states.copy_from_slice(x.as_slice());
    torques.copy_from_slice(v.as_slice());
    all
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
            plain += u32::from(plant.step_quietly(p, &propagators, input, &held));
            let quiet = plant != other;
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
