//! Gears whose rigid shafts would be one: with both clutches engaged their torques could not be told apart.

use crate::vehicle::invalid;
use dct_driveline::params::{GEARS_PER_SHAFT, Params};
use fmi2_cosim::Failure;

/// Total ratios nearer to each other than this [1] leave the torques of a tie less than half of their digits.
const SAME_RATIO: f64 = 1e-6;
/// Ratios of shaft 2 by gear, the last one that of reverse.
const RATIO: [&str; GEARS_PER_SHAFT + 1] = [
    "shaft2.gearRatio[1]",
    "shaft2.gearRatio[2]",
    "shaft2.gearRatio[3]",
    "shaft2.gearRatio[4]",
    "shaft2.reverseRatio",
];

/// Refuses a gear of shaft 2 that has the total ratio of one of shaft 1, where shafts are rigid.
pub(super) fn check_ties(p: &Params) -> Result<(), Failure> {
    if !p.rigid {
        return Ok(());
    }
    let remedy = "gives with shaft2.finalDriveRatio the total ratio of a gear of shaft 1, so that both clutches \
                  would be one on rigid shafts: change it, or set transmission.rigid to false";
    let ratio = |shaft: usize, gear: usize| match p.i_t[shaft].get(gear) {
        Some(ratio) => *ratio,
        None => -p.i_r[shaft],
    };
    for (gear, name) in RATIO.into_iter().enumerate() {
        let total = ratio(1, gear) * p.i_f[1];
        let same = |other: f64| (other - total).abs() <= SAME_RATIO * total.abs();
        let tied = total != 0.0 && (0..RATIO.len()).any(|gear| same(ratio(0, gear) * p.i_f[0]));
        if tied {
            return Err(invalid(name, ratio(1, gear).abs(), remedy));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_ties;
    use dct_driveline::Params;

    #[test]
    fn rigid_shafts_do_not_share_a_ratio() {
        let mut p = Params::TABLE_1;
        (p.i_t[0][1], p.i_t[1][2]) = (1.2, 1.2 * p.i_f[0] / p.i_f[1]);
        assert!(check_ties(&p).is_ok(), "springs tell both torques");
        p.rigid = true;
        let said = check_ties(&p).map_err(|failure| failure.to_string());
        let expected = "shaft2.gearRatio[3] = 1.5 gives with shaft2.finalDriveRatio";
        assert!(
            said.as_ref().is_err_and(|text| text.starts_with(expected)),
            "{said:?}"
        );
        p.i_t[1][2] *= 1.001;
        assert!(check_ties(&p).is_ok());
        p.i_r = [2.0, 2.0 * p.i_f[0] / p.i_f[1]];
        assert!(check_ties(&p).is_err(), "reverse on both shafts");
    }

    #[test]
    fn every_preset_may_be_rigid() {
        for p in [Params::TABLE_1, Params::WET_6, Params::DRY_7] {
            assert!(check_ties(&Params { rigid: true, ..p }).is_ok());
        }
    }
}
