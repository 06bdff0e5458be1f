//! The course of a step that may hold events: block after block, each as long as it may be.
//!
//! A block that may hide an event is given up for a shorter one; at one tick it is taken, and modes change at its end.
//! [`integrate`](crate::integrate) says which lengths are tried, and what an event is found by.

use crate::Params;
use crate::integrate::{Ladders, TICKS};
use crate::plant::Plant;
use crate::plant::block::Block;
use crate::plant::friction::longest;
use crate::plant::mesh::Meshes;
use crate::plant::modes::{Crossing, Event, Mode, stuck_set};
use crate::plant::ports::{Input, InputRate};
use crate::plant::search::Search;

/// Events one step may hold; beyond them its rest is one smooth piece.
const MAX_EVENTS: u32 = 32;

/// How far a step has come.
struct Course {
    /// Inputs now.
    now: Input,
    /// Their derivatives.
    rate: InputRate,
    /// What is behind, and how far the next block reaches.
    search: Search,
    /// Events found.
    events: u32,
}

impl Course {
    /// Whether a block of `level` may be given up for a shorter one.
    const fn may_cut(&self, level: usize) -> bool {
        level > 0 && self.events < MAX_EVENTS
    }

    /// Counts an event, from which blocks begin anew; a clutch that opened at it has no force any more.
    fn meet(&mut self, event: &Event) {
        for i in (0..2).filter(|i| event.opened[*i]) {
            (self.now.force[i], self.rate.force[i]) = (0.0, 0.0);
        }
        self.search.begin_piece();
        self.events += 1;
    }
}

impl Plant {
    /// Like [`Self::step_observed`], for a step that [`Self::step_plainly`] does not take: it may hold events.
    #[cold]
    #[inline(never)] // the ordinary step need not have its stack
    pub fn step_in_blocks(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        input: &Input,
        rate: &InputRate,
        report: &mut impl FnMut(f64, [Mode; 6], [Mode; 6]),
    ) {
        if self.meshes != Meshes::IDEAL && self.step_in_meshes(p, ladders, input, rate) {
            return;
        }
        let mut place = None;
        let p = p.with_static_friction(&mut place, self.temperature);
        let mut course = Course {
            now: input.after(rate, 0.0),
            rate: *rate,
            search: Search::START,
            events: 0,
        };
        let before = self.all_modes();
        self.grade.become_of(p, course.now.phi);
        self.change_gears(p, &course.now, &course.rate);
        self.resolve_all(p, ladders, &course.now, &course.rate, &Event::default());
        report(0.0, before, self.all_modes());
        while course.search.done < TICKS {
            let Some((event, block, h)) = self.take_block(p, ladders, &mut course) else {
                continue;
            };
            course.meet(&event);
            let before = self.all_modes();
            self.change_modes(p, ladders, (&course.now, &course.rate), &event, &block);
            let since = h * f64::from(course.search.done) / f64::from(TICKS);
            report(since, before, self.all_modes());
        }
    }

    /// Takes the next block, or none if it has to be shorter; what happened at its end, if modes change there, with the
    /// communication step [s].
    #[inline(always)]
    fn take_block(
        &mut self,
        p: &Params,
        ladders: &mut impl Ladders,
        course: &mut Course,
    ) -> Option<(Event, Block, f64)> {
        let propagators = ladders.of(p, self.coupling());
        let (h, systems) = (propagators.h, &propagators.systems);
        let varies = p.friction_varies() && self.modes.map(Mode::direction) != [0.0; 2];
        let level = course.search.level(longest(varies, h));
        let rung = propagators.rung(stuck_set(self.modes), level);
        let (block, settled) = Block::over(p, self, rung, &course.now, &course.rate, varies);
        if !settled && level > 0 {
            course.search.give_up(level, None);
            return None;
        }
        let (mut crossing, mut event, share) = block.look(p, systems, self);
        if crossing != Crossing::None && course.may_cut(level) {
            course.search.give_up(level, share);
            return None;
        }
        let strained = self.is_strained(p).then_some(*self);
        self.accept(p, systems, rung, &block);
        if let Some(was) = strained
            && course.events < MAX_EVENTS
            && self.may_leave(p, ladders, &block.input_end, &course.rate)
        {
            if level > 0 {
                *self = was;
                course.search.give_up(level, None);
                return None;
            }
            (crossing, event.mesh) = (Crossing::Found, true);
        }
        course.now = block.input_end;
        course.search.advance(level);
        let happened = crossing != Crossing::None && !event.is_none();
        (happened && course.events < MAX_EVENTS).then_some((event, block, h))
    }
}
