//! The propagator: exact motion of the driveline between events, on a ladder of steps.
//!
//! With z = (x, v, v') (state, torques, their ramps) the driveline between two events is z' = M z,
//! so z(t) = Ψ(t) z(0) with Ψ = exp(M t): stiffness (−42 673 1/s with Table 1) costs nothing. A
//! communication step h is cut into 4^LADDER ticks; level k of the ladder spans 4^k ticks. Each level
//! holds E = Ψ − 1, which doubles without cancellation: E(2t) = 2 E(t) + E(t)². Work integrals
//! double alike, so energies are exact, not sampled: see [`Rung`].
//!
//! # Errors of a rung
//!
//! For torques that are ramps a rung has no error of method, at any step and any stiffness; what is left:
//!
//! - Series. The shortest rung, h/4^6, is halved until ‖A t‖ ≤ 0.05 in the larger of the row-sum and the
//!   column-sum norm; terms are added down to 10⁻¹⁹ of the first one. Table 1 has ‖A‖ = 8·10⁶ 1/s, six halvings at 1 ms;
//!   their number grows with log₂ ‖A‖, so an inertia near 0 costs doublings, not accuracy.
//! - Round-off. Each doubling adds about one unit in the last place of E, and there are twelve of them plus
//!   the halvings. E and not Ψ is doubled because Ψ of the slow modes is 1 in nearly all its digits: the
//!   change of a speed over a tick would be lost in it. A rung agrees with four of the one below to 10⁻⁹
//!   of a state of order 100, which the tests demand.
//! - Losses. ∫ ψᵀ V ψ over the shortest rung is taken by Gauss' rule with three nodes, whose error is
//!   t⁷/2 016 000 times a sixth derivative of the power, at most (2 ‖A‖)⁶ ‖V‖ |z|²: below 5·10⁻¹³ of ‖V‖ |z|² t at
//!   ‖A t‖ = 0.05. From there it doubles exactly.
//! - Ties. Two clutches engaged on rigid shafts determine their torques by a 2 × 2 system with the determinant
//!   (g1 − g2)²: it loses digits as the ratios meet, and where they are one the split is not determined (the FMU refuses
//!   such gears).
//!
//! [`Plant::energy_residual`] shows what all of them come to over a run: tests demand less than 10⁻⁹ of the
//! engine's work, and find 10⁻¹³. Arithmetic is plain f64 in a fixed order, without fused operations, so that every
//! platform gets the same bits.
//!
//! [`Plant::energy_residual`]: crate::plant::Plant::energy_residual
//!
//! # The ladder
//!
//! A level spans four of the level below. From an offset inside a step the longest block is taken that
//! starts on a multiple of its own length and still fits, so a step without events is one product with
//! the top rung, and a step that is cut at a tick is nineteen blocks, down the ladder to the tick and up again. One
//! more shows that there is an event, and the cubic through the guard at its ends in which tick (`plant/search.rs`), so
//! that seldom another one is given up: twenty products, 25 if each level had to show it.
//!
//! # Events are located to a tick
//!
//! A guard g has to stay ≥ 0: slip in the direction of sliding, capacity left, normal force, wheel speed under the brake. A block
//! is given up for shorter ones if g < −10⁻¹⁰ at its end, or if the tangents of g at both ends meet below that. At
//! one tick it is taken, and the event happens at its end. **So an event is found at most h/4096 late, and never early**,
//! if no block hides one, that is, if the lower of the tangents bounds g from below:
//!
//! - where g is convex it does. A dip has convex ground, but may begin before it;
//! - for an oscillation cos ω t it does where cos x + x sin x ≥ 1, x = ω t: up to x = 2.33, for any phase. Light damping
//!   (ζ ≤ 0.2) moves that to 2.2, beyond which the first dip missed is a hundredth of the amplitude deep; with ζ = 1 one of
//!   a sixteenth may hide at x = 2.
//!
//! The fastest oscillation of Table 1 in gears 1 and 2 is 211 rad/s (ζ 0.07): steps of 10 ms and less see every dip. That of
//! `dry7` in gear 1 is 600 rad/s (ζ 0.25) with clutches open and 370 while clutch 2 is engaged, that of `wet6` 910 (ζ 0.45) and 590:
//! steps of 3.5 and 2.4 ms. Beyond them a dip of the fastest mode, which dies within a few ms, may pass unseen:
//! a clutch then slips on, or sticks on, for what is left of half a period, where it might have changed for it. The modes at the start of the
//! next step are consistent again. On drives by chance at 10 ms (`tests/drives/laws.rs`) such a step ended at most 0.014 rad/s from
//! sixteen short ones, in gears that lose power; with Table 1 and constant friction none did by more than 3·10⁻⁴.
//!
//! ```
//! use dct_driveline::{Params, integrate::Propagators};
//!
//! let propagators = Propagators::new(&Params::TABLE_1, [1, 2], 1e-3);
//! assert!(propagators.fits([1, 2], 1e-3 * (1.0 + 1e-12)));
//! assert!(!propagators.fits([1, 2], 2e-3));
//! ```

