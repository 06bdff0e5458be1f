//! What a clutch is watched by over the longest rung: rows that read its guards from where the rung starts.

use crate::matrices::{C, D, Rows, State};
use crate::rung::Rung;
use crate::rung::lanes::{Lanes, dot, dot_apart};
use crate::rung::start::{CLUTCH_RAMPS, COLUMNS, RAMP};

/// Rows for a clutch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Watch {
    /// Of an engaged one: its torque at the start and at the end of the rung [N·m], the rate of it at the start
    /// [N·m/s]. Of another one: nothing, the change of its slip over the rung [rad/s], the rate of it at the start
    /// [rad/s²].
    rows: [Lanes<CLUTCH_RAMPS>; 3],
    /// What an entry by its size can make at most of that torque, at both ends and along the tangent at the start.
    most: Lanes<CLUTCH_RAMPS>,
}

impl Watch {
    pub(crate) const BLIND: Self = Self {
        rows: [Lanes::ZERO; 3],
        most: Lanes::ZERO,
    };

    /// For clutch `i`, `engaged` or not, of a driveline whose guards read `rows`.
    pub(crate) fn new(rung: &Rung, rows: &Rows, i: usize, engaged: bool) -> Self {
        let rows = if engaged {
            of_torque(rung, rows, i)
        } else {
            of_slip(rung, rows, i)
        };
        let [start, end, rate] = &rows;
        let most = |entry: usize| {
            let along = start[entry].abs() + rung.t * rate[entry].abs();
            along.max(end[entry].abs())
        };
        Self {
            rows,
            most: Lanes(core::array::from_fn(most)),
        }
    }

    /// Of an engaged clutch its torque at the start and at the end, and the rate of it at the start.
    pub(crate) fn read<const N: usize>(&self, z: &Lanes<N>) -> [f64; 3] {
        [0, 1, 2].map(|row| dot_apart(&self.rows[row], z))
    }

    /// A bound of the torque [N·m] of an engaged clutch: at both ends, and where the tangent at the start leads to.
    #[inline(always)]
    pub(crate) fn most<const N: usize>(&self, z: &Lanes<N>) -> f64 {
        dot(&self.most, &Lanes(z.map(f64::abs)))
    }

    /// Of a clutch that slides the change of its slip, and the rate of it at the start.
    #[inline(always)]
    pub(crate) fn slip<const N: usize>(&self, z: &Lanes<N>) -> [f64; 2] {
        [1, 2].map(|row| dot(&self.rows[row], z))
    }
}

fn of_torque(rung: &Rung, rows: &Rows, i: usize) -> [Lanes<CLUTCH_RAMPS>; 3] {
    let (torque, held) = (&rows.torque[i], State::zeros());
    let ramp = |entry: usize| match COLUMNS[entry].checked_sub(RAMP) {
        Some(q) => torque.of_torque(q, 1.0),
        None => 0.0,
    };
    let end = |entry: usize| {
        let change = rung.change_by(entry);
        torque.of_column(&change, COLUMNS[entry]) + rung.t * ramp(entry)
    };
    let rate = |entry: usize| rows.torque_rate[i].of_column(&held, COLUMNS[entry]) + ramp(entry);
    [
        Lanes(core::array::from_fn(|entry| {
            torque.of_column(&held, COLUMNS[entry])
        })),
        Lanes(core::array::from_fn(end)),
        Lanes(core::array::from_fn(rate)),
    ]
}

fn of_slip(rung: &Rung, rows: &Rows, i: usize) -> [Lanes<CLUTCH_RAMPS>; 3] {
    let change = |entry: usize| {
        let change = rung.change_by(entry);
        change[D] - change[C + i]
    };
    let rate = |entry: usize| rows.slip_rate[i].of_column(&State::zeros(), COLUMNS[entry]);
    [
        Lanes::ZERO,
        Lanes(core::array::from_fn(change)),
        Lanes(core::array::from_fn(rate)),
    ]
}

#[cfg(test)]
mod tests {
    use crate::Params;
    use crate::integrate::{LADDER, Propagators};
    use crate::matrices::{C, D, State, Torques};
    use crate::rung::start::{COMPLIANT, RIGID};

    #[test]
    fn it_reads_what_the_rows_and_the_motion_show_at_both_ends() {
        for rigid in [false, true] {
            let p = Params {
                rigid,
                ..Params::TABLE_1
            };
            let propagators = Propagators::new(&p, [1, 2], 1e-3);
            let g = propagators.systems.ratio;
            let x = State::from([
                200.0,
                198.0,
                12.0 * g[0],
                12.0 * g[1],
                12.0,
                11.9,
                0.03,
                0.0,
                0.0,
                0.05,
            ]);
            let (v, load_ramp) = (Torques::from([60.0, 40.0, -25.0, 300.0]), 1e4);
            let v_dot = Torques::from([0.0, 0.0, 0.0, load_ramp]);
            for set in 0..4_usize {
                let (rung, watches) = (
                    propagators.longest(set).rung,
                    propagators.longest(set).watches,
                );
                let rows = &propagators.systems.by_stuck[set].rows;
                let start = rung.start(&x, &v, &v_dot);
                let (x_end, v_end) = (rung.motion(&start).end(&x), v + v_dot * rung.t);
                for i in [0, 1] {
                    let wanted = if set >> i & 1 == 1 {
                        let rate = rows.torque_rate[i].of(&x, &v);
                        [
                            rows.torque[i].of(&x, &v),
                            rows.torque[i].of(&x_end, &v_end),
                            rate + rows.torque[i].of_torques(&v_dot),
                        ]
                    } else {
                        let change = x_end - x;
                        [0.0, change[D] - change[C + i], rows.slip_rate[i].of(&x, &v)]
                    };
                    let (found, most) = if rigid {
                        let z = start.entries.first::<RIGID>();
                        (watches[i].read(&z), watches[i].most(&z))
                    } else {
                        let z = start.entries.first::<COMPLIANT>();
                        (watches[i].read(&z), watches[i].most(&z))
                    };
                    for (found, wanted) in found.iter().zip(wanted) {
                        let apart = (found - wanted).abs();
                        assert!(apart < 1e-9 * wanted.abs().max(1.0), "{found} {wanted}");
                    }
                    let [torque, end, rate] = wanted.map(f64::abs);
                    assert!(most >= (torque + rate * rung.t).max(end));
                }
            }
            assert!(propagators.rung(0, LADDER).t == 1e-3);
        }
    }
}
