//! What `calibrating` learns, and what it trusts.

use super::gains::{SQUARE_SPEED_PER_SECOND, SQUARE_TORQUE_PER_SECOND};
use crate::observer::Observer;
use fmi2_cosim::{Unit as U, Variable};

/// Parameters learnt, with their standard deviations.
pub(super) const OUTPUTS: [Variable<Observer>; 18] = [
    learnt(
        "calibration.torqueScale",
        U::ONE,
        |m| &mut m.y.calibration.value[0],
        "alpha: relative error of T_e, which is scaled by 1 + alpha",
    ),
    learnt(
        "calibration.torqueScaleDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[0],
        "Standard deviation of calibration.torqueScale",
    ),
    learnt(
        "calibration.torqueBias",
        U::NEWTON_METRE,
        |m| &mut m.y.calibration.value[1],
        "beta: torque to add to T_e",
    ),
    learnt(
        "calibration.torqueBiasDeviation",
        U::NEWTON_METRE,
        |m| &mut m.y.calibration.deviation[1],
        "Standard deviation of calibration.torqueBias",
    ),
    learnt(
        "calibration.inertiaError",
        U::ONE,
        |m| &mut m.y.calibration.value[2],
        "delta: relative error of J_ed, which is scaled by 1 + delta",
    ),
    learnt(
        "calibration.inertiaErrorDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[2],
        "Standard deviation of calibration.inertiaError",
    ),
    learnt(
        "calibration.wheelSpeedBias",
        U::RADIAN_PER_SECOND,
        |m| &mut m.y.calibration.value[3],
        "w: bias of the measured wheel speed",
    ),
    learnt(
        "calibration.wheelSpeedBiasDeviation",
        U::RADIAN_PER_SECOND,
        |m| &mut m.y.calibration.deviation[3],
        "Standard deviation of calibration.wheelSpeedBias",
    ),
    learnt(
        "calibration.stiffnessError",
        U::ONE,
        |m| &mut m.y.calibration.value[4],
        "kappa: relative error of k_o, which is scaled by 1 + kappa",
    ),
    learnt(
        "calibration.stiffnessErrorDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[4],
        "Standard deviation of calibration.stiffnessError",
    ),
    learnt(
        "calibration.dampingError",
        U::ONE,
        |m| &mut m.y.calibration.value[5],
        "gamma: relative error of c_o, which is scaled by 1 + gamma",
    ),
    learnt(
        "calibration.dampingErrorDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[5],
        "Standard deviation of calibration.dampingError",
    ),
    learnt(
        "calibration.gearboxInertiaError",
        U::ONE,
        |m| &mut m.y.calibration.value[6],
        "lambda: relative error of J_out, which is scaled by 1 + lambda",
    ),
    learnt(
        "calibration.gearboxInertiaErrorDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[6],
        "Standard deviation of calibration.gearboxInertiaError",
    ),
    learnt(
        "calibration.vehicleInertiaError",
        U::ONE,
        |m| &mut m.y.calibration.value[7],
        "nu: relative error of J_v, which is scaled by 1 + nu",
    ),
    learnt(
        "calibration.vehicleInertiaErrorDeviation",
        U::ONE,
        |m| &mut m.y.calibration.deviation[7],
        "Standard deviation of calibration.vehicleInertiaError",
    ),
    learnt(
        "calibration.vehicleMass",
        U::KILOGRAM,
        |m| &mut m.y.calibration.mass[0],
        "Mass that the learnt inertia of the vehicle means; 0 of other methods",
    ),
    learnt(
        "calibration.vehicleMassDeviation",
        U::KILOGRAM,
        |m| &mut m.y.calibration.mass[1],
        "Standard deviation of calibration.vehicleMass",
    ),
];

/// A parameter that is a tenth of what it was believed to be is no calibration any more.
const RATIO: f64 = -0.9;