use crate::Params;
use crate::coupling::Coupling;
use crate::matrices::Systems;
use crate::rung::builder::{Active, Builder};
use crate::rung::lanes::{Lanes, dot};
use crate::rung::start::{CLUTCH_RAMPS, COMPLIANT, HELD};
use crate::rung::watch::Watch;
pub use crate::rung::{Motion, Rung, Start};
use nalgebra::SMatrix;

/// Levels of the ladder below a whole step: events are located to h/4^LADDER.
pub const LADDER: usize = 6;
/// Ticks in a communication step.
pub const TICKS: u32 = ticks(LADDER);
/// Doublings from one level to the next.
const DOUBLINGS: usize = 2;
/// Two communication steps count as the same within this [1].
const SAME_STEP: f64 = 1e-9;
/// ‖A t‖ below which the series of the shortest rung is exact to round-off [1].
const SERIES_REACH: f64 = 0.05;

/// Ticks that a level of the ladder spans.
pub const fn ticks(level: usize) -> u32 {
    1 << (DOUBLINGS * level)
}

/// Level of the longest block that starts `offset` ticks into a piece and fits into `rest` ticks.
pub(crate) fn level(offset: u32, rest: u32) -> usize {
    let aligned = if offset == 0 {
        u32::BITS
    } else {
        offset.trailing_zeros()
    };
    aligned.min(rest.ilog2()) as usize / DOUBLINGS
}

/// Propagators of a step h for every choice of engaged clutches and every level of the ladder.
#[derive(Debug, Clone)]
pub struct Propagators {
    /// Communication step [s].
    pub h: f64,
    /// The driveline they were built for.
    pub systems: Systems,
    /// Gears are all that their coupling connects.
    gears_only: bool,
    /// By engaged clutches (none, 1, 2, both), then by level: level k spans 4^k ticks.
    rungs: [[Rung; LADDER + 1]; 4],
    /// By engaged clutches: what watches both over the longest rung.
    watches: [[Watch; 2]; 4],
    /// By engaged clutches: what reads the change of ω_w over the longest rung.
    wheels: [Lanes<CLUTCH_RAMPS>; 4],
}

/// The rung of a whole step, and what reads from its start where it leads.
#[derive(Clone, Copy)]
pub(crate) struct Longest<'a> {
    pub(crate) rung: &'a Rung,
    /// What watches both clutches.
    pub(crate) watches: &'a [Watch; 2],
    wheels: &'a Lanes<CLUTCH_RAMPS>,
}

impl Longest<'_> {
    /// ω_w(t) − ω_w(0) [rad/s], from the first entries of a start.
    ///
    /// `sliding`: T_c1 or T_c2 is a friction torque.
    #[inline(always)]
    pub(crate) fn wheel_speed_change<const N: usize>(&self, z: &Lanes<N>, sliding: bool) -> f64 {
        if N == COMPLIANT || sliding {
            dot(self.wheels, z)
        } else {
            dot(&self.wheels.first::<HELD>(), &z.first::<HELD>())
        }
    }
}

impl Propagators {
    /// Room for propagators, to be [`Self::rebuild`]t; as it is it fits no step.
    pub const EMPTY: Self = Self {
        h: 0.0,
        systems: Systems::EMPTY,
        gears_only: false,
        rungs: [[Rung::ZERO; LADDER + 1]; 4],
        watches: [[Watch::BLIND; 2]; 4],
        wheels: [Lanes::ZERO; 4],
    };

    /// Propagators of a driveline for a communication step.
    ///
    /// `coupling`: what is connected, or the gears alone. `h`: communication step [s], > 0 and finite.
    pub fn new(p: &Params, coupling: impl Into<Coupling>, h: f64) -> Self {
        let mut new = Self::EMPTY;
        new.rebuild(p, coupling, h);
        new
    }

