//! Motion, work and losses where torques are held, but for the load's ramp: those of an ordinary step.
//!
//! Of the entries of a start only the first `N` count then: [`RIGID`] of them, or [`COMPLIANT`] where shafts move
//! by themselves. As many rows say where the rung leads.

use crate::matrices::{C, D, E, O, State, TWIST_D, TWIST_O, TWIST_T, W};
use crate::rung::Rung;
use crate::rung::lanes::{Lanes, add, dot};
use crate::rung::motion::{ALL, MAIN, Motion};
use crate::rung::start::{CLUTCHES, COMPLIANT, CORE, RAMPS, RIGID, SHAFTS, Start, TORQUE};

const _: () = assert!(RIGID == MAIN && COMPLIANT == ALL);

/// What a rung makes of a start whose torques are held.
pub(crate) struct Held<'a, const N: usize> {
    /// The entries that count.
    z: &'a Lanes<N>,
    /// T_c1 or T_c2 is a friction torque.
    sliding: bool,
    /// Change of the state, angles and moments: the rows of a [`Motion`](crate::rung::motion::Motion).
    pub(crate) rows: [f64; N],
}

/// The first entries of a start.
///
/// `torques`: T_e, T_v [N·m]. `friction`: T_c1, T_c2 [N·m].
#[inline(always)]
pub(crate) fn entries<const N: usize>(
    rung: &Rung,
    x: &State,
    torques: [f64; 2],
    friction: [f64; 2],
) -> Lanes<N> {
    let (x, mut z) = (&x.data.0[0], Lanes::ZERO);
    (z[0], z[1]) = (x[TWIST_D], x[TWIST_O]);
    (z[2], z[3]) = (x[E] - x[D], x[W] - x[O]);
    (z[TORQUE[0]], z[TORQUE[3]]) = (torques[0], torques[1]);
    (z[CLUTCHES], z[CLUTCHES + 1]) = (friction[0], friction[1]);
    if N == COMPLIANT {
        for i in [0, 1] {
            z[SHAFTS + i] = x[TWIST_T + i];
            z[SHAFTS + 2 + i] = x[C + i] - rung.ratio[i] * x[O];
        }
    }
    z
}

impl<'a, const N: usize> Held<'a, N> {
    /// Motion from the first entries of a start.
    ///
    /// `sliding`: T_c1 or T_c2 is a friction torque.
    #[inline(always)]
    pub(crate) fn new(rung: &Rung, x: &State, z: &'a Lanes<N>, sliding: bool) -> Self {
        let mut rows = [-0.0; N]; // what a first sum leaves as it is
        for (column, z) in rung.columns[..CORE].iter().zip(&z[..]) {
            add(&mut rows, column, *z);
        }
        if N == COMPLIANT {
            for (column, z) in rung.columns[SHAFTS..].iter().zip(&z[SHAFTS..]) {
                add(&mut rows, column, *z);
            }
        }
        if sliding {
            for (column, z) in rung.columns[CLUTCHES..].iter().zip(&z[CLUTCHES..SHAFTS]) {
                if *z != 0.0 {
                    add(&mut rows, column, *z);
                }
            }
        }
        let (engine, wheels) = (x[E] * rung.t, x[W] * rung.t);
        (rows[6], rows[7]) = (rows[6] + engine, rows[7] + wheels);
        let half = 0.5 * rung.t;
        (rows[8], rows[9]) = (rows[8] + half * wheels, rows[9] + half * engine);
        Self { z, sliding, rows }
    }

    /// x(t), from x(0).
    #[inline(always)]
    pub(crate) fn end(&self, rung: &Rung, x: &mut State) {
        let rows = &self.rows;
        (x[E], x[D]) = (x[E] + rows[0], x[D] + rows[1]);
        (x[O], x[W]) = (x[O] + rows[2], x[W] + rows[3]);
        (x[TWIST_D], x[TWIST_O]) = (x[TWIST_D] + rows[4], x[TWIST_O] + rows[5]);
        for i in [0, 1] {
            if N == COMPLIANT {
                x[C + i] += rows[MAIN + i];
                x[TWIST_T + i] += rows[MAIN + 2 + i];
            } else {
                x[C + i] = rung.ratio[i] * x[O];
            }
        }
    }

    /// Work of T_e and of T_v, and of their ramps [J].
    #[inline(always)]
    pub(crate) fn work(&self) -> [f64; 2] {
        let (z, rows) = (self.z, &self.rows);
        let engine = z[TORQUE[0]] * rows[6] + z[RAMPS[0]] * rows[9];
        let load = z[TORQUE[3]] * rows[7] + z[RAMPS[3]] * rows[8];
        [engine, load]
    }

    /// Work of friction torques [J], shape (2); None: there are none.
    ///
    /// `x`: state at the start.
    #[inline(always)]
    pub(crate) fn friction_work(&self, rung: &Rung, x: &State) -> Option<[f64; 2]> {
        let work = |i: usize| match self.z[CLUTCHES + i] {
            0.0 => 0.0,
            torque => torque * rung.worked_angle(x, self.z, i),
        };
        self.sliding.then(|| [work(0), work(1)])
    }

    /// Energy lost in dampers and meshes [J].
    ///
    /// `x`: state at the start.
    #[inline(always)]
    pub(crate) fn viscous_loss(&self, rung: &Rung, x: &State) -> f64 {
        rung.loss.of_held(self.z, self.sliding, x[O])
    }
}

impl Rung {
    /// Motion from a start, as if no torque but the load had a ramp.
    #[inline(never)] // a function of its own has registers for it
    pub(super) fn motion_held(&self, start: &Start) -> Motion {
        let (x, entries) = (&start.x, &start.entries);
        let sliding = [1, 2].map(|q| start.torque(q)) != [0.0; 2];
        if self.rigid {
            let rigid = Held::<RIGID>::new(self, x, &entries.first(), sliding).rows;
            let shafts = self.ratio.map(|ratio| ratio * rigid[2]);
            let mut rows = [0.0; ALL];
            rows[..MAIN].copy_from_slice(&rigid);
            rows[MAIN..MAIN + 2].copy_from_slice(&shafts);
            Motion(rows)
        } else {
            Motion(Held::<COMPLIANT>::new(self, x, &entries.first(), sliding).rows)
        }
    }

    /// ∫ of what T_c1 or T_c2 works on [rad].
    #[inline(always)]
    pub(super) fn worked_angle<const N: usize>(&self, x: &State, z: &Lanes<N>, i: usize) -> f64 {
        self.worked_speed(x, i) * self.t + dot(&self.slips[i], z)
    }
}
