//! The table of `DctObserver`.

mod calibration;
mod encoder;
mod friction_map;
mod gains;

use super::Observer;
use crate::gears::{HIGHEST_GEAR, shaft};
use crate::ports;
use crate::rows::table;
use crate::vehicle::{actuator, damper, driveline, road};
use dct_driveline::observer::{Method, Phase};
use fmi2_cosim::{Enumeration, Item, Unit as U, Variable};

/// Longest communication step [s]: beyond it no gain keeps the observer stable.
pub(super) const LONGEST_STEP: f64 = 0.1;

/// `load.method`: (11).
pub(super) const GRADE: i32 = 1;
/// `load.method`: (20).
pub(super) const ENGINE: i32 = 2;
/// `load.method`: (20) with the momentum of every inertia.
pub(super) const MOMENTUM: i32 = 3;

/// All rows; the index is the value reference.
pub(super) const VARIABLES: &[Variable<Observer>] = table!(Observer:
    INPUTS, clutch_inputs::<0>(), clutch_inputs::<1>(),
    OUTPUTS, clutch_outputs::<0>(), clutch_outputs::<1>(),
    SETTINGS, NOMINAL_FRICTION, gains::GAINS, calibration::OUTPUTS, calibration::STARTS, calibration::ANCHORS,
    driveline(), road(), damper(), shaft::<_, 0>(), shaft::<_, 1>(), actuator::<_, 0>(), actuator::<_, 1>(),
    encoder::TICKS,
    friction_map::learnt::<0>(), friction_map::learnt::<1>(),
    friction_map::believed::<0>(), friction_map::believed::<1>(),
);

static LOAD_METHOD: Enumeration = Enumeration {
    name: "LoadMethod",
    description: "How the load torque is found",
    items: &[
        Item {
            name: "grade",
            value: GRADE,
            description: "(11) from speed, road grade and brake torque; calibrating starts from it if a clutch is engaged",
        },
        Item {
            name: "engine",
            value: ENGINE,
            description: "(20) from engine torque and wheel acceleration",
        },
        Item {
            name: "momentum",
            value: MOMENTUM,
            description: "(20) with the momentum of every inertia",
        },
    ],
};

static OBSERVER_METHOD: Enumeration = Enumeration {
    name: "ObserverMethod",
    description: "Method of estimation",
    items: &[
        Item {
            name: "paper",
            value: Method::Paper as i32,
            description: "(19), (27), (29) as printed; no proof holds for these gains",
        },
        Item {
            name: "lyapunov",
            value: Method::Lyapunov as i32,
            description: "The paper's observer with weights and gains that carry its proof",
        },
        Item {
            name: "energy",
            value: Method::Energy as i32,
            description: "Physical energy as Lyapunov function, on three measured speeds",
        },
        Item {
            name: "kalman",
            value: Method::Kalman as i32,
            description: "Kalman filter on friction of slipping clutches and twist of engaged ones; needs no load method",
        },
        Item {
            name: "calibrating",
            value: Method::Calibrating as i32,
            description: "Kalman filter that learns errors of engine torque, inertias, drive shaft and wheel speed",
        },
    ],
};

/// The method of a value of `observer.method`.
pub(super) fn method(value: i32) -> Method {
    let chosen = Method::ALL.into_iter().find(|m| *m as i32 == value);
    chosen.unwrap_or_default()
}

static PHASE: Enumeration = Enumeration {
    name: "ObserverPhase",
    description: "What the clutches do",
    items: &[
        Item {
            name: "open",
            value: Phase::Open as i32,
            description: "No clutch transmits",
        },
        Item {
            name: "slipping",
            value: Phase::Slipping as i32,
            description: "One clutch transmits and slips: launch, creep",
        },
        Item {
            name: "engaged",
            value: Phase::Engaged as i32,
            description: "One clutch is engaged, the other open: drive",
        },
        Item {
            name: "handover",
            value: Phase::Handover as i32,
            description: "Both clutches transmit: shift",
        },
    ],
};

