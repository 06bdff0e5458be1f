//! Friction over the position of both clutches, as `calibrating` learns it.

use crate::observer::Observer;
use crate::vehicle::indexed;
use dct_driveline::observer::friction_map::POINTS;
use fmi2_cosim::{Unit as U, Variable};

const LEARNT: [[&str; POINTS]; 2] = [
    indexed!("clutch1.frictionMap": 1, 2, 3, 4, 5),
    indexed!("clutch2.frictionMap": 1, 2, 3, 4, 5),
];
const DEVIATION: [[&str; POINTS]; 2] = [
    indexed!("clutch1.frictionMapDeviation": 1, 2, 3, 4, 5),
    indexed!("clutch2.frictionMapDeviation": 1, 2, 3, 4, 5),
];
const SIGMA: [[&str; POINTS]; 2] = [
    indexed!("clutch1.frictionMapSigma": 1, 2, 3, 4, 5),
    indexed!("clutch2.frictionMapSigma": 1, 2, 3, 4, 5),
];

/// μ at five positions of clutch `I`, and how well it is known.
pub(super) const fn learnt<const I: usize>() -> [Variable<Observer>; 2 * POINTS] {
    [
        mu::<I, 0>(),
        mu::<I, 1>(),
        mu::<I, 2>(),
        mu::<I, 3>(),
        mu::<I, 4>(),
        deviation::<I, 0>(),
        deviation::<I, 1>(),
        deviation::<I, 2>(),
        deviation::<I, 3>(),
        deviation::<I, 4>(),
    ]
}

/// How well it is known at the start.
pub(super) const fn believed<const I: usize>() -> [Variable<Observer>; POINTS] {
    [
        sigma::<I, 0>(),
        sigma::<I, 1>(),
        sigma::<I, 2>(),
        sigma::<I, 3>(),
        sigma::<I, 4>(),
    ]
}

const fn mu<const I: usize, const K: usize>() -> Variable<Observer> {
    let field: fn(&mut Observer) -> &mut f64 = |m| &mut m.y.calibration.friction[I][K];
    Variable::output(
        LEARNT[I][K],
        U::ONE,
        field,
        "Friction at one of five positions, evenly from the touch point to the end of the map; 0 of other methods",
    )
    .depends_on(&[])
}

const fn deviation<const I: usize, const K: usize>() -> Variable<Observer> {
    let field: fn(&mut Observer) -> &mut f64 = |m| &mut m.y.calibration.friction_deviation[I][K];
    Variable::output(
        DEVIATION[I][K],
        U::ONE,
        field,
        "Standard deviation of frictionMap",
    )
    .depends_on(&[])
}

const fn sigma<const I: usize, const K: usize>() -> Variable<Observer> {
    let field: fn(&mut Observer) -> &mut f64 = |m| &mut m.settings.calibrating.friction[I][K];
    Variable::parameter(
        SIGMA[I][K],
        U::ONE,
        field,
        "Standard deviation of frictionMap at the start, where it is nominalFriction",
    )
    .min(0.0)
}