    /// Turns these into the propagators of another coupling or another step, in place.
    ///
    /// Same arguments as [`Self::new`].
    pub fn rebuild(&mut self, p: &Params, coupling: impl Into<Coupling>, h: f64) {
        self.h = h;
        self.systems.connect(p, coupling.into());
        let coupling = self.systems.coupling;
        self.gears_only = coupling == coupling.gear.into();
        for (set, rungs) in self.rungs.iter_mut().enumerate() {
            if self.systems.coupling.engageable(set) == set {
                fill_ladder(rungs, &self.systems, set, self.h);
                self.wheels[set] = rungs[LADDER].wheel_row();
                let rows = &self.systems.by_stuck[set].rows;
                self.watches[set] =
                    [0, 1].map(|i| Watch::new(&rungs[LADDER], rows, i, set >> i & 1 == 1));
            }
        }
    }

    /// Whether they serve a step of `h` [s] with this coupling; within 1e-9 relative they do.
    pub fn fits(&self, coupling: impl Into<Coupling>, h: f64) -> bool {
        self.systems.coupling == coupling.into() && self.spans(h)
    }

    /// [`Self::fits`] where gears are all that is connected.
    #[inline(always)]
    pub fn fits_gears(&self, gear: [i32; 2], h: f64) -> bool {
        self.gears_only && self.systems.coupling.gear == gear && self.spans(h)
    }

    #[inline(always)]
    fn spans(&self, h: f64) -> bool {
        h == self.h || (h - self.h).abs() <= SAME_STEP * self.h
    }

    /// Rung at a level with the clutches of `stuck` (bit i: clutch i) engaged, none of a shaft that is
    /// being synchronised.
    pub fn rung(&self, stuck: usize, level: usize) -> &Rung {
        &self.rungs[stuck & 3][level.min(LADDER)]
    }
}

impl Propagators {
    /// The rung of the whole step.
    #[inline(always)]
    pub(crate) fn longest(&self, stuck: usize) -> Longest<'_> {
        Longest {
            rung: &self.rungs[stuck & 3][LADDER],
            watches: &self.watches[stuck & 3],
            wheels: &self.wheels[stuck & 3],
        }
    }
}

/// Where a plant finds the propagators of a communication step; its coupling may change within it.
pub trait Ladders {
    /// The propagators of the step with this coupling.
    fn of(&mut self, p: &Params, coupling: Coupling) -> &Propagators;

    /// [`Self::of`] where gears are all that is connected.
    #[inline(always)]
    fn of_gears(&mut self, p: &Params, gear: [i32; 2]) -> &Propagators {
        self.of(p, gear.into())
    }
}

impl Ladders for Propagators {
    fn of(&mut self, p: &Params, coupling: Coupling) -> &Propagators {
        if self.systems.coupling != coupling {
            self.rebuild(p, coupling, self.h);
        }
        self
    }
}

/// The larger of ‖A‖_1 and ‖A‖_∞ [1/s], without a copy of the matrix on the stack.
fn norm<const N: usize>(a: &SMatrix<f64, N, N>) -> f64 {
    let sum = |row: &mut dyn Iterator<Item = &f64>| row.map(|entry| entry.abs()).sum::<f64>();
    let rows = a.row_iter().map(|row| sum(&mut row.iter()));
    let columns = a.column_iter().map(|column| sum(&mut column.iter()));
    rows.chain(columns).fold(0.0, f64::max)
}

fn fill_ladder(rungs: &mut [Rung; LADDER + 1], systems: &Systems, set: usize, h: f64) {
    let system = &systems.by_stuck[set];
    let norm = norm(&system.a);
    let mut below = 0;
    let mut t = h / f64::from(TICKS);
    while norm * t > SERIES_REACH {
        t *= 0.5;
        below += 1;
    }
    let mut first = Builder::ZERO;
    let active = Active::new(system, set);
    first.base(systems, set, &active, t, norm * t);
    climb(rungs, &mut first, below, systems, &active);
}

/// Fills a ladder from its base, which lies `below` doublings under the lowest rung.
#[inline(never)] // the base needs the stack that the second builder takes here
fn climb(
    rungs: &mut [Rung; LADDER + 1],
    base: &mut Builder,
    below: usize,
    systems: &Systems,
    active: &Active,
) {
    let mut other = Builder::ZERO;
    let (mut rung, mut twice) = (base, &mut other);
    for (level, place) in rungs.iter_mut().enumerate() {
        for _ in 0..if level == 0 { below } else { DOUBLINGS } {
            twice.double(rung, systems, active);
            core::mem::swap(&mut rung, &mut twice);
        }
        place.take(rung, systems);
    }
}

