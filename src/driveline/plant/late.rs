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
use crate::plant::Plant;
use crate::plant::block::{Block, torques};
use crate::plant::matrices::{SPEEDS, State, Systems, Torques, synchroniser_row};
use crate::plant::mobility::Mobility;
use crate::plant::modes::{Event, Guard, stuck_set};
use crate::plant::ports::Input;

/// How late an event was found at the end of a block, and how the plant moved then.
pub(crate) struct Late {
    /// Time since clutches broke away or their slip came to zero [s], shape (2); 0: it did not.
    clutch: [f64; 2],
    /// Time since shafts turned like the gears that they are synchronised to [s], shape (2).
    pub(crate) synchronised: [f64; 2],
    /// The end of the block.
    x: State,
    /// v there, shape (4).
    torques: Torques,
    /// x' with the modes of the block.
    rate: State,
}

impl Block {
    /// How late `event` is found at the end of the block.
    #[cold]
    #[inline(never)]
    pub(crate) fn late(&self, p: &Params, systems: &Systems, plant: &Plant, event: &Event) -> Late {
        let (x, torques) = self.at(self.t);
        let guards = self.guards(p, systems, plant, self.t);
        let since = |guard: Guard| match guard.value < 0.0 && guard.rate < 0.0 {
            true => (guard.value / guard.rate).min(self.t),
            false => 0.0,
        };
        let of = |happened: [bool; 2], i: usize| match happened[i] {
            true => since(guards[i][0]).max(since(guards[i][1])),
            false => 0.0,
        };
        Late {
            clutch: [0, 1].map(|i| of(event.broken, i) + of(event.reached, i)),
            synchronised: [0, 1].map(|i| of(event.synchronised, i)),
            x,
            torques,
            rate: systems.by_stuck[stuck_set(plant.modes)].derivative(&x, &torques),
        }
    }
}

impl Plant {
    /// Takes back what synchronisers have done for the last `since` [s], shape (2).
    pub(crate) fn take_back(&mut self, p: &Params, mobility: &Mobility, since: [f64; 2]) {
        let (g, torque) = (p.g(self.gear), self.synchroniser_torque(p));
        let mut moved = self.x.fixed_rows_mut::<SPEEDS>(0);
        for i in [0, 1] {
            moved += mobility * synchroniser_row(i, g[i]) * (torque[i] * since[i]);
        }
    }

    /// Moves as if a clutch had slipped as it does now since its event; books the work with that of its friction.
    pub(crate) fn slip_since(&mut self, p: &Params, systems: &Systems, input: &Input, late: &Late) {
        let [one, two] = late.clutch;
        let i = usize::from(two > 0.0);
        if (one > 0.0) == (two > 0.0) || self.modes[i].direction() == 0.0 {
            return;
        }
        let before = systems.stored_energy(&self.x);
        let (v, factor) = (late.torques, self.friction_factor(p));
        let v = torques(p, self.modes, factor, v[0], input.force, v[3]);
        let v = self.with_synchronisers(p, v);
        let rate = systems.by_stuck[stuck_set(self.modes)].derivative(&late.x, &v);
        self.x = late.x + (one + two) * (rate - late.rate);
        self.work.friction[i] += before - systems.stored_energy(&self.x);
    }
}
