//! Both clutches engaged on rigid shafts with gears of two ratios: a tie, behind which nothing turns.
//!
//! Without losses two equations give both torques, T_c1 + T_c2 = T_d and g1 T_c1 + g2 T_c2 = T_o, and the tie breaks where
//! one is beyond what sticks. With losses gears that stand take up what is missing of the second one (`plant/mesh.rs`),
//! so the torques are not determined and the tie holds longer: it stands while no motion is consistent. Torques
//! are shown as without loss, or, where one clutch could not carry that, with what it can and the rest on the other.
//!
//! Such a tie is left where both clutches together are beyond what sticks, a guard, or where other modes become
//! consistent. No guard tells that, so it is asked at the end of each block, and of shorter ones until the instant is
//! found to a tick. What could move only between the ends of a block, for less than a step, stays. Derivatives of the
//! torques by inputs are those without loss.

use crate::Params;
use crate::integrate::Ladders;
use crate::matrices::{D, Systems, slip};
use crate::plant::Plant;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Event, GUARD_TOLERANCE, Guard, Mode, ZERO_SLIP, project, stuck_set};
use crate::plant::ports::{Input, InputRate};

/// Guards of tied clutches, one of which is beyond what sticks at the start: what both can carry together.
pub(crate) fn share_guards(start: &mut [[Guard; 2]; 3], end: &mut [[Guard; 2]; 3]) {
    let one = start[..2].as_flattened();
    if one.iter().any(|guard| guard.value < -GUARD_TOLERANCE) {
        for guards in [start, end] {
            let both = [0, 1].map(|k| Guard {
                value: guards[0][k].value + guards[1][k].value,
                rate: guards[0][k].rate + guards[1][k].rate,
            });
            (guards[0], guards[1]) = (both, both);
        }
    }
}

impl Plant {
    /// Whether both clutches are engaged in jammed gears of two ratios.
    pub(crate) fn is_tied(&self, p: &Params) -> bool {
        self.modes == [Mode::Stuck; 2] && self.coupling().ties(p)
    }

    /// Whether the plant stands tied in gears that lose power, its torques not determined.
    pub(crate) fn is_strained(&self, p: &Params) -> bool {
        self.meshes == Meshes::JAMMED && self.is_tied(p)
    }

    /// Whether a plant that is strained need not be any more: other modes are consistent.
    #[cold]
    #[inline(never)]
    pub(crate) fn may_leave(
        &self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
    ) -> bool {
        let mut left = *self;
        left.resolve_rigid(p, ladders, input, rate, &Event::default());
        !left.is_strained(p)
    }

    /// Whether the plant might stand tied at an instant at which its output stands.
    pub(crate) fn may_tie(
        &self,
        p: &Params,
        input: &Input,
        rate: &InputRate,
        event: &Event,
    ) -> bool {
        let pressed = |i: usize| input.force[i] > 0.0 || !event.opened[i] && rate.force[i] > 0.0;
        let stopped = stuck_set(self.modes) != 0
            || event.reached != [false; 2]
            || self.x[D].abs() <= ZERO_SLIP;
        stopped && pressed(0) && pressed(1) && self.coupling().ties(p)
    }

    /// Whether a clutch at zero slip was to slip where nothing drives it: no modes are consistent.
    pub(crate) fn slips_in_vain(&self, p: &Params, systems: &Systems, input: &Input) -> bool {
        let v = self.torques_now(p, input);
        let set = stuck_set(self.modes);
        let (slip, rate) = (
            slip(&self.x),
            slip(&systems.by_stuck[set].derivative(&self.x, &v)),
        );
        [0, 1].into_iter().any(|i| {
            let direction = self.modes[i].direction();
            direction != 0.0 && slip[i].abs() <= ZERO_SLIP && direction * rate[i] <= 0.0
        })
    }

    /// Stands tied in jammed gears, as no motion is consistent; what the damper's inertia has left of speed is lost.
    pub(crate) fn stand_tied(&mut self, systems: &Systems) {
        self.modes = [Mode::Stuck; 2];
        let before = systems.stored_energy(&self.x);
        project(systems, stuck_set(self.modes), &mut self.x);
        self.work.viscous += before - systems.stored_energy(&self.x);
    }

    /// Torques of tied clutches [N·m] that both of them can carry, from those without loss, shape (2).
    pub(crate) fn shared(&self, p: &Params, input: &Input, t_c: [f64; 2]) -> [f64; 2] {
        let peak = [0, 1].map(|i| p.clutch[i].mu_s * input.force[i] * p.clutch[i].r_c_n);
        let sum = t_c[0] + t_c[1];
        let (low, high) = ((-peak[0]).max(sum - peak[1]), peak[0].min(sum + peak[1]));
        let one = if low < high {
            t_c[0].clamp(low, high)
        } else {
            t_c[0]
        };
        [one, sum - one]
    }
}
