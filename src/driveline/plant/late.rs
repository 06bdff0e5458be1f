//! What acted while an event was late: it is undone to first order, so that what is left is a tick².
//!
//! An event is found at the end of a tick, δ after it happened. If a clutch engages, the slip it has by then is
//! removed by an impulse, which is what its constraint would have done since; at a bend, at an opening and at the
//! end of a jam old and new modes give the same acceleration. Torques that jump are left: a synchroniser's, of
//! which T_s δ is taken back, and that of a clutch that breaks away or whose slip goes through zero:
//!
//! ```text
//! x(t) + δ (x'(new modes) − x'(old modes)),      δ = guard / rate of the guard at t
//! ```
//!
//! Where two clutches have their events in the same tick, this is left out.

use crate::Params;
use crate::integrate::Ladders;
use crate::matrices::mobility::Mobility;
use crate::matrices::state::synchroniser_row;
use crate::matrices::{SPEEDS, Systems};
use crate::plant::Plant;
use crate::plant::block::{Block, torques};
use crate::plant::modes::{Event, Guard, stuck_set};
use crate::plant::ports::{Input, InputRate};

impl Block {
    /// How late events of `happened` are found at the end of the block [s], shape (2): of clutches, or of the
    /// synchronisers of open ones.
    ///
    /// `plant`: with the modes of the block.
    fn late(&self, p: &Params, systems: &Systems, plant: &Plant, happened: [bool; 2]) -> [f64; 2] {
        let guards = self.guards(p, systems, plant, self.t);
        let since = |guard: Guard| match guard.value < 0.0 && guard.rate < 0.0 {
            true => (guard.value / guard.rate).min(self.t),
            false => 0.0,
        };
        [0, 1].map(|i| match happened[i] {
            true => since(guards[i][0]).max(since(guards[i][1])),
            false => 0.0,
        })
    }
}

impl Plant {
    /// Takes the modes that are consistent after `event` at the end of a block, and gears in; undoes what was done
    /// while it was late.
    pub(crate) fn change_modes(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        (input, rate): (&Input, &InputRate),
        event: &Event,
        block: &Block,
    ) {
        let was = *self;
        if event.synchronised != [false; 2] {
            let systems = &ladders.of(p, was.coupling()).systems;
            let late = block.late(p, systems, &was, event.synchronised);
            self.put_in(p, event.synchronised, late);
        }
        self.resolve_all(p, ladders, input, rate, event);
        let happened = [0, 1].map(|i| event.reached[i] || event.broken[i]);
        let slips = |i: usize| happened[i] && self.modes[i].direction() != 0.0;
        if event.is_of_clutches() && happened != [true; 2] && (slips(0) || slips(1)) {
            self.slip_since(p, ladders, happened, block, &was);
        }
    }

    /// Takes back what synchronisers have done for the last `since` [s], shape (2).
    pub(crate) fn take_back(&mut self, p: &Params, mobility: &Mobility, since: [f64; 2]) {
        let (g, torque) = (p.g(self.gear), self.synchroniser_torque(p));
        let mut moved = self.x.fixed_rows_mut::<SPEEDS>(0);
        for i in [0, 1] {
            moved += mobility * synchroniser_row(i, g[i]) * (torque[i] * since[i]);
        }
    }

    /// Moves as if the clutch of `happened` had slipped as it does now since its event, before which the plant `was`
    /// another; books the work with that of its friction.
    #[cold]
    #[inline(never)]
    fn slip_since(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        happened: [bool; 2],
        block: &Block,
        was: &Self,
    ) {
        let (x, mut v) = block.at(block.t);
        let systems = &ladders.of(p, was.coupling()).systems;
        let [one, two] = block.late(p, systems, was, happened);
        let rate = systems.by_stuck[stuck_set(was.modes)].derivative(&x, &v);
        let (factor, force) = (self.friction_factor(p), block.input_end.force);
        v = self.with_synchronisers(p, torques(p, self.modes, factor, v[0], force, v[3]));
        let systems = &ladders.of(p, self.coupling()).systems;
        let change = systems.by_stuck[stuck_set(self.modes)].derivative(&x, &v) - rate;
        let before = systems.stored_energy(&self.x);
        self.x = x + (one + two) * change;
        self.work.friction[usize::from(happened[1])] += before - systems.stored_energy(&self.x);
    }
}
