//! The table of `DctClutchControl`.

use super::ClutchControl;
use crate::ports;
use crate::rows::table;
use crate::vehicle::actuator;
use fmi2_cosim::{Unit as U, Variable};

/// All rows; the index is the value reference.
pub(super) const VARIABLES: &[Variable<ClutchControl>] = table!(ClutchControl:
    COMMON, clutch::<0>(), clutch::<1>(), limits::<0>(), limits::<1>(),
    actuator::<_, 0>(), actuator::<_, 1>(),
);

/// Largest position of the actuators.
pub(super) const STROKE_MAXIMUM: [&str; 2] = ["clutch1.strokeMaximum", "clutch2.strokeMaximum"];

/// What a position starts from: what is asked of the clutch, how it slips, its friction and its map.
///
/// No torque of the observer and no muF is among them: a run starts without a rate and without a trim.
macro_rules! position {
    ($clutch:literal: $($point:literal),*) => {
        &[
            "feedback.enabled",
            ports::STATUS_VALID,
            ports::ENGINE_SPEED,
            concat!($clutch, ".torqueRequest"),
            concat!($clutch, ".speed"),
            concat!($clutch, ".friction"),
            concat!($clutch, ".nominalFriction"),
            concat!($clutch, ".strokeMinimum"),
            concat!($clutch, ".strokeMaximum"),
            concat!($clutch, ".effectiveRadius"),
            $(
                concat!($clutch, ".map.position[", $point, "]"),
                concat!($clutch, ".map.force[", $point, "]"),
            )*
        ]
    };
}

const POSITION: [&[&str]; 2] = [
    position!("clutch1": 1, 2, 3, 4, 5, 6, 7, 8, 9, 10),
    position!("clutch2": 1, 2, 3, 4, 5, 6, 7, 8, 9, 10),
];

const COMMON: [Variable<ClutchControl>; 4] = [
    Variable::boolean_input(
        "feedback.enabled",
        |m: &mut ClutchControl| &mut m.feedback,
        "Use the observer's estimates; otherwise the nominal friction alone (map-based control)",
    ),
    Variable::boolean_input(
        ports::STATUS_VALID,
        |m: &mut ClutchControl| &mut m.estimate.valid,
        "The observer trusts its estimate; otherwise the last friction stays and no torque is fed back",
    ),
    Variable::input(
        ports::ENGINE_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut ClutchControl| &mut m.omega_e,
        "omega_e, measured: tells the sense of the slip",
    ),
    Variable::input(
        ports::DRIVE_SHAFT_TORQUE,
        U::NEWTON_METRE,
        |m: &mut ClutchControl| &mut m.estimate.t_o,
        "T_o from the observer, for clutch1.damping and clutch2.damping",
    ),
];

const fn clutch<const I: usize>() -> [Variable<ClutchControl>; 8] {
    [
        Variable::input(
            ports::CLUTCH_TORQUE_REQUEST[I],
            U::NEWTON_METRE,
            |m: &mut ClutchControl| &mut m.request[I],
            "Torque the clutch shall carry when it slips; 0 opens it; below 0 it closes only where it \
             brakes, and waits at the touch point while the engine is faster",
        ),
        Variable::input(
            ports::CLUTCH_SPEED[I],
            U::RADIAN_PER_SECOND,
            |m: &mut ClutchControl| &mut m.omega_c[I],
            "omega_c of the input shaft, measured: tells the sense of the slip",
        ),
        Variable::input(
            ports::CLUTCH_FRICTION[I],
            U::ONE,
            |m: &mut ClutchControl| &mut m.estimate.friction[I],
            "Friction coefficient from the observer; 0: take muF instead",
        ),
        Variable::input(
            ports::CLUTCH_MU_F[I],
            U::NEWTON_PER_METRE,
            |m: &mut ClutchControl| &mut m.estimate.mu_f[I],
            "Adapted mu f from the observer, used where it gives no friction",
        ),
        Variable::input(
            ports::CLUTCH_TORQUE[I],
            U::NEWTON_METRE,
            |m: &mut ClutchControl| &mut m.estimate.t_c[I],
            "T_c from the observer, for the torque feedback of this clutch",
        ),
        Variable::output(
            ports::CLUTCH_POSITION[I],
            U::METRE,
            |m: &mut ClutchControl| &mut m.state.servo[I].position,
            "theta_m: actuator position",
        )
        .depends_on(&[])
        .initially_depends_on(POSITION[I]),
        Variable::output(
            ["clutch1.trim", "clutch2.trim"][I],
            U::ONE,
            |m: &mut ClutchControl| &mut m.state.servo[I].trim,
            "Share of the requested torque that the torque feedback adds to what the friction tells",
        )
        .depends_on(&[])
        .initially_depends_on(&[]),
        Variable::parameter(
            ports::CLUTCH_NOMINAL_FRICTION[I],
            U::ONE,
            |m: &mut ClutchControl| &mut m.nominal_friction[I],
            "mu_n: friction coefficient without feedback",
        )
        .min(0.02)
        .max(1.0)
        .tunable(),
    ]
}

const fn limits<const I: usize>() -> [Variable<ClutchControl>; 5] {
    [
        Variable::parameter(
            ["clutch1.rateLimit", "clutch2.rateLimit"][I],
            U::METRE_PER_SECOND,
            |m: &mut ClutchControl| &mut m.tuning[I].rate,
            "Fastest motion of the actuator",
        )
        .min(1e-6),
        Variable::parameter(
            ["clutch1.strokeMinimum", "clutch2.strokeMinimum"][I],
            U::METRE,
            |m: &mut ClutchControl| &mut m.tuning[I].stroke[0],
            "Smallest position of the actuator",
        )
        .min(0.0),
        Variable::parameter(
            STROKE_MAXIMUM[I],
            U::METRE,
            |m: &mut ClutchControl| &mut m.tuning[I].stroke[1],
            "Largest position of the actuator",
        )
        .min(0.0),
        Variable::parameter(
            ["clutch1.torqueGain", "clutch2.torqueGain"][I],
            U::PER_SECOND,
            |m: &mut ClutchControl| &mut m.tuning[I].torque_gain,
            "Gain of the clutch-torque feedback; 0: none",
        )
        .min(0.0)
        .tunable(),
        Variable::parameter(
            ["clutch1.damping", "clutch2.damping"][I],
            U::SECOND,
            |m: &mut ClutchControl| &mut m.tuning[I].damping,
            "Clutch torque taken back per rate of the drive-shaft torque; 0: none",
        )
        .min(0.0)
        .tunable(),
    ]
}
