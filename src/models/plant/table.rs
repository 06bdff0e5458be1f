//! The table of `DctPlant`.

use super::Plant;
use super::efficiency::efficiencies;
use super::lining::lining;
use super::losses::LOSSES;
use super::start::{self, DAMPER, ENGINE, JERK, NOTHING, SHAFTS, WHEELS};
use super::thermal::{thermal, thermal_outputs};
use crate::gears::{HIGHEST_GEAR, shaft};
use crate::ports;
use crate::rows::table;
use crate::vehicle::{POSITIVE, actuator, damper, driveline, road, transfer_shafts};
use dct_driveline::matrices::{C, D, E, O, W};
use dct_driveline::plant::modes::Mode;
use fmi2_cosim::{Enumeration, Item, Unit as U, Variable};

/// Longest communication step [s]: beyond it a ramp of the load over a step is too coarse.
pub(super) const LONGEST_STEP: f64 = 1.0;

/// All rows; the index is the value reference.
pub(super) const VARIABLES: &[Variable<Plant>] = table!(Plant:
    INPUTS, clutch_inputs::<0>(), clutch_inputs::<1>(),
    SPEEDS, TORQUES, LOSSES, clutch_outputs::<0>(), clutch_outputs::<1>(),
    thermal_outputs::<0>(), thermal_outputs::<1>(),
    driveline(), road(), damper(), transfer_shafts(),
    shaft::<_, 0>(), shaft::<_, 1>(), actuator::<_, 0>(), actuator::<_, 1>(),
    clutch_parameters::<0>(), clutch_parameters::<1>(), lining::<0>(), lining::<1>(),
    thermal::<0>(), thermal::<1>(), efficiencies::<0>(), efficiencies::<1>(), start::ROWS,
);

/// State of a clutch.
static CLUTCH_STATE: Enumeration = Enumeration {
    name: "ClutchState",
    description: "State of a clutch, (6) and (7)",
    items: &[
        Item {
            name: "disengaged",
            value: 1,
            description: "No normal force, no torque",
        },
        Item {
            name: "slipping",
            value: 2,
            description: "Kinetic friction against the slip",
        },
        Item {
            name: "engaged",
            value: 3,
            description: "No slip: the torque that keeps it so",
        },
    ],
};

/// The mode of a code in a serialised state.
pub(super) fn mode(code: i32) -> Mode {
    let all = [Mode::Open, Mode::Forward, Mode::Backward, Mode::Stuck];
    all.into_iter()
        .find(|mode| *mode as i32 == code)
        .unwrap_or(Mode::Open)
}

/// What the torque of a clutch depends on at a communication point.
const ACTUATORS: &[&str] = &[
    "clutch1.position",
    "clutch1.pressure",
    "clutch2.position",
    "clutch2.pressure",
];
/// What the load depends on at a communication point.
const LOAD: &[&str] = &[ports::BRAKE_TORQUE, ports::ROAD_GRADE];
/// Jerk.
const METRE_PER_SECOND_CUBED: U = U::new("m/s3", [0, 1, -3, 0, 0, 0, 0, 0], &[]);
/// States only.
const STATES: &[&str] = &[];

const INPUTS: [Variable<Plant>; 3] = [
    Variable::input(
        ports::ENGINE_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Plant| &mut m.u.engine_torque,
        "T_e of (1): torque of the engine",
    )
    .rate(|m| &mut m.u_rate.engine_torque),
    Variable::input(
        ports::BRAKE_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Plant| &mut m.u.brake_torque,
        "Brake torque at the wheels against the motion; at standstill it holds up to this torque",
    )
    .min(0.0)
    .rate(|m| &mut m.u_rate.brake_torque),
    Variable::input(
        ports::ROAD_GRADE,
        U::RADIAN,
        |m: &mut Plant| &mut m.u.grade,
        "phi of (11): inclination of the road, positive uphill",
    )
    .min(-1.5)
    .max(1.5)
    .rate(|m| &mut m.u_rate.grade),
];

