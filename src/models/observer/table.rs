//! The table of `DctObserver`.

use super::Observer;
use crate::ports;
use crate::rows::table;
use crate::vehicle::{actuator, driveline, road, shaft};
use fmi2_cosim::{Enumeration, Item, Unit as U, Variable};

/// Longest communication step [s]: beyond it no gain keeps the observer stable.
pub(super) const LONGEST_STEP: f64 = 0.1;

/// `load.method`: (11).
pub(super) const GRADE: i32 = 1;
/// `load.method`: (20).
pub(super) const ENGINE: i32 = 2;
/// `load.method`: (20) with the momentum of every inertia.
pub(super) const MOMENTUM: i32 = 3;
/// `observer.method`: (19)-(29) as printed.
pub(super) const PAPER: i32 = 1;

/// All rows; the index is the value reference.
pub(super) const VARIABLES: &[Variable<Observer>] = table!(Observer:
    INPUTS, clutch_inputs::<0>(), clutch_inputs::<1>(),
    OUTPUTS, clutch_outputs::<0>(), clutch_outputs::<1>(),
    SETTINGS, NOMINAL_FRICTION,
    driveline(), road(), shaft::<_, 0>(), shaft::<_, 1>(), actuator::<_, 0>(), actuator::<_, 1>(),
);

static LOAD_METHOD: Enumeration = Enumeration {
    name: "LoadMethod",
    description: "How the load torque is found",
    items: &[
        Item {
            name: "grade",
            value: GRADE,
            description: "(11) from speed, road grade and brake torque",
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
    items: &[Item {
        name: "paper",
        value: PAPER,
        description: "(19), (27), (29) as printed",
    }],
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
                "Gear preselected on the odd shaft: 1, 3, 5, 7; 0 is neutral",
                "Gear preselected on the even shaft: 2, 4, 6, 8; 0 is neutral",
            ][I],
        )
        .min(0.0)
        .max(8.0),
    ]
}

const OUTPUTS: [Variable<Observer>; 6] = [
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
    Variable::boolean_output(
        "status.valid",
        |m: &mut Observer| &mut m.y.valid,
        "The estimate can be used",
    )
    .depends_on(&[]),
];

const fn clutch_outputs<const I: usize>() -> [Variable<Observer>; 6] {
    let names = [
        [
            "mapBased.clutch1.torque",
            "clutch1.epsilon",
            "clutch1.engaged",
        ],
        [
            "mapBased.clutch2.torque",
            "clutch2.epsilon",
            "clutch2.engaged",
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
        .depends_on(&[]),
        Variable::boolean_output(
            names[2],
            |m: &mut Observer| &mut m.y.engaged[I],
            "The clutch is taken as fully engaged",
        )
        .depends_on(&[]),
    ]
}

const SETTINGS: [Variable<Observer>; 8] = [
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
    Variable::parameter(
        "gain.L11",
        U::PER_SECOND,
        |m: &mut Observer| &mut m.settings.gains.l_11,
        "L11 of (27)",
    )
    .min(0.0)
    .tunable(),
    Variable::parameter(
        "gain.L22",
        U::PER_SECOND,
        |m: &mut Observer| &mut m.settings.gains.l_22,
        "L22 of (27)",
    )
    .min(0.0)
    .tunable(),
    Variable::parameter(
        "gain.Lc1",
        U::ONE,
        |m: &mut Observer| &mut m.settings.gains.l_c[0],
        "L_c1 of (29), with the position in m",
    )
    .min(0.0)
    .tunable(),
    Variable::parameter(
        "gain.Lc2",
        U::ONE,
        |m: &mut Observer| &mut m.settings.gains.l_c[1],
        "L_c2 of (29), with the position in m",
    )
    .min(0.0)
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
