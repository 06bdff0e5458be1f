//! How far the next block of a step reaches: to the tick in which an event is expected, and freely behind it.
//!
//! A guard that is below zero at the end of a block tells when it came there: by the cubic through its values and rates at
//! both ends. Up to that tick the longest blocks are taken that fit, and each is looked at like any other, so what is
//! expected decides on cost alone. If an event comes sooner, a block shows it and is given up, each time a shorter one; if it
//! comes later, the ladder is climbed again.

use crate::integrate::{LADDER, TICKS, level, ticks};
use crate::plant::modes::Guard;

/// Newton steps on the cubic, from the secant.
const ITERATIONS: u32 = 4;
/// Added to a small number it leaves a whole one in the last bits.
const ROUND: f64 = 1.0 / f64::EPSILON;

/// Where a step has come to, and what bounds its next block.
pub(crate) struct Search {
    /// Ticks behind.
    pub(crate) done: u32,
    /// Ticks behind when the modes that act began.
    piece: u32,
    /// Highest level to try.
    cap: usize,
    /// Ticks behind when an event is expected within one more.
    due: u32,
}

impl Search {
    /// Of a step that begins.
    pub(crate) const START: Self = Self {
        done: 0,
        piece: 0,
        cap: LADDER,
        due: TICKS,
    };

    /// Level of the block to try next, `longest` at most.
    pub(crate) fn level(&self, longest: usize) -> usize {
        let rest = match self.done.checked_sub(self.due) {
            None => self.due - self.done,
            Some(0 | 1) => 1, // it may be a tick later
            Some(_) => TICKS - self.done,
        };
        level(self.done - self.piece, rest)
            .min(self.cap)
            .min(longest)
    }

    /// A block of `level` was given up; an event is expected where `share` of it is over, if that is known.
    pub(crate) fn give_up(&mut self, level: usize, share: Option<f64>) {
        let (length, deceived) = (ticks(level), self.due < self.done);
        let expected = |share| self.done + nearest(f64::from(length) * share - 0.5).min(length - 1);
        self.cap = level - 1;
        self.due = share.filter(|_| !deceived).map_or(TICKS, expected);
    }

    /// A block of `level` was taken.
    pub(crate) fn advance(&mut self, level: usize) {
        (self.done, self.cap) = (self.done + ticks(level), LADDER);
    }

    /// An event has happened.
    pub(crate) fn begin_piece(&mut self) {
        (self.piece, self.due) = (self.done, TICKS);
    }
}

impl Guard {
    /// Where between this and a guard below zero, `t` [s] later, it came to zero, [0, 1].
    pub(crate) fn share_to_zero(self, end: Self, t: f64) -> f64 {
        let (start, rates) = (self.value, [self.rate * t, end.rate * t]);
        let rise = end.value - start;
        let square = 3.0 * rise - 2.0 * rates[0] - rates[1];
        let cube = rates[0] + rates[1] - 2.0 * rise;
        let mut share = -start / rise;
        for _ in 0..ITERATIONS {
            let value = start + share * (rates[0] + share * (square + share * cube));
            let slope = rates[0] + share * (2.0 * square + share * 3.0 * cube);
            share = (share - value / slope).clamp(0.0, 1.0);
        }
        share
    }
}

/// The whole number that is nearest to a small one; 0 to a negative one and to none.
fn nearest(number: f64) -> u32 {
    ((number.max(0.0) + ROUND).to_bits() % (1 << 31)) as u32
}

#[cfg(test)]
mod tests {
    use super::{Guard, LADDER, Search, TICKS, nearest};
    use crate::integrate::ticks;

    #[test]
    fn a_number_has_a_nearest_whole_one() {
        let cases = [(-3.0, 0), (0.4, 0), (0.6, 1), (4095.4, 4095), (f64::NAN, 0)];
        for (number, whole) in cases {
            assert_eq!(nearest(number), whole, "{number}");
        }
    }

    #[test]
    fn a_guard_that_bends_is_expected_in_its_tick() {
        let t = 1e-3;
        // 1 + a s + b s² + c s³, zero in (0, 1).
        for [a, b, c] in [[-3.0, 0.0, 0.0], [1.0, -4.0, 0.0], [-0.5, 0.5, -2.0]] {
            let value = |s: f64| 1.0 + s * (a + s * (b + s * c));
            let guard = |s: f64| Guard {
                value: value(s),
                rate: (a + s * (2.0 * b + s * 3.0 * c)) / t,
            };
            let share = guard(0.0).share_to_zero(guard(1.0), t);
            let tick = 1.0 / f64::from(TICKS);
            let [before, behind] = [share - tick, share + tick].map(value);
            assert!(before > 0.0 && behind < 0.0, "{share}");
        }
    }

    /// Blocks that a search tries for an event in a tick, which it expects `off` ticks from where it is.
    fn tried(event: u32, off: i32) -> u32 {
        let (mut search, mut tried) = (Search::START, 0);
        while search.done < TICKS {
            let (level, start) = (search.level(LADDER), search.done);
            let end = start + ticks(level);
            assert!(end <= TICKS);
            tried += 1;
            if (start..end).contains(&event) && level > 0 {
                let ahead = f64::from(event - start) + f64::from(off) + 0.5;
                let share = ahead / f64::from(ticks(level));
                search.give_up(level, Some(share.clamp(0.0, 1.0)));
                continue;
            }
            search.advance(level);
            if start == event {
                search.begin_piece();
            }
        }
        tried
    }

    #[test]
    fn a_tick_that_is_expected_costs_one_block_and_a_wrong_one_a_few() {
        let most = |off| (0..TICKS).step_by(7).map(|event| tried(event, off)).max();
        assert_eq!(most(0), Some(20));
        for off in [-3000, -400, -40, -1, 1, 40, 400, 3000] {
            assert!(most(off) < Some(70), "{off}: {:?}", most(off));
        }
    }
}
