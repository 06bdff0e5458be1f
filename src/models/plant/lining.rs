//! Rows of the linings: how their friction varies.

use super::Plant;
use crate::vehicle::{indexed, invalid};
use dct_driveline::Params;
use dct_driveline::friction::CURVE_POINTS;
use fmi2_cosim::{Failure, Unit, Variable};

const CURVE_SLIP: [[&str; CURVE_POINTS]; 2] = [
    indexed!("clutch1.frictionCurve.slip": 1, 2, 3, 4, 5),
    indexed!("clutch2.frictionCurve.slip": 1, 2, 3, 4, 5),
];
const CURVE_FACTOR: [[&str; CURVE_POINTS]; 2] = [
    indexed!("clutch1.frictionCurve.factor": 1, 2, 3, 4, 5),
    indexed!("clutch2.frictionCurve.factor": 1, 2, 3, 4, 5),
];

/// The friction curve of clutch `I`.
pub(super) const fn lining<const I: usize>() -> [Variable<Plant>; 2 * CURVE_POINTS] {
    [
        curve_slip::<I, 0>(),
        curve_slip::<I, 1>(),
        curve_slip::<I, 2>(),
        curve_slip::<I, 3>(),
        curve_slip::<I, 4>(),
        curve_factor::<I, 0>(),
        curve_factor::<I, 1>(),
        curve_factor::<I, 2>(),
        curve_factor::<I, 3>(),
        curve_factor::<I, 4>(),
    ]
}

const fn curve_slip<const I: usize, const K: usize>() -> Variable<Plant> {
    Variable::parameter(
        CURVE_SLIP[I][K],
        Unit::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.p.clutch[I].curve.slip[K],
        "|slip| of a point of the friction curve, ascending; all 0: kineticFriction at any slip",
    )
    .min(0.0)
}

const fn curve_factor<const I: usize, const K: usize>() -> Variable<Plant> {
    Variable::parameter(
        CURVE_FACTOR[I][K],
        Unit::ONE,
        |m: &mut Plant| &mut m.p.clutch[I].curve.factor[K],
        "Factor on kineticFriction at a point of the friction curve, linear between, constant outside",
    )
    .min(0.0)
}

/// Refuses curves that are no functions, and factors without slips: they would not act.
pub(super) fn check_curves(p: &Params) -> Result<(), Failure> {
    for (i, clutch) in p.clutch.iter().enumerate() {
        let (slip, factor) = (clutch.curve.slip, clutch.curve.factor);
        if slip == [0.0; CURVE_POINTS] {
            if let Some(k) = factor.iter().position(|factor| *factor != 1.0) {
                let remedy = "does not act while all slips of the curve are 0: set them, ascending";
                return Err(invalid(CURVE_FACTOR[i][k], factor[k], remedy));
            }
            continue;
        }
        for k in 1..CURVE_POINTS {
            if slip[k] <= slip[k - 1] {
                let remedy = "must be above the slip before it; all slips 0 is no curve";
                return Err(invalid(CURVE_SLIP[i][k], slip[k], remedy));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::check_curves;
    use dct_driveline::Params;
    use dct_driveline::friction::FrictionCurve;

    #[test]
    fn a_curve_ascends_or_is_not_there() {
        let ascending = [0.0, 5.0, 20.0, 60.0, 150.0];
        let cases = [
            ([0.0; 5], 1.0, ""),
            (ascending, 0.8, ""),
            (
                [0.0; 5],
                0.8,
                "clutch2.frictionCurve.factor[3] = 0.8 does not act",
            ),
            (
                [0.0, 5.0, 5.0, 60.0, 150.0],
                1.0,
                "clutch2.frictionCurve.slip[3] = 5 must be above",
            ),
            (
                [0.0, 5.0, 20.0, 60.0, 0.0],
                1.0,
                "clutch2.frictionCurve.slip[5] = 0 must be above",
            ),
        ];
        for (slip, third, said) in cases {
            let (mut p, factor) = (Params::TABLE_1, [1.0, 1.0, third, 1.0, 1.0]);
            p.clutch[1].curve = FrictionCurve { slip, factor };
            let found =
                check_curves(&p).map_or_else(|failure| failure.to_string(), |()| String::new());
            assert!(
                found.starts_with(said) && found.is_empty() == said.is_empty(),
                "{found}"
            );
        }
    }
}
