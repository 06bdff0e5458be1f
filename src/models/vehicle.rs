//! Rows of the vehicle's parameters, shared by every model that knows the vehicle.

use dct_driveline::Params;
use dct_driveline::clutch::MAP_POINTS;
use fmi2_cosim::{Failure, Unit, Variable};

/// A model with parameters of the vehicle.
pub(crate) trait Vehicle: 'static {
    /// The parameters, which the rows point at.
    fn params(&mut self) -> &mut Params;
}

/// Smallest value of what has to be above zero: inertias, stiffnesses, lengths.
pub(crate) const POSITIVE: f64 = 1e-9;

/// A parameter that has to be above zero.
pub(crate) const fn positive<M: Vehicle>(
    name: &'static str,
    unit: Unit,
    field: fn(&mut M) -> &mut f64,
    description: &'static str,
) -> Variable<M> {
    Variable::parameter(name, unit, field, description).min(POSITIVE)
}

/// A parameter that may be zero.
pub(crate) const fn not_negative<M: Vehicle>(
    name: &'static str,
    unit: Unit,
    field: fn(&mut M) -> &mut f64,
    description: &'static str,
) -> Variable<M> {
    Variable::parameter(name, unit, field, description).min(0.0)
}

/// Engine, output shaft, drive shaft and vehicle: what every observer needs as well.
pub(crate) const fn driveline<M: Vehicle>() -> [Variable<M>; 7] {
    use Unit as U;
    [
        positive(
            "engine.inertia",
            U::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_e,
            "J_e of (1): inertia of the engine",
        ),
        positive(
            "damper.inertia",
            U::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_d,
            "J_d of (2): inertia of the damper's output side with the clutch housing",
        ),
        positive(
            "output.inertia",
            U::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_o,
            "J_o of (8): inertia of the output shaft",
        ),
        positive(
            "driveShaft.stiffness",
            U::NEWTON_METRE_PER_RADIAN,
            |m: &mut M| &mut m.params().k_o,
            "k_o of (10), k_o,eq of (15): stiffness of the drive shaft",
        ),
        not_negative(
            "driveShaft.damping",
            U::NEWTON_METRE_SECOND_PER_RADIAN,
            |m: &mut M| &mut m.params().c_o,
            "c_o of (10), c_o,eq of (15): damping of the drive shaft",
        ),
        positive(
            "vehicle.wheelInertia",
            U::KILOGRAM_SQUARE_METRE,
            |m: &mut M| &mut m.params().j_v,
            "J_v of (9): inertia of the vehicle seen at the wheels",
        ),
        positive(
            "wheel.radius",
            U::METRE,
            |m: &mut M| &mut m.params().road.r_w,
            "r_w of (11): wheel radius",
        ),
    ]
}

/// Road load (11).
pub(crate) const fn road<M: Vehicle>() -> [Variable<M>; 6] {
    use Unit as U;
    [
        positive(
            "vehicle.mass",
            U::KILOGRAM,
            |m: &mut M| &mut m.params().road.m_v,
            "M_v of (11): mass of the vehicle",
        ),
        not_negative(
            "vehicle.frontalArea",
            U::SQUARE_METRE,
            |m: &mut M| &mut m.params().road.a_v,
            "A_v of (11): frontal area",
        ),
        not_negative(
            "vehicle.dragCoefficient",
            U::ONE,
            |m: &mut M| &mut m.params().road.c_drag,
            "C_D of (11): drag coefficient",
        ),
        not_negative(
            "vehicle.rollingResistance",
            U::ONE,
            |m: &mut M| &mut m.params().road.c_rr,
            "C_rr of (11): rolling resistance coefficient",
        ),
        not_negative(
            "vehicle.rollingResistanceSpeed",
            U::METRE_PER_SECOND,
            |m: &mut M| &mut m.params().road.v_eps,
            "V_eps of (11): rolling resistance turns its sign over this speed; 0: dry friction that holds at standstill",
        ),
        not_negative(
            "air.density",
            U::KILOGRAM_PER_CUBIC_METRE,
            |m: &mut M| &mut m.params().road.rho_air,
            "rho_air of (11): air density",
        ),
    ]
}

/// Torsional damper (3).
pub(crate) const fn damper<M: Vehicle>() -> [Variable<M>; 2] {
    use Unit as U;
    [
        positive(
            "damper.stiffness",
            U::NEWTON_METRE_PER_RADIAN,
            |m: &mut M| &mut m.params().k_d,
            "k_d of (3): stiffness of the torsional damper",
        ),
        not_negative(
            "damper.damping",
            U::NEWTON_METRE_SECOND_PER_RADIAN,
            |m: &mut M| &mut m.params().c_d,
            "c_d of (3): damping of the torsional damper",
        ),
    ]
}

