//! Names that connect FMUs: an input takes the output of the same name.

/// Engine torque T_e [N·m].
pub const ENGINE_TORQUE: &str = "engine.torque";
/// Engine speed ω_e [rad/s].
pub const ENGINE_SPEED: &str = "engine.speed";
/// Speed of the damper's output side ω_d [rad/s].
pub const DAMPER_SPEED: &str = "damper.speed";
/// Speed of the output shaft ω_o [rad/s].
pub const OUTPUT_SPEED: &str = "output.speed";
/// Wheel speed ω_w [rad/s].
pub const WHEEL_SPEED: &str = "wheel.speed";
/// Torque of the drive shaft T_o [N·m].
pub const DRIVE_SHAFT_TORQUE: &str = "driveShaft.torque";
/// Load torque T_v at the wheel [N·m].
pub const LOAD_TORQUE: &str = "load.torque";
/// Brake torque at the wheel [N·m], ≥ 0.
pub const BRAKE_TORQUE: &str = "brake.torque";
/// Road inclination φ [rad].
pub const ROAD_GRADE: &str = "road.grade";

/// Actuator positions θ_m1, θ_m2 [m].
pub const CLUTCH_POSITION: [&str; 2] = ["clutch1.position", "clutch2.position"];
/// Actuator pressures of a wet clutch [Pa].
pub const CLUTCH_PRESSURE: [&str; 2] = ["clutch1.pressure", "clutch2.pressure"];
/// Input-shaft speeds ω_c1, ω_c2 [rad/s].
pub const CLUTCH_SPEED: [&str; 2] = ["clutch1.speed", "clutch2.speed"];
/// Clutch torques T_c1, T_c2 [N·m].
pub const CLUTCH_TORQUE: [&str; 2] = ["clutch1.torque", "clutch2.torque"];
/// Requested clutch torques [N·m].
pub const CLUTCH_TORQUE_REQUEST: [&str; 2] = ["clutch1.torqueRequest", "clutch2.torqueRequest"];
/// The observer trusts its estimate.
pub const STATUS_VALID: &str = "status.valid";
/// Adapted μ·f of (23), (24) [N/m].
pub const CLUTCH_MU_F: [&str; 2] = ["clutch1.muF", "clutch2.muF"];
/// Friction coefficients learnt while slipping [1].
pub const CLUTCH_FRICTION: [&str; 2] = ["clutch1.friction", "clutch2.friction"];
/// Nominal friction coefficients μ_n [1].
pub const CLUTCH_NOMINAL_FRICTION: [&str; 2] =
    ["clutch1.nominalFriction", "clutch2.nominalFriction"];
/// Gears preselected on the odd and the even shaft; 0 is neutral.
pub const SHAFT_GEAR: [&str; 2] = ["shaft1.gear", "shaft2.gear"];
