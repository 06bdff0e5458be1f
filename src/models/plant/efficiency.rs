//! Rows of the gears' efficiencies.

use super::Plant;
use crate::vehicle::indexed;
use dct_driveline::params::GEARS_PER_SHAFT;
use fmi2_cosim::{Unit, Variable};

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
