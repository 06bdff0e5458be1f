//! What a clutch is watched by over the longest rung: rows that read its guards from where the rung starts.

use crate::integrate::Rung;
use crate::plant::matrices::{Rows, State};
use crate::rung::RAMP;
use crate::rung::lanes::{Lanes, dot, dot_apart};
use crate::rung::start::{CLUTCH_RAMPS, COLUMNS};

/// Rows for a clutch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Watch {
    /// Its torque at the start and at the end of the rung [N·m], and at the start the rate of that torque [N·m/s]
    /// where it is engaged, else that of its slip [rad/s²].
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
        let torque = |x: &State, entry: usize| rows.torque[i].of_column(x, COLUMNS[entry]);
        let rate = if engaged {
            &rows.torque_rate[i]
        } else {
            &rows.slip_rate[i]
        };
        let ramp = |entry: usize| match COLUMNS[entry].checked_sub(RAMP) {
            Some(q) => rows.torque[i].of_torque(q, 1.0),
            None => 0.0,
        };
        let held = State::zeros();
        let rows = [
            Lanes(core::array::from_fn(|entry| torque(&held, entry))),
            Lanes(core::array::from_fn(|entry| {
                let change = rung.change_by(entry);
                torque(&change, entry) + rung.t * ramp(entry)
            })),
            Lanes(core::array::from_fn(|entry| {
                let by_ramp = if engaged { ramp(entry) } else { 0.0 };
                rate.of_column(&held, COLUMNS[entry]) + by_ramp
            })),
        ];
        let [start, end, rate] = &rows;
        let most =
            |entry: usize| (start[entry].abs() + rung.t * rate[entry].abs()).max(end[entry].abs());
        Self {
            rows,
            most: Lanes(core::array::from_fn(most)),
        }
    }

    /// What the rows read from the first entries of a start.
    #[inline(always)]
    pub(crate) fn read<const N: usize>(&self, z: &Lanes<N>) -> [f64; 3] {
        [0, 1, 2].map(|row| dot_apart(&self.rows[row], z))
    }

    /// A bound of the torque [N·m] of an engaged clutch: at both ends, and where the tangent at the start leads to.
    #[inline(always)]
    pub(crate) fn most<const N: usize>(&self, z: &Lanes<N>) -> f64 {
        dot(&self.most, &Lanes(z.map(f64::abs)))
    }

    /// The rate alone.
    pub(crate) fn rate<const N: usize>(&self, z: &Lanes<N>) -> f64 {
        dot_apart(&self.rows[2], z)
    }
}

#[cfg(test)]
mod tests {
    use crate::Params;
    use crate::integrate::{LADDER, Propagators};
    use crate::plant::matrices::{State, Torques};
    use crate::rung::held::{COMPLIANT, RIGID};

    #[test]
    fn it_reads_what_the_rows_read_at_both_ends() {
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
                let (rung, watches) = propagators.longest(set);
                let rows = &propagators.systems.by_stuck[set].rows;
                let start = rung.start(&x, &v, &v_dot);
                let (x_end, v_end) = (rung.motion(&start).end(&x), v + v_dot * rung.t);
                for i in [0, 1] {
                    let rate = if set >> i & 1 == 1 {
                        rows.torque_rate[i].of(&x, &v) + rows.torque[i].of_torques(&v_dot)
                    } else {
                        rows.slip_rate[i].of(&x, &v)
                    };
                    let wanted = [
                        rows.torque[i].of(&x, &v),
                        rows.torque[i].of(&x_end, &v_end),
                        rate,
                    ];
                    let found = if rigid {
                        watches[i].read::<RIGID>(&start.entries.first())
                    } else {
                        watches[i].read::<COMPLIANT>(&start.entries.first())
                    };
                    for (found, wanted) in found.iter().zip(wanted) {
                        let apart = (found - wanted).abs();
                        assert!(apart < 1e-9 * wanted.abs().max(1.0), "{found} {wanted}");
                    }
                }
            }
            assert!(propagators.rung(0, LADDER).t == 1e-3);
        }
    }
}
