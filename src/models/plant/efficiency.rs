//! Rows of the gears' efficiencies.

use super::Plant;
use crate::vehicle::{indexed, invalid};
use dct_driveline::Params;
use dct_driveline::params::GEARS_PER_SHAFT;
use fmi2_cosim::{Failure, Unit, Variable};

/// Smallest efficiency [1]: below it a gear that is driven locks itself.
const LEAST: f64 = 0.5;

const GEARS: [[&str; GEARS_PER_SHAFT]; 2] = [
    indexed!("shaft1.gearEfficiency": 1, 2, 3, 4),
    indexed!("shaft2.gearEfficiency": 1, 2, 3, 4),
];
const REVERSE: [&str; 2] = ["shaft1.reverseEfficiency", "shaft2.reverseEfficiency"];

/// The efficiencies of the gears of shaft `I`.
pub(super) const fn efficiencies<const I: usize>() -> [Variable<Plant>; GEARS_PER_SHAFT + 1] {
    [
        gear::<I, 0>(),
        gear::<I, 1>(),
        gear::<I, 2>(),
        gear::<I, 3>(),
        Variable::parameter(
            REVERSE[I],
            Unit::ONE,
            |m: &mut Plant| &mut m.p.eta_r[I],
            "Efficiency of the reverse gear with its final drive",
        )
        .min(LEAST)
        .max(1.0),
    ]
}

const fn gear<const I: usize, const K: usize>() -> Variable<Plant> {
    let descriptions = [
        [
            "Efficiency of gear 1 with its final drive: torque on the output times or, driven, by it",
            "Efficiency of gear 3 with its final drive",
            "Efficiency of gear 5 with its final drive",
            "Efficiency of gear 7 with its final drive",
        ],
        [
            "Efficiency of gear 2 with its final drive: torque on the output times or, driven, by it",
            "Efficiency of gear 4 with its final drive",
            "Efficiency of gear 6 with its final drive",
            "Efficiency of gear 8 with its final drive",
        ],
    ];
    Variable::parameter(
        GEARS[I][K],
        Unit::ONE,
        |m: &mut Plant| &mut m.p.eta[I][K],
        descriptions[I][K],
    )
    .min(LEAST)
    .max(1.0)
}

/// Refuses efficiencies that would not act.
pub(super) fn check_efficiencies(p: &Params) -> Result<(), Failure> {
    if !p.rigid {
        return Ok(());
    }
    for i in [0, 1] {
        let gears = GEARS[i].into_iter().zip(p.eta[i]);
        let mut all = gears.chain([(REVERSE[i], p.eta_r[i])]);
        if let Some((name, eta)) = all.find(|(_, eta)| *eta != 1.0) {
            let remedy = "does not act on rigid transfer shafts: set transmission.rigid to false";
            return Err(invalid(name, eta, remedy));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_efficiencies;
    use dct_driveline::Params;

    #[test]
    fn rigid_shafts_take_no_efficiency() {
        let mut p = Params::TABLE_1;
        p.eta[1][0] = 0.97;
        assert!(check_efficiencies(&p).is_ok());
        p.rigid = true;
        let said = check_efficiencies(&p).map_err(|failure| failure.to_string());
        let expected = "shaft2.gearEfficiency[1] = 0.97 does not act on rigid transfer shafts";
        assert!(said.is_err_and(|text| text.starts_with(expected)));
        p.eta[1][0] = 1.0;
        assert!(check_efficiencies(&p).is_ok());
    }
}
