//! The ordinary step where gears lose power: one rung, if loads and direction of their meshes plainly stay.
//!
//! It is the step of `plant/quiet.rs` with other matrices, and one question more, asked of its two ends as of those of a
//! block. Where the answer is no the step is taken block by block.

use crate::Params;
use crate::integrate::Ladders;
use crate::matrices::{System, W};
use crate::plant::Plant;
use crate::plant::block::torques;
use crate::plant::modes::{Mode, stuck_set};
use crate::plant::ports::{Input, InputRate};
use crate::rung::start::{COMPLIANT, RIGID};

impl Plant {
    /// Takes the step of the ladders in meshes that lose power, if it is plain that it holds no event; else does
    /// nothing. Returns whether it did.
    #[inline(never)] // the step by blocks need not have its stack
    pub(crate) fn step_in_meshes(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
    ) -> bool {
        self.grade.become_of(p, input.phi);
        let plain = self.grade.plain
            && self.meshes.output.slips()
            && rate.is_held()
            && self.brake == Mode::Open
            && self.synchroniser == [Mode::Open; 2]
            && input.gear == self.gear
            && input.t_brake <= 0.0;
        if !plain {
            return false;
        }
        let propagators = ladders.of(p, self.coupling());
        let (set, before) = (stuck_set(self.modes), *self);
        let longest = propagators.longest(set);
        let taken = if longest.rung.is_rigid() {
            self.take::<RIGID>(p, propagators, set, input)
        } else {
            self.take::<COMPLIANT>(p, propagators, set, input)
        };
        let system = &propagators.systems.by_stuck[set];
        if taken.is_some() && self.kept_meshes(p, system, &before, input, longest.rung.t) {
            return true;
        }
        *self = before;
        false
    }

    /// Whether loads and direction of the meshes stayed since `before`, `t` [s] ago: at both ends, and where the tangent
    /// at the start leads to.
    fn kept_meshes(
        &self,
        p: &Params,
        system: &System,
        before: &Self,
        input: &Input,
        t: f64,
    ) -> bool {
        let [v, v_end] = [before, self].map(|plant| {
            let t_v = p.road.smooth_load(plant.x[W], &self.grade).0;
            torques(p, self.modes, [1.0; 2], input.t_e, input.force, t_v)
        });
        let v_dot = (v_end - v) / t;
        let x_dot = system.derivative(&before.x, &v);
        let start = before.mesh_guards(p, system, (&before.x, &v), (&x_dot, &v_dot));
        let end = before.mesh_guards(p, system, (&self.x, &v_end), (&x_dot, &v_dot));
        start.iter().zip(end).all(|(start, end)| {
            start.value >= 0.0 && end.value >= 0.0 && start.value + start.rate * t >= 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, InputRate, Mode, Plant};
    use crate::Params;
    use crate::integrate::Propagators;

    /// Round-off of a step: slip of an engaged clutch is removed in another order.
    const ROUND_OFF: f64 = 1e-9;
    const HELD: InputRate = InputRate {
        t_e: 0.0,
        force: [0.0; 2],
        t_brake: 0.0,
        phi: 0.0,
    };
    /// Changes nothing, but is no held input: such a step is taken block by block.
    const BY_BLOCKS: InputRate = InputRate {
        t_e: f64::MIN_POSITIVE,
        ..HELD
    };

    fn lossy(rigid: bool) -> Params {
        let mut p = Params {
            rigid,
            ..Params::TABLE_1
        };
        (p.eta[0][0], p.eta[1][0]) = (0.94, 0.9);
        p
    }

    fn launch() -> Input {
        Input {
            t_e: 60.0,
            force: [2500.0, 600.0],
            gear: [1, 2],
            ..Input::default()
        }
    }

    #[test]
    fn a_step_in_meshes_is_what_blocks_make_of_it() {
        for (rigid, t_e) in [(false, 60.0), (true, 60.0), (false, -30.0), (true, -30.0)] {
            let (p, input) = (lossy(rigid), Input { t_e, ..launch() });
            let mut propagators = Propagators::new(&p, input.gear, 1e-3);
            let mut plant = Plant::start(&p, &input, 150.0, 2.0);
            let mut taken = 0;
            for _ in 0..1500 {
                let mut other = plant;
                other.step(&p, &mut propagators, &input, &BY_BLOCKS);
                if plant.step_in_meshes(&p, &mut propagators, &input, &HELD) {
                    taken += 1;
                    let apart = plant.energy_residual(&propagators.systems)
                        - other.energy_residual(&propagators.systems);
                    assert!((plant.x - other.x).amax() < ROUND_OFF);
                    assert_eq!((plant.modes, plant.meshes), (other.modes, other.meshes));
                    assert!(apart.abs() < ROUND_OFF * plant.stored_at_start);
                }
                plant = other;
            }
            assert!((1350..1500).contains(&taken), "{taken} with {rigid} {t_e}");
        }
    }

    #[test]
    fn what_may_change_a_mesh_is_left_to_blocks() {
        let (p, input) = (lossy(false), launch());
        let mut propagators = Propagators::new(&p, input.gear, 1e-3);
        let mut plant = Plant::start(&p, &input, 150.0, 2.0);
        for _ in 0..20 {
            plant.step(&p, &mut propagators, &input, &HELD);
        }
        let mut takes = |plant: &Plant, input: &Input, rate: &InputRate| {
            let mut after = *plant;
            let taken = after.step_in_meshes(&p, &mut propagators, input, rate);
            assert!(taken || after.x == plant.x && after.work == plant.work);
            taken
        };
        assert!(takes(&plant, &input, &HELD));
        assert!(!takes(&plant, &input, &BY_BLOCKS));
        let braked = Input {
            t_brake: 1.0,
            ..input
        };
        assert!(!takes(&plant, &braked, &HELD));
        let mut jammed = plant;
        jammed.meshes.output = Mode::Stuck;
        assert!(!takes(&jammed, &input, &HELD));
        let mut turned = plant;
        turned.meshes.load[0] = Mode::Backward;
        assert!(!takes(&turned, &input, &HELD), "load of the other sign");
        let mut stops = plant;
        stops.x[4] = 1e-9;
        assert!(
            !takes(&stops, &input, &HELD),
            "the output about to turn back"
        );
    }
}