const INPUTS: [Variable<Observer>; 5] = [
    Variable::input(
        ports::ENGINE_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.u.t_e,
        "T_e of (1): torque that the engine control reports",
    ),
    Variable::input(
        ports::ENGINE_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Observer| &mut m.u.omega_e,
        "omega_e of (1), measured",
    ),
    Variable::input(
        ports::WHEEL_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Observer| &mut m.u.omega_w,
        "omega_w of (9), measured",
    ),
    Variable::input(
        ports::BRAKE_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.u.t_brake,
        "Brake torque at the wheels, for load.method grade",
    )
    .min(0.0),
    Variable::input(
        ports::ROAD_GRADE,
        U::RADIAN,
        |m: &mut Observer| &mut m.u.phi,
        "phi of (11), for load.method grade",
    )
    .min(-1.5)
    .max(1.5),
];

const fn clutch_inputs<const I: usize>() -> [Variable<Observer>; 4] {
    [
        Variable::input(
            ports::CLUTCH_SPEED[I],
            U::RADIAN_PER_SECOND,
            |m: &mut Observer| &mut m.u.omega_c[I],
            "omega_c of (4), (5): speed of the input shaft, measured",
        ),
        Variable::input(
            ports::CLUTCH_POSITION[I],
            U::METRE,
            |m: &mut Observer| &mut m.u.actuation[I].position,
            "theta_m: actuator position, measured",
        )
        .min(0.0),
        Variable::input(
            ports::CLUTCH_PRESSURE[I],
            U::PASCAL,
            |m: &mut Observer| &mut m.u.actuation[I].pressure,
            "Pressure of a wet clutch, measured; used where pistonArea is above 0",
        )
        .min(0.0),
        Variable::integer_input(
            ports::SHAFT_GEAR[I],
            |m: &mut Observer| &mut m.u.gear[I],
            [
                "Gear preselected on the odd shaft: 1, 3, 5, 7; 0 is neutral, -1 reverse",
                "Gear preselected on the even shaft: 2, 4, 6, 8; 0 is neutral, -1 reverse",
            ][I],
        )
        .min(-1.0)
        .max(HIGHEST_GEAR),
    ]
}

const OUTPUTS: [Variable<Observer>; 10] = [
    Variable::output(
        ports::DRIVE_SHAFT_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.y.t_o,
        "Estimate of T_o: x3 of (19)",
    )
    .depends_on(&[]),
    Variable::output(
        "mapBased.driveShaft.torque",
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.y.t_o_map,
        "Map-based T_o = g1 T_c1 + g2 T_c2 (Figs. 10, 12)",
    )
    .depends_on(&[]),
    Variable::output(
        ports::LOAD_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.y.t_v,
        "T_v as used in (19)",
    )
    .depends_on(&[]),
    Variable::output(
        "innovation.x1",
        U::RADIAN_PER_SECOND,
        |m: &mut Observer| &mut m.y.innovation[0],
        "x1 less its estimate",
    )
    .depends_on(&[]),
    Variable::output(
        "innovation.x2",
        U::RADIAN_PER_SECOND,
        |m: &mut Observer| &mut m.y.innovation[1],
        "x2 less its estimate",
    )
    .depends_on(&[]),
    Variable::output(
        "innovation.consistency",
        U::ONE,
        |m: &mut Observer| &mut m.y.consistency,
        "Innovation squared of the speeds over what the filter expects: 1 where it is right about itself; kalman, calibrating",
    )
    .depends_on(&[]),
    Variable::output(
        "driveShaft.torqueDeviation",
        U::NEWTON_METRE,
        |m: &mut Observer| &mut m.y.t_o_deviation,
        "Standard deviation of the estimate of T_o, or the torque its correction injects",
    )
    .depends_on(&[]),
    Variable::output(
        "status.excitation",
        U::ONE,
        |m: &mut Observer| &mut m.y.excitation,
        "How well speeds show the friction of slipping clutches, 0 to 1",
    )
    .depends_on(&[]),
    Variable::enumeration_output(
        "status.phase",
        &PHASE,
        |m: &mut Observer| &mut m.phase,
        "What the clutches do",
    )
    .depends_on(&[]),
    Variable::boolean_output(
        "status.valid",
        |m: &mut Observer| &mut m.y.valid,
        "The estimate can be used",
    )
    .depends_on(&[])
    .initially_depends_on(&[]),
];