const fn clutch_inputs<const I: usize>() -> [Variable<Plant>; 3] {
    [
        Variable::input(
            ports::CLUTCH_POSITION[I],
            U::METRE,
            |m: &mut Plant| &mut m.u.position[I],
            "theta_m: actuator position, 0 is open",
        )
        .min(0.0)
        .rate(|m| &mut m.u_rate.position[I]),
        Variable::input(
            ports::CLUTCH_PRESSURE[I],
            U::PASCAL,
            |m: &mut Plant| &mut m.u.pressure[I],
            "Pressure on the piston of a wet clutch; acts where pistonArea is above 0",
        )
        .min(0.0)
        .rate(|m| &mut m.u_rate.pressure[I]),
        Variable::integer_input(
            ports::SHAFT_GEAR[I],
            |m: &mut Plant| &mut m.gear[I],
            [
                "Gear preselected on the odd shaft: 1, 3, 5, 7; 0 is neutral, -1 reverse",
                "Gear preselected on the even shaft: 2, 4, 6, 8; 0 is neutral, -1 reverse",
            ][I],
        )
        .min(-1.0)
        .max(HIGHEST_GEAR),
    ]
}

const SPEEDS: [Variable<Plant>; 9] = [
    Variable::output(
        ports::ENGINE_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.state.x[E],
        "omega_e of (1): engine speed",
    )
    .slope(|m| &mut m.y.omega_e)
    .depends_on(STATES)
    .initially_depends_on(ENGINE),
    Variable::output(
        ports::DAMPER_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.state.x[D],
        "omega_d of (2): speed of the damper's output side",
    )
    .slope(|m| &mut m.y.omega_d)
    .depends_on(STATES)
    .initially_depends_on(DAMPER),
    Variable::output(
        ports::OUTPUT_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.state.x[O],
        "omega_o of (8): speed of the output shaft",
    )
    .slope(|m| &mut m.y.omega_o)
    .depends_on(STATES)
    .initially_depends_on(WHEELS),
    Variable::output(
        ports::WHEEL_SPEED,
        U::RADIAN_PER_SECOND,
        |m: &mut Plant| &mut m.state.x[W],
        "omega_w of (9): speed of the wheels",
    )
    .slope(|m| &mut m.y.omega_w)
    .depends_on(STATES)
    .initially_depends_on(WHEELS),
    Variable::output(
        "vehicle.speed",
        U::METRE_PER_SECOND,
        |m: &mut Plant| &mut m.y.vehicle_speed,
        "V = r_w omega_w",
    )
    .slope(|m| &mut m.y.vehicle_speed)
    .depends_on(STATES)
    .initially_depends_on(WHEELS)
    .on_demand(),
    Variable::output(
        "vehicle.acceleration",
        U::METRE_PER_SECOND_SQUARED,
        |m: &mut Plant| &mut m.y.vehicle_acceleration,
        "dV/dt",
    )
    .slope(|m| &mut m.y.vehicle_acceleration)
    .depends_on(LOAD)
    .on_demand(),
    Variable::output(
        "vehicle.filteredAcceleration",
        U::METRE_PER_SECOND_SQUARED,
        |m: &mut Plant| &mut m.comfort[0],
        "dV/dt through 1/(1 + tau s)^2, tau = vehicle.jerkTime",
    )
    .slope(|m| &mut m.comfort[0])
    .depends_on(STATES)
    .initially_depends_on(NOTHING)
    .on_demand(),
    Variable::output(
        "vehicle.jerk",
        METRE_PER_SECOND_CUBED,
        |m: &mut Plant| &mut m.comfort[1],
        "Jerk: derivative of the filtered acceleration, (V - 2 V1 + V2)/tau^2",
    )
    .slope(|m| &mut m.comfort[1])
    .depends_on(STATES)
    .initially_depends_on(JERK)
    .on_demand(),
    Variable::boolean_output(
        "wheel.held",
        |m: &mut Plant| &mut m.y.held,
        "The wheels stand, and brake or dry rolling resistance holds them",
    )
    .depends_on(STATES)
    .on_demand(),
];

const TORQUES: [Variable<Plant>; 3] = [
    Variable::output(
        "damper.torque",
        U::NEWTON_METRE,
        |m: &mut Plant| &mut m.y.t_d,
        "T_d of (3): torque of the torsional damper",
    )
    .slope(|m| &mut m.y.t_d)
    .depends_on(STATES)
    .on_demand(),
    Variable::output(
        ports::DRIVE_SHAFT_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Plant| &mut m.y.t_o,
        "T_o of (10): torque of the drive shaft",
    )
    .slope(|m| &mut m.y.t_o)
    .depends_on(STATES)
    .initially_depends_on(NOTHING),
    Variable::output(
        ports::LOAD_TORQUE,
        U::NEWTON_METRE,
        |m: &mut Plant| &mut m.y.t_v,
        "T_v of (11) with the brake, positive against forward motion",
    )
    .slope(|m| &mut m.y.t_v)
    .depends_on(LOAD)
    .on_demand(),
];

