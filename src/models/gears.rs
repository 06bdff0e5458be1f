//! Rows of the two shafts with their gears, shared by every model that knows the vehicle.

use crate::vehicle::{Vehicle, indexed, not_negative, positive};
use dct_driveline::params::GEARS_PER_SHAFT;
use fmi2_cosim::{Unit, Variable};

/// Highest number of a gear.
pub(crate) const HIGHEST_GEAR: f64 = 8.0;
const _: () = assert!(GEARS_PER_SHAFT == 4, "the rows name four gears per shaft");

/// Final drive, inertia, ratios and inertias of the gears of shaft `I`.
pub(crate) const fn shaft<M: Vehicle, const I: usize>() -> [Variable<M>; 4 + 2 * GEARS_PER_SHAFT] {
    [
        positive(
            ["shaft1.finalDriveRatio", "shaft2.finalDriveRatio"][I],
            Unit::ONE,
            |m: &mut M| &mut m.params().i_f[I],
            "i_f of (8): final-drive ratio of this shaft",
        ),
        positive(
            ["clutch1.inertia", "clutch2.inertia"][I],
            Unit::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_ct[I],
            "J_ct of (4), (5): inertia of input and transfer shaft, seen at the clutch",
        ),
        ratio::<M, I, 0>(),
        ratio::<M, I, 1>(),
        ratio::<M, I, 2>(),
        ratio::<M, I, 3>(),
        not_negative(
            ["shaft1.reverseRatio", "shaft2.reverseRatio"][I],
            Unit::ONE,
            |m: &mut M| &mut m.params().i_r[I],
            "i_t of the reverse gear, which turns the output the other way; 0: none",
        ),
        inertia::<M, I, 0>(),
        inertia::<M, I, 1>(),
        inertia::<M, I, 2>(),
        inertia::<M, I, 3>(),
        not_negative(
            ["shaft1.reverseInertia", "shaft2.reverseInertia"][I],
            Unit::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_r[I],
            "What the reverse gear adds to J_ct while it is in, seen at the clutch",
        ),
    ]
}

const fn ratio<M: Vehicle, const I: usize, const K: usize>() -> Variable<M> {
    let names = [
        indexed!("shaft1.gearRatio": 1, 2, 3, 4),
        indexed!("shaft2.gearRatio": 1, 2, 3, 4),
    ];
    let descriptions = [
        [
            "i_t of gear 1",
            "i_t of gear 3",
            "i_t of gear 5",
            "i_t of gear 7",
        ],
        [
            "i_t of gear 2",
            "i_t of gear 4",
            "i_t of gear 6",
            "i_t of gear 8",
        ],
    ];
    not_negative(
        names[I][K],
        Unit::ONE,
        |m: &mut M| &mut m.params().i_t[I][K],
        descriptions[I][K],
    )
}

const fn inertia<M: Vehicle, const I: usize, const K: usize>() -> Variable<M> {
    let names = [
        indexed!("shaft1.gearInertia": 1, 2, 3, 4),
        indexed!("shaft2.gearInertia": 1, 2, 3, 4),
    ];
    let descriptions = [
        [
            "What gear 1 adds to J_ct while it is in, seen at the clutch",
            "What gear 3 adds to J_ct while it is in, seen at the clutch",
            "What gear 5 adds to J_ct while it is in, seen at the clutch",
            "What gear 7 adds to J_ct while it is in, seen at the clutch",
        ],
        [
            "What gear 2 adds to J_ct while it is in, seen at the clutch",
            "What gear 4 adds to J_ct while it is in, seen at the clutch",
            "What gear 6 adds to J_ct while it is in, seen at the clutch",
            "What gear 8 adds to J_ct while it is in, seen at the clutch",
        ],
    ];
    not_negative(
        names[I][K],
        Unit::KILOGRAM_SQUARE_METRE,
        |m: &mut M| &mut m.params().j_gear[I][K],
        descriptions[I][K],
    )
}