/// Compliance of the transfer shafts: the plant's alone.
pub(crate) const fn transfer_shafts<M: Vehicle>() -> [Variable<M>; 5] {
    use Unit as U;
    [
        positive(
            "shaft1.stiffness",
            U::NEWTON_METRE_PER_RADIAN,
            |m: &mut M| &mut m.params().k_t[0],
            "k_t1: stiffness of transfer shaft 1",
        ),
        not_negative(
            "shaft1.damping",
            U::NEWTON_METRE_SECOND_PER_RADIAN,
            |m: &mut M| &mut m.params().c_t[0],
            "c_t1: damping of transfer shaft 1",
        ),
        positive(
            "shaft2.stiffness",
            U::NEWTON_METRE_PER_RADIAN,
            |m: &mut M| &mut m.params().k_t[1],
            "k_t2: stiffness of transfer shaft 2",
        ),
        not_negative(
            "shaft2.damping",
            U::NEWTON_METRE_SECOND_PER_RADIAN,
            |m: &mut M| &mut m.params().c_t[1],
            "c_t2: damping of transfer shaft 2",
        ),
        Variable::boolean_parameter(
            "transmission.rigid",
            |m: &mut M| &mut m.params().rigid,
            "Transfer shafts are rigid: omega_ci = g_i omega_o, their stiffness and damping are not used",
        ),
    ]
}

/// Actuator of clutch `I`: effective radius and force-position map (Fig. 6).
pub(crate) const fn actuator<M: Vehicle, const I: usize>() -> [Variable<M>; 3 + 2 * MAP_POINTS] {
    let names = [
        [
            "clutch1.effectiveRadius",
            "clutch1.pistonArea",
            "clutch1.returnForce",
        ],
        [
            "clutch2.effectiveRadius",
            "clutch2.pistonArea",
            "clutch2.returnForce",
        ],
    ][I];
    [
        positive(
            names[0],
            Unit::METRE,
            |m: &mut M| &mut m.params().clutch[I].r_c_n,
            "r_c N of (6), (7): effective torque radius times number of friction surfaces",
        ),
        not_negative(
            names[1],
            Unit::SQUARE_METRE,
            |m: &mut M| &mut m.params().clutch[I].piston_area,
            "Piston area of a wet clutch; 0: the position and the map act",
        ),
        not_negative(
            names[2],
            Unit::NEWTON,
            |m: &mut M| &mut m.params().clutch[I].return_force,
            "Force of the return spring against the piston of a wet clutch",
        ),
        map_position::<M, I, 0>(),
        map_position::<M, I, 1>(),
        map_position::<M, I, 2>(),
        map_position::<M, I, 3>(),
        map_position::<M, I, 4>(),
        map_position::<M, I, 5>(),
        map_position::<M, I, 6>(),
        map_position::<M, I, 7>(),
        map_position::<M, I, 8>(),
        map_position::<M, I, 9>(),
        map_force::<M, I, 0>(),
        map_force::<M, I, 1>(),
        map_force::<M, I, 2>(),
        map_force::<M, I, 3>(),
        map_force::<M, I, 4>(),
        map_force::<M, I, 5>(),
        map_force::<M, I, 6>(),
        map_force::<M, I, 7>(),
        map_force::<M, I, 8>(),
        map_force::<M, I, 9>(),
    ]
}

/// `prefix[1]` … `prefix[10]`, or with the indices that are given.
macro_rules! indexed {
    ($prefix:literal) => {
        indexed!($prefix: 1, 2, 3, 4, 5, 6, 7, 8, 9, 10)
    };
    ($prefix:literal: $($index:literal),*) => {
        [$(concat!($prefix, "[", $index, "]")),*]
    };
}
pub(crate) use indexed;

const MAP_POSITION: [[&str; MAP_POINTS]; 2] = [
    indexed!("clutch1.map.position"),
    indexed!("clutch2.map.position"),
];
const MAP_FORCE: [[&str; MAP_POINTS]; 2] =
    [indexed!("clutch1.map.force"), indexed!("clutch2.map.force")];

const fn map_position<M: Vehicle, const I: usize, const K: usize>() -> Variable<M> {
    let field: fn(&mut M) -> &mut f64 = |m| &mut m.params().clutch[I].map.position[K];
    not_negative(
        MAP_POSITION[I][K],
        Unit::METRE,
        field,
        "Actuator position of a point of the force-position map (Fig. 6), ascending",
    )
}

const fn map_force<M: Vehicle, const I: usize, const K: usize>() -> Variable<M> {
    let field: fn(&mut M) -> &mut f64 = |m| &mut m.params().clutch[I].map.force[K];
    not_negative(
        MAP_FORCE[I][K],
        Unit::NEWTON,
        field,
        "Normal force of a point of the force-position map (Fig. 6), not descending",
    )
}

/// Refuses maps that are no functions: positions ascend, forces do not descend.
pub(crate) fn check_maps(p: &Params) -> Result<(), Failure> {
    for (i, clutch) in p.clutch.iter().enumerate() {
        for k in 1..MAP_POINTS {
            let (position, force) = (clutch.map.position, clutch.map.force);
            if position[k] <= position[k - 1] {
                let remedy = "must be above the position before it";
                return Err(invalid(MAP_POSITION[i][k], position[k], remedy));
            }
            if force[k] < force[k - 1] {
                let remedy = "must not be below the force before it";
                return Err(invalid(MAP_FORCE[i][k], force[k], remedy));
            }
        }
    }
    Ok(())
}

/// A [`Failure::Invalid`].
pub(crate) const fn invalid(variable: &'static str, value: f64, remedy: &'static str) -> Failure {
    Failure::Invalid {
        variable,
        value,
        remedy,
    }
}