const fn clutch_outputs<const I: usize>() -> [Variable<Plant>; 8] {
    let synchronising = ["shaft1.synchronising", "shaft2.synchronising"][I];
    let shaft = ["shaft1.torque", "shaft2.torque"][I];
    let slip = ["clutch1.slip", "clutch2.slip"][I];
    let state = ["clutch1.state", "clutch2.state"][I];
    let power = ["clutch1.frictionPower", "clutch2.frictionPower"][I];
    let energy = ["clutch1.frictionEnergy", "clutch2.frictionEnergy"][I];
    [
        Variable::output(
            ports::CLUTCH_SPEED[I],
            U::RADIAN_PER_SECOND,
            |m: &mut Plant| &mut m.state.x[C + I],
            "omega_c of (4), (5): speed of the input shaft",
        )
        .slope(|m| &mut m.y.omega_c[I])
        .depends_on(STATES)
        .initially_depends_on(SHAFTS[I]),
        Variable::output(
            ports::CLUTCH_TORQUE[I],
            U::NEWTON_METRE,
            |m: &mut Plant| &mut m.y.t_c[I],
            "T_c of (6), (7): torque through the clutch, positive when the engine drives",
        )
        .slope(|m| &mut m.y.t_c[I])
        .depends_on(ACTUATORS)
        .on_demand(),
        Variable::output(
            shaft,
            U::NEWTON_METRE,
            |m: &mut Plant| &mut m.y.t_t[I],
            "T_t of (4), (5): torque of the transfer shaft",
        )
        .slope(|m| &mut m.y.t_t[I])
        .depends_on(ACTUATORS)
        .on_demand(),
        Variable::boolean_output(
            synchronising,
            |m: &mut Plant| &mut m.y.synchronising[I],
            "The preselected gear is not in yet: its synchroniser rubs",
        )
        .depends_on(STATES)
        .on_demand(),
        Variable::output(
            slip,
            U::RADIAN_PER_SECOND,
            |m: &mut Plant| &mut m.y.slip[I],
            "Slip omega_d - omega_c, exactly 0 when engaged",
        )
        .slope(|m| &mut m.y.slip[I])
        .depends_on(STATES)
        .initially_depends_on(DAMPER)
        .on_demand(),
        Variable::enumeration_output(
            state,
            &CLUTCH_STATE,
            |m: &mut Plant| &mut m.clutch_state[I],
            "State of the clutch",
        )
        .depends_on(STATES)
        .on_demand(),
        Variable::output(
            power,
            U::WATT,
            |m: &mut Plant| &mut m.y.friction_power[I],
            "Friction power in the clutch",
        )
        .slope(|m| &mut m.y.friction_power[I])
        .depends_on(ACTUATORS)
        .on_demand(),
        Variable::output(
            energy,
            U::JOULE,
            |m: &mut Plant| &mut m.y.friction_energy[I],
            "Friction energy in the clutch since the start",
        )
        .slope(|m| &mut m.y.friction_energy[I])
        .depends_on(STATES)
        .initially_depends_on(NOTHING)
        .on_demand(),
    ]
}

const fn clutch_parameters<const I: usize>() -> [Variable<Plant>; 3] {
    let synchroniser = ["shaft1.synchroniserTorque", "shaft2.synchroniserTorque"][I];
    let names = [
        ["clutch1.kineticFriction", "clutch1.staticFriction"],
        ["clutch2.kineticFriction", "clutch2.staticFriction"],
    ][I];
    [
        Variable::parameter(
            names[0],
            U::ONE,
            |m: &mut Plant| &mut m.p.clutch[I].mu_k,
            "mu_k of (6), (7): kinetic friction coefficient",
        )
        .min(0.0)
        .tunable(),
        Variable::parameter(
            names[1],
            U::ONE,
            |m: &mut Plant| &mut m.p.clutch[I].mu_s,
            "mu_s: static friction coefficient, not below the kinetic one",
        )
        .min(0.0)
        .tunable(),
        Variable::parameter(
            synchroniser,
            U::NEWTON_METRE,
            |m: &mut Plant| &mut m.p.t_s[I],
            "T_s: torque of this shaft's synchroniser while it rubs, seen at the input shaft",
        )
        .min(POSITIVE),
    ]
}
