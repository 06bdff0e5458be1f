//! The structs of `dct_observer.h`, field by field in its order, and what they become inside.

use crate::header;
use dct_driveline::clutch::MAP_POINTS;
use dct_driveline::observer::{self, LoadMethod};
use dct_driveline::params::{Actuation, ClutchParams, GEARS_PER_SHAFT, RoadParams};
use dct_driveline::{ForceMap, Params};

const _: () = assert!(header::number("#define DCT_GEARS_PER_SHAFT ") == GEARS_PER_SHAFT);
const _: () = assert!(header::number("#define DCT_MAP_POINTS ") == MAP_POINTS);

/// `dct_clutch`.
#[repr(C)]
pub struct Clutch {
    effective_radius: f64,
    map_position: [f64; MAP_POINTS],
    map_force: [f64; MAP_POINTS],
    piston_area: f64,
    return_force: f64,
}

/// `dct_vehicle`.
#[repr(C)]
pub struct Vehicle {
    engine_inertia: f64,
    damper_inertia: f64,
    clutch_inertia: [f64; 2],
    output_inertia: f64,
    wheel_inertia: f64,
    drive_shaft_stiffness: f64,
    drive_shaft_damping: f64,
    gear_ratio: [[f64; GEARS_PER_SHAFT]; 2],
    final_drive_ratio: [f64; 2],
    mass: f64,
    wheel_radius: f64,
    air_density: f64,
    frontal_area: f64,
    drag_coefficient: f64,
    rolling_resistance: f64,
    clutch: [Clutch; 2],
}

/// `dct_settings`.
#[repr(C)]
pub struct SettingsOfC {
    nominal_friction: [f64; 2],
    adaptation: i32,
    load_method: i32,
}

/// `dct_sample`.
#[repr(C)]
pub struct Sample {
    engine_torque: f64,
    engine_speed: f64,
    clutch_speed: [f64; 2],
    wheel_speed: f64,
    position: [f64; 2],
    pressure: [f64; 2],
    brake_torque: f64,
    road_grade: f64,
    gear: [i32; 2],
}

/// `dct_estimate`.
#[repr(C)]
pub struct Estimate {
    clutch_torque: [f64; 2],
    drive_shaft_torque: f64,
    load_torque: f64,
    friction: [f64; 2],
    engaged: [i32; 2],
    valid: i32,
}

impl Vehicle {
    /// The vehicle, if every value makes sense.
    ///
    /// Compliances and friction of the plant, which no observer reads, are those of Table 1.
    pub fn checked(&self) -> Option<Params> {
        let positive = [
            self.engine_inertia,
            self.damper_inertia,
            self.clutch_inertia[0],
            self.clutch_inertia[1],
            self.output_inertia,
            self.wheel_inertia,
            self.drive_shaft_stiffness,
            self.final_drive_ratio[0],
            self.final_drive_ratio[1],
            self.mass,
            self.wheel_radius,
        ];
        let not_negative = [
            self.drive_shaft_damping,
            self.air_density,
            self.frontal_area,
            self.drag_coefficient,
            self.rolling_resistance,
        ];
        let finite = |value: &f64| value.is_finite();
        let ratios = self.gear_ratio.iter().flatten();
        let fine = positive.iter().all(|value| finite(value) && *value > 0.0)
            && not_negative
                .iter()
                .chain(ratios)
                .all(|value| finite(value) && *value >= 0.0)
            && self.clutch.iter().all(Clutch::makes_sense);
        fine.then(|| self.params())
    }

    fn params(&self) -> Params {
        Params {
            j_e: self.engine_inertia,
            j_d: self.damper_inertia,
            j_ct: self.clutch_inertia,
            j_o: self.output_inertia,
            j_v: self.wheel_inertia,
            k_o: self.drive_shaft_stiffness,
            c_o: self.drive_shaft_damping,
            i_t: self.gear_ratio,
            i_f: self.final_drive_ratio,
            road: RoadParams {
                m_v: self.mass,
                r_w: self.wheel_radius,
                rho_air: self.air_density,
                a_v: self.frontal_area,
                c_drag: self.drag_coefficient,
                c_rr: self.rolling_resistance,
                ..Params::TABLE_1.road
            },
            clutch: [0, 1].map(|i| self.clutch[i].params(&Params::TABLE_1.clutch[i])),
            ..Params::TABLE_1
        }
    }
}

