//! Gains of every method, tunable; given for 1 ms where `gain.scheduled`.

use crate::observer::Observer;
use fmi2_cosim::{Unit as U, Variable};

/// A gain that may be zero.
const fn gain(
    name: &'static str,
    unit: U,
    field: fn(&mut Observer) -> &mut f64,
    description: &'static str,
) -> Variable<Observer> {
    Variable::parameter(name, unit, field, description)
        .min(0.0)
        .tunable()
}

/// All of them: `paper` without a prefix, the others under their names.
pub(super) const GAINS: [Variable<Observer>; 19] = [
    gain(
        "gain.L11",
        U::PER_SECOND,
        |m| &mut m.settings.gains.l_11,
        "L11 of (27), paper",
    ),
    gain(
        "gain.L22",
        U::PER_SECOND,
        |m| &mut m.settings.gains.l_22,
        "L22 of (27), paper",
    ),
    gain(
        "gain.Lc1",
        U::ONE,
        |m| &mut m.settings.gains.l_c[0],
        "L_c1 of (29), with the position in m, paper",
    ),
    gain(
        "gain.Lc2",
        U::ONE,
        |m| &mut m.settings.gains.l_c[1],
        "L_c2 of (29), with the position in m, paper",
    ),
    gain(
        "gain.lyapunov.L11",
        U::PER_SECOND,
        |m| &mut m.settings.lyapunov.l_11,
        "L11, lyapunov",
    ),
    gain(
        "gain.lyapunov.L22",
        U::PER_SECOND,
        |m| &mut m.settings.lyapunov.l_22,
        "L22, lyapunov",
    ),
    gain(
        "gain.lyapunov.Lc1",
        U::ONE,
        |m| &mut m.settings.lyapunov.l_c[0],
        "L_c1, with the position in m, lyapunov",
    ),
    gain(
        "gain.lyapunov.Lc2",
        U::ONE,
        |m| &mut m.settings.lyapunov.l_c[1],
        "L_c2, with the position in m, lyapunov",
    ),
    gain(
        "gain.p2",
        U::ONE,
        |m| &mut m.settings.lyapunov.p_2,
        "p2 of V: weight of the error of x2 over that of its energy, lyapunov",
    )
    .min(WEIGHT),
    gain(
        "gain.p3",
        U::ONE,
        |m| &mut m.settings.lyapunov.p_3,
        "p3 of V: weight of the error of c x2 - x3 over that of its energy, lyapunov",
    )
    .min(WEIGHT),
    gain(
        "gain.energy.engine",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[0],
        "l_e: correction of the engine speed, energy",
    ),
    gain(
        "gain.energy.output",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[1],
        "l_o: correction of the output speed, energy",
    ),
    gain(
        "gain.energy.wheel",
        U::PER_SECOND,
        |m| &mut m.settings.energy.l[2],
        "l_w: correction of the wheel speed, energy",
    ),
    gain(
        "gain.energy.Lc",
        U::ONE,
        |m| &mut m.settings.energy.l_c,
        "L of both clutches in N.m/rad, before it is normalised, energy",
    ),
    gain(
        "gain.kalman.clutch",
        U::ONE,
        |m| &mut m.settings.kalman.q_t,
        "q_T: intensity of the friction of a slipping clutch, relative, in 1/s, kalman",
    ),
    gain(
        "gain.kalman.load",
        U::ONE,
        |m| &mut m.settings.kalman.q_v,
        "q_v: intensity of the load torque in (N.m)2/s, kalman",
    ),
    gain(
        "gain.kalman.speed",
        U::ONE,
        |m| &mut m.settings.kalman.q_w,
        "q_w: intensity of the speeds in (rad/s)2/s, kalman",
    ),
    gain(
        "gain.kalman.shaft",
        U::ONE,
        |m| &mut m.settings.kalman.q_s,
        "q_s: intensity of the drive shaft's spring torque in (N.m)2/s, kalman",
    ),
    gain(
        "gain.kalman.sensor",
        U::RADIAN_PER_SECOND,
        |m| &mut m.settings.kalman.sigma,
        "Standard deviation of a measured speed, kalman",
    )
    .min(SENSOR),
];

/// Smallest weight of a Lyapunov function.
const WEIGHT: f64 = 1e-9;
/// Smallest deviation of a measured speed [rad/s]: without any a filter divides by zero.
pub(super) const SENSOR: f64 = 1e-4;
