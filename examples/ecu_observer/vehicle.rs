//! `dct_vehicle` of `dct_observer.h`, field by field in its order, and what it becomes inside.

use crate::header;
use crate::interface::Estimate;
use dct_driveline::clutch::MAP_POINTS;
use dct_driveline::observer::friction_map::corrected;
use dct_driveline::params::{ClutchParams, GEARS_PER_SHAFT, RoadParams};
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
    damper_stiffness: f64,
    damper_damping: f64,
    gear_ratio: [[f64; GEARS_PER_SHAFT]; 2],
    reverse_ratio: [f64; 2],
    gear_inertia: [[f64; GEARS_PER_SHAFT]; 2],
    reverse_inertia: [f64; 2],
    final_drive_ratio: [f64; 2],
    mass: f64,
    wheel_radius: f64,
    air_density: f64,
    frontal_area: f64,
    drag_coefficient: f64,
    rolling_resistance: f64,
    rolling_resistance_speed: f64,
    clutch: [Clutch; 2],
}

impl Vehicle {
    /// The vehicle, if every value makes sense.
    ///
    /// Compliances and friction of the plant, which no observer reads, are those of Table 1.
    pub fn checked(&self) -> Option<Params> {
        let fine = self.positive().iter().all(|value| above(*value, 0.0))
            && self.not_negative().all(|value| is_size(*value))
            && self.clutch.iter().all(Clutch::makes_sense);
        fine.then(|| self.params())
    }

    fn positive(&self) -> [f64; 12] {
        let ([one, two], [odd, even]) = (self.clutch_inertia, self.final_drive_ratio);
        [
            self.engine_inertia,
            self.damper_inertia,
            one,
            two,
            self.output_inertia,
            self.wheel_inertia,
            self.drive_shaft_stiffness,
            self.damper_stiffness,
            odd,
            even,
            self.mass,
            self.wheel_radius,
        ]
    }

    fn not_negative(&self) -> impl Iterator<Item = &f64> {
        let gears = self.gear_ratio.as_flattened().iter();
        let shafts = self.reverse_ratio.iter().chain(&self.reverse_inertia);
        gears
            .chain(self.gear_inertia.as_flattened())
            .chain(shafts)
            .chain([
                &self.drive_shaft_damping,
                &self.damper_damping,
                &self.air_density,
                &self.frontal_area,
                &self.drag_coefficient,
                &self.rolling_resistance,
                &self.rolling_resistance_speed,
            ])
    }

    /// Force maps that carry with one friction what was learnt over the position; a piston has none.
    pub fn take_over(&mut self, estimate: &Estimate) {
        for (i, clutch) in self.clutch.iter_mut().enumerate() {
            let (friction, over_position) = estimate.friction_of(i);
            if clutch.piston_area <= 0.0 {
                clutch.map_force = corrected(&clutch.map(), over_position, friction).force;
            }
        }
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
            k_d: self.damper_stiffness,
            c_d: self.damper_damping,
            i_t: self.gear_ratio,
            i_r: self.reverse_ratio,
            j_gear: self.gear_inertia,
            j_r: self.reverse_inertia,
            i_f: self.final_drive_ratio,
            road: RoadParams {
                m_v: self.mass,
                r_w: self.wheel_radius,
                rho_air: self.air_density,
                a_v: self.frontal_area,
                c_drag: self.drag_coefficient,
                c_rr: self.rolling_resistance,
                v_eps: self.rolling_resistance_speed,
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
            damper_stiffness: p.k_d,
            damper_damping: p.c_d,
            gear_ratio: p.i_t,
            reverse_ratio: p.i_r,
            gear_inertia: p.j_gear,
            reverse_inertia: p.j_r,
            final_drive_ratio: p.i_f,
            mass: p.road.m_v,
            wheel_radius: p.road.r_w,
            air_density: p.road.rho_air,
            frontal_area: p.road.a_v,
            drag_coefficient: p.road.c_drag,
            rolling_resistance: p.road.c_rr,
            rolling_resistance_speed: p.road.v_eps,
            clutch: p.clutch.each_ref().map(Clutch::from),
        }
    }
}

impl Clutch {
    fn makes_sense(&self) -> bool {
        let ends = self.map_position.iter().chain(&self.map_force);
        let mut numbers = ends.chain([&self.piston_area, &self.return_force]);
        let positions = self.map_position.windows(2).all(|two| two[0] < two[1]);
        let forces = self.map_force.windows(2).all(|two| two[0] <= two[1]);
        above(self.effective_radius, 0.0)
            && numbers.all(|value| is_size(*value))
            && positions
            && forces
    }

    const fn map(&self) -> ForceMap {
        ForceMap {
            position: self.map_position,
            force: self.map_force,
        }
    }

    fn params(&self, rest: &ClutchParams) -> ClutchParams {
        ClutchParams {
            r_c_n: self.effective_radius,
            map: self.map(),
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

/// A number above `low`.
pub fn above(value: f64, low: f64) -> bool {
    value.is_finite() && value > low
}

/// A number that is not below 0.
pub fn is_size(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}