impl From<&Params> for Vehicle {
    fn from(p: &Params) -> Self {
        Self {
            engine_inertia: p.j_e,
            damper_inertia: p.j_d,
            clutch_inertia: p.j_ct,
            output_inertia: p.j_o,
            wheel_inertia: p.j_v,
            drive_shaft_stiffness: p.k_o,
            drive_shaft_damping: p.c_o,
            gear_ratio: p.i_t,
            final_drive_ratio: p.i_f,
            mass: p.road.m_v,
            wheel_radius: p.road.r_w,
            air_density: p.road.rho_air,
            frontal_area: p.road.a_v,
            drag_coefficient: p.road.c_drag,
            rolling_resistance: p.road.c_rr,
            clutch: p.clutch.each_ref().map(Clutch::from),
        }
    }
}

impl Clutch {
    fn makes_sense(&self) -> bool {
        let ends = self.map_position.iter().chain(&self.map_force);
        let numbers = ends.chain([&self.piston_area, &self.return_force]);
        let positions = self.map_position.windows(2).all(|two| two[0] < two[1]);
        let forces = self.map_force.windows(2).all(|two| two[0] <= two[1]);
        self.effective_radius.is_finite()
            && self.effective_radius > 0.0
            && numbers
                .into_iter()
                .all(|value| value.is_finite() && *value >= 0.0)
            && positions
            && forces
    }

    fn params(&self, rest: &ClutchParams) -> ClutchParams {
        ClutchParams {
            r_c_n: self.effective_radius,
            map: ForceMap {
                position: self.map_position,
                force: self.map_force,
            },
            piston_area: self.piston_area,
            return_force: self.return_force,
            ..*rest
        }
    }
}

impl From<&ClutchParams> for Clutch {
    fn from(clutch: &ClutchParams) -> Self {
        Self {
            effective_radius: clutch.r_c_n,
            map_position: clutch.map.position,
            map_force: clutch.map.force,
            piston_area: clutch.piston_area,
            return_force: clutch.return_force,
        }
    }
}

impl SettingsOfC {
    /// Friction case 1 of the paper, load torque from momentum.
    pub const CASE_1: Self = Self {
        nominal_friction: observer::Settings::CASE_1.mu_n,
        adaptation: 1,
        load_method: 3,
    };

    /// The settings, if every value makes sense.
    pub fn checked(&self) -> Option<observer::Settings> {
        let load = match self.load_method {
            1 => LoadMethod::Grade,
            2 => LoadMethod::Engine,
            3 => LoadMethod::Momentum,
            _ => return None,
        };
        let friction = |mu: &f64| *mu > 0.0 && *mu <= 1.0;
        self.nominal_friction
            .iter()
            .all(friction)
            .then_some(observer::Settings {
                mu_n: self.nominal_friction,
                load,
                adapts: self.adaptation != 0,
                ..observer::Settings::CASE_1
            })
    }
}

impl From<&Sample> for observer::Sample {
    fn from(c: &Sample) -> Self {
        Self {
            t_e: c.engine_torque,
            omega_e: c.engine_speed,
            omega_c: c.clutch_speed,
            omega_w: c.wheel_speed,
            actuation: [0, 1].map(|i| Actuation {
                position: c.position[i],
                pressure: c.pressure[i],
            }),
            gear: c.gear,
            t_brake: c.brake_torque,
            phi: c.road_grade,
            t_y: 0.0,
        }
    }
}

impl From<observer::Estimate> for Estimate {
    fn from(estimate: observer::Estimate) -> Self {
        Self {
            clutch_torque: estimate.t_c,
            drive_shaft_torque: estimate.t_o,
            load_torque: estimate.t_v,
            friction: estimate.friction,
            engaged: estimate.engaged.map(i32::from),
            valid: i32::from(estimate.valid),
        }
    }
}