/// What an earlier drive learnt.
pub(super) const STARTS: [Variable<Observer>; 8] = [
    started(
        "calibration.torqueScaleStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[0],
        "calibration.torqueScale of an earlier drive",
    )
    .min(RATIO),
    started(
        "calibration.torqueBiasStart",
        U::NEWTON_METRE,
        |m| &mut m.settings.calibrating.prior.0[1],
        "calibration.torqueBias of an earlier drive",
    ),
    started(
        "calibration.inertiaErrorStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[2],
        "calibration.inertiaError of an earlier drive",
    )
    .min(RATIO),
    started(
        "calibration.wheelSpeedBiasStart",
        U::RADIAN_PER_SECOND,
        |m| &mut m.settings.calibrating.prior.0[3],
        "calibration.wheelSpeedBias of an earlier drive",
    ),
    started(
        "calibration.stiffnessErrorStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[4],
        "calibration.stiffnessError of an earlier drive",
    )
    .min(RATIO),
    started(
        "calibration.dampingErrorStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[5],
        "calibration.dampingError of an earlier drive",
    )
    .min(RATIO),
    started(
        "calibration.gearboxInertiaErrorStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[6],
        "calibration.gearboxInertiaError of an earlier drive",
    )
    .min(RATIO),
    started(
        "calibration.vehicleInertiaErrorStart",
        U::ONE,
        |m| &mut m.settings.calibrating.prior.0[7],
        "calibration.vehicleInertiaError of an earlier drive",
    )
    .min(RATIO),
];

/// Standard deviations at the start, and noises.
pub(super) const ANCHORS: [Variable<Observer>; 13] = [
    believed(
        "calibration.torqueScaleSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[0],
        "Standard deviation of calibration.torqueScale at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.torqueBiasSigma",
        U::NEWTON_METRE,
        |m| &mut m.settings.calibrating.sigma[1],
        "Standard deviation of calibration.torqueBias at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.inertiaErrorSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[2],
        "Standard deviation of calibration.inertiaError at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.wheelSpeedBiasSigma",
        U::RADIAN_PER_SECOND,
        |m| &mut m.settings.calibrating.sigma[3],
        "Standard deviation of calibration.wheelSpeedBias at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.stiffnessErrorSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[4],
        "Standard deviation of calibration.stiffnessError at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.dampingErrorSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[5],
        "Standard deviation of calibration.dampingError at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.gearboxInertiaErrorSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[6],
        "Standard deviation of calibration.gearboxInertiaError at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "calibration.vehicleInertiaErrorSigma",
        U::ONE,
        |m| &mut m.settings.calibrating.sigma[7],
        "Standard deviation of calibration.vehicleInertiaError at the start; 0 trusts the parameter: an anchor",
    ),
    believed(
        "gain.calibrating.clutch",
        U::PER_SECOND,
        |m| &mut m.settings.calibrating.q[0],
        "q_T: intensity of the friction of a slipping clutch, relative, calibrating",
    )
    .tunable(),
    believed(
        "gain.calibrating.load",
        SQUARE_TORQUE_PER_SECOND,
        |m| &mut m.settings.calibrating.q[1],
        "q_v: intensity of the load torque, at most, calibrating",
    )
    .tunable(),
    believed(
        "gain.calibrating.speed",
        SQUARE_SPEED_PER_SECOND,
        |m| &mut m.settings.calibrating.q[2],
        "q_w: intensity of the speeds, calibrating",
    )
    .tunable(),
    believed(
        "gain.calibrating.shaft",
        SQUARE_TORQUE_PER_SECOND,
        |m| &mut m.settings.calibrating.q[3],
        "q_s: intensity of the drive shaft's spring torque, calibrating",
    )
    .tunable(),
    Variable::parameter(
        "gain.calibrating.sensor",
        U::RADIAN_PER_SECOND,
        |m: &mut Observer| &mut m.settings.calibrating.sensor,
        "Largest standard deviation of a measured speed, calibrating: how much of it there is the filter hears",
    )
    .min(super::gains::SENSOR)
    .tunable(),
];

const fn learnt(
    name: &'static str,
    unit: U,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::output(name, unit, field, description).depends_on(&[])
}

const fn believed(
    name: &'static str,
    unit: U,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::parameter(name, unit, field, description).min(0.0)
}

const fn started(
    name: &'static str,
    unit: U,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::parameter(name, unit, field, description)
}