/// Nothing is learnt yet.
const LEARNT: [&[&str]; 2] = [
    &[ports::CLUTCH_NOMINAL_FRICTION[0]],
    &[ports::CLUTCH_NOMINAL_FRICTION[1]],
];

const fn clutch_outputs<const I: usize>() -> [Variable<Observer>; 7] {
    let names = [
        [
            "mapBased.clutch1.torque",
            "clutch1.epsilon",
            "clutch1.engaged",
            "clutch1.torqueDeviation",
        ],
        [
            "mapBased.clutch2.torque",
            "clutch2.epsilon",
            "clutch2.engaged",
            "clutch2.torqueDeviation",
        ],
    ][I];
    [
        Variable::output(
            ports::CLUTCH_TORQUE[I],
            U::NEWTON_METRE,
            |m: &mut Observer| &mut m.y.t_c[I],
            "Estimate of T_c, (23), (24)",
        )
        .depends_on(&[]),
        Variable::output(
            names[0],
            U::NEWTON_METRE,
            |m: &mut Observer| &mut m.y.t_c_map[I],
            "Map-based T_c = mu_n F_map r_c N (Figs. 10, 12)",
        )
        .depends_on(&[]),
        Variable::output(
            ports::CLUTCH_MU_F[I],
            U::NEWTON_PER_METRE,
            |m: &mut Observer| &mut m.y.mu_f[I],
            "Adapted mu f of (23), (24) (Figs. 11, 13)",
        )
        .depends_on(&[]),
        Variable::output(
            names[1],
            U::NEWTON_PER_METRE,
            |m: &mut Observer| &mut m.y.epsilon[I],
            "epsilon_c of (23), (24), adapted by (29)",
        )
        .depends_on(&[]),
        Variable::output(
            ports::CLUTCH_FRICTION[I],
            U::ONE,
            |m: &mut Observer| &mut m.y.friction[I],
            "Friction coefficient learnt while the clutch slipped",
        )
        .depends_on(&[])
        .initially_depends_on(LEARNT[I]),
        Variable::output(
            names[3],
            U::NEWTON_METRE,
            |m: &mut Observer| &mut m.y.t_c_deviation[I],
            "Standard deviation of the estimate of T_c, or the torque its correction injects",
        )
        .depends_on(&[]),
        Variable::boolean_output(
            names[2],
            |m: &mut Observer| &mut m.y.engaged[I],
            "The clutch is taken as fully engaged",
        )
        .depends_on(&[]),
    ]
}

const SETTINGS: [Variable<Observer>; 4] = [
    Variable::enumeration_parameter(
        "observer.method",
        &OBSERVER_METHOD,
        |m: &mut Observer| &mut m.method,
        "Method of estimation",
    ),
    Variable::enumeration_parameter(
        "load.method",
        &LOAD_METHOD,
        |m: &mut Observer| &mut m.load,
        "How the load torque is found",
    )
    .tunable(),
    Variable::boolean_parameter(
        "adaptation.enabled",
        |m: &mut Observer| &mut m.settings.adapts,
        "The adaptation (29) acts",
    )
    .tunable(),
    Variable::boolean_parameter(
        "gain.scheduled",
        |m: &mut Observer| &mut m.settings.scheduled,
        "Gains, given for 1 ms, follow the communication step",
    )
    .tunable(),
];

const NOMINAL_FRICTION: [Variable<Observer>; 2] = [
    Variable::parameter(
        ports::CLUTCH_NOMINAL_FRICTION[0],
        U::ONE,
        |m: &mut Observer| &mut m.settings.mu_n[0],
        "mu_1,n of (23): nominal friction coefficient",
    )
    .min(0.0)
    .max(1.0)
    .tunable(),
    Variable::parameter(
        ports::CLUTCH_NOMINAL_FRICTION[1],
        U::ONE,
        |m: &mut Observer| &mut m.settings.mu_n[1],
        "mu_2,n of (24): nominal friction coefficient",
    )
    .min(0.0)
    .max(1.0)
    .tunable(),
];