#[cfg(test)]
mod tests {
    use super::{DOUBLINGS, LADDER, Propagators};
    use crate::Params;
    use crate::matrices::{State, Torques, W};

    const H: f64 = 1e-3;

    fn start() -> (State, Torques, Torques) {
        let x = [
            200.0, 198.0, 190.0, 190.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ];
        let (v, v_dot) = ([60.0, 40.0, -25.0, 300.0], [2e3, -1e3, 5e2, 1e4]);
        (x.into(), v.into(), v_dot.into())
    }

    #[test]
    fn shortest_rung_follows_the_derivative() {
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], H / 1e3);
        let (x, v, v_dot) = start();
        for set in 0..4_usize {
            let rung = propagators.rung(set, 0);
            let start = rung.start(&x, &v, &v_dot);
            let slope = (rung.motion(&start).end(&x) - x) / rung.t;
            let x_dot = propagators.systems.by_stuck[set].derivative(&x, &v);
            assert!((slope - x_dot).amax() < 1e-3 * x_dot.amax(), "{set}");
        }
    }

    /// Motion, work and loss over `count` times the span of a rung.
    fn repeated(
        propagators: &Propagators,
        set: usize,
        level: usize,
        count: usize,
    ) -> (State, Torques, f64) {
        let rung = propagators.rung(set, level);
        let ((mut x, mut v, v_dot), mut work, mut loss) = (start(), Torques::zeros(), 0.0);
        for _ in 0..count {
            let start = rung.start(&x, &v, &v_dot);
            let motion = rung.motion(&start);
            work += rung.work(&start, &motion);
            loss += rung.viscous_loss(&start);
            (x, v) = (motion.end(&x), v + rung.t * v_dot);
        }
        (x, work, loss)
    }

    #[test]
    fn a_rung_is_several_of_the_one_below() {
        let rigid = Params {
            rigid: true,
            ..Params::TABLE_1
        };
        for (p, gear) in [
            (&Params::TABLE_1, [1, 2]),
            (&Params::TABLE_1, [0, 2]),
            (&rigid, [1, 2]),
            (&rigid, [0, 2]),
        ] {
            let propagators = Propagators::new(p, gear, H);
            for (set, level) in (0..4).flat_map(|set| (1..=LADDER).map(move |level| (set, level))) {
                let (long, work, loss) = repeated(&propagators, set, level, 1);
                let (end, sum, lost) = repeated(&propagators, set, level - 1, 1 << DOUBLINGS);
                assert!((long - end).amax() < 1e-9);
                assert!((work - sum).amax() < 1e-9 * work.amax());
                assert!((loss - lost).abs() < 1e-9 * loss);
            }
        }
    }

    #[test]
    fn effect_of_the_load_ramp_is_the_one_of_the_motion() {
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], H);
        let rung = propagators.rung(1, LADDER);
        let (x, v, v_dot) = start();
        let mut start = rung.start(&x, &v, &v_dot);
        let mut motion = rung.motion(&start);
        let before = motion.wheel_speed(&x);
        assert!((before - motion.end(&x)[W]).abs() < 1e-12);
        rung.add_ramp(&mut motion, 3, 1e6);
        start.add_ramp(3, 1e6);
        assert!((motion.end(&x) - rung.motion(&start).end(&x)).amax() < 1e-9);
        let change = motion.wheel_speed(&x) - before;
        assert!((change - 1e6 * rung.wheel_speed_by_load_ramp()).abs() < 1e-9 * change.abs());
    }

    #[test]
    fn rebuilt_equals_new() {
        let p = Params::TABLE_1;
        let mut rebuilt = Propagators::new(&p, [1, 2], H);
        rebuilt.rebuild(&p, [1, 0], 3.0 * H);
        let new = Propagators::new(&p, [1, 0], 3.0 * H);
        assert!(rebuilt.fits([1, 0], 3.0 * H) && !rebuilt.fits([1, 2], 3.0 * H));
        let (x, v, v_dot) = start();
        let end = |propagators: &Propagators| {
            let rung = propagators.rung(2, 5);
            let start = rung.start(&x, &v, &v_dot);
            rung.motion(&start).end(&x)
        };
        assert_eq!(end(&rebuilt), end(&new));
    }
}
