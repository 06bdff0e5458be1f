//! Settings, sample and estimate of `dct_observer.h`, field by field in its order, and what they become inside.

use crate::header;
use crate::vehicle::{above, is_size};
use dct_driveline::observer::calibrating::Gains;
use dct_driveline::observer::calibration::PARAMETERS;
use dct_driveline::observer::friction_map::POINTS;
use dct_driveline::observer::prior::Prior;
use dct_driveline::observer::{self, Fault, LoadMethod, Method, Phase};
use dct_driveline::params::Actuation;

const _: () = assert!(header::number("#define DCT_PARAMETERS ") == PARAMETERS);
const _: () = assert!(header::number("#define DCT_FRICTION_POINTS ") == POINTS);
const _: () = assert!(header::number("DCT_PAPER = ") == Method::Paper as usize);
const _: () = assert!(header::number("DCT_LYAPUNOV = ") == Method::Lyapunov as usize);
const _: () = assert!(header::number("DCT_ENERGY = ") == Method::Energy as usize);
const _: () = assert!(header::number("DCT_KALMAN = ") == Method::Kalman as usize);
const _: () = assert!(header::number("DCT_CALIBRATING = ") == Method::Calibrating as usize);
const _: () = assert!(header::number("DCT_OPEN = ") == Phase::Open as usize);
const _: () = assert!(header::number("DCT_SLIPPING = ") == Phase::Slipping as usize);
const _: () = assert!(header::number("DCT_ENGAGED = ") == Phase::Engaged as usize);
const _: () = assert!(header::number("DCT_HANDOVER = ") == Phase::Handover as usize);
const _: () = assert!(header::number("DCT_NOT_FINITE = ") == Fault::NotFinite as usize);
const _: () = assert!(header::number("DCT_NO_SPEED = ") == Fault::NoSpeed as usize);
const _: () = assert!(header::number("DCT_FROZEN = ") == Fault::Frozen as usize);
const _: () = assert!(header::number("DCT_SATURATED = ") == Fault::Saturated as usize);
const _: () = assert!(header::number("DCT_DIVERGED = ") == Fault::Diverged as usize);
const _: () = assert!(header::number("DCT_INCONSISTENT = ") == Fault::Inconsistent as usize);

/// Which of the parameters learnt are no relative errors: biases of T_e and of the wheel speed.
const BIASES: [usize; 2] = [1, 3];
/// A parameter that is a tenth of what it was believed to be is no calibration any more.
const RATIO: f64 = -0.9;

/// `dct_settings`.
#[repr(C)]
pub struct SettingsOfC {
    nominal_friction: [f64; 2],
    calibration: [f64; PARAMETERS],
    calibration_deviation: [f64; PARAMETERS],
    friction_deviation: [[f64; POINTS]; 2],
    encoder_ticks: [f64; 4],
    adaptation: i32,
    load_method: i32,
    method: i32,
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
    clutch_torque_deviation: [f64; 2],
    drive_shaft_torque_deviation: f64,
    consistency: f64,
    excitation: f64,
    calibration: [f64; PARAMETERS],
    calibration_deviation: [f64; PARAMETERS],
    vehicle_mass: [f64; 2],
    friction_map: [[f64; POINTS]; 2],
    friction_map_deviation: [[f64; POINTS]; 2],
    engaged: [i32; 2],
    phase: i32,
    valid: i32,
    fault: i32,
}

impl SettingsOfC {
    /// Friction case 1 of the paper, load torque from momentum, method `paper`.
    pub const CASE_1: Self = Self {
        nominal_friction: observer::Settings::CASE_1.mu_n,
        calibration: Prior::NONE.0,
        calibration_deviation: Gains::DEFAULT.sigma,
        friction_deviation: Gains::DEFAULT.friction,
        encoder_ticks: observer::Settings::CASE_1.encoder,
        adaptation: 1,
        load_method: 3,
        method: Method::Paper as i32,
    };

    /// Method and settings, if every value makes sense.
    pub fn checked(&self) -> Option<(Method, observer::Settings)> {
        let method = Method::ALL.into_iter().find(|m| *m as i32 == self.method)?;
        let load = match self.load_method {
            1 => LoadMethod::Grade,
            2 => LoadMethod::Engine,
            3 => LoadMethod::Momentum,
            _ => return None,
        };
        let friction = |mu: &f64| *mu > 0.0 && *mu <= 1.0;
        let counted = self.encoder_ticks.iter().all(|ticks| is_size(*ticks));
        let fine = counted && self.nominal_friction.iter().all(friction) && self.is_calibration();
        fine.then_some((
            method,
            observer::Settings {
                mu_n: self.nominal_friction,
                load,
                adapts: self.adaptation != 0,
                encoder: self.encoder_ticks,
                calibrating: Gains {
                    prior: Prior(self.calibration),
                    sigma: self.calibration_deviation,
                    friction: self.friction_deviation,
                    ..Gains::DEFAULT
                },
                ..observer::Settings::CASE_1
            },
        ))
    }

    fn is_calibration(&self) -> bool {
        let mut learnt = self.calibration.iter().enumerate();
        learnt.all(|(k, value)| {
            let low = if BIASES.contains(&k) { f64::MIN } else { RATIO };
            above(*value, low)
        }) && self.deviations().all(|s| is_size(*s))
    }

    fn deviations(&self) -> impl Iterator<Item = &f64> {
        let friction = self.friction_deviation.as_flattened();
        self.calibration_deviation.iter().chain(friction)
    }

    /// What was learnt until `estimate`.
    pub fn take_over(&mut self, estimate: &Estimate) {
        self.nominal_friction = estimate.friction;
        self.calibration = estimate.calibration;
        self.calibration_deviation = estimate.calibration_deviation;
        self.friction_deviation = estimate.friction_map_deviation;
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

impl Estimate {
    /// What `calibrating` has learnt can be taken over: it acted, and saw numbers.
    pub fn has_learnt(&self) -> bool {
        let map = self.friction_map.as_flattened().iter();
        self.friction.iter().all(|mu| above(*mu, 0.0))
            && map.chain(&self.calibration).all(|value| value.is_finite())
            && self.calibration_deviation.iter().any(|s| above(*s, 0.0))
    }

    /// Friction of clutch `i` as one number, and over the position.
    pub fn friction_of(&self, i: usize) -> (f64, [f64; POINTS]) {
        (self.friction[i], self.friction_map[i])
    }
}

impl From<observer::Estimate> for Estimate {
    fn from(estimate: observer::Estimate) -> Self {
        Self {
            clutch_torque: estimate.t_c,
            drive_shaft_torque: estimate.t_o,
            load_torque: estimate.t_v,
            friction: estimate.friction,
            clutch_torque_deviation: estimate.t_c_deviation,
            drive_shaft_torque_deviation: estimate.t_o_deviation,
            consistency: estimate.consistency,
            excitation: estimate.excitation,
            calibration: estimate.calibration.value,
            calibration_deviation: estimate.calibration.deviation,
            vehicle_mass: estimate.calibration.mass,
            friction_map: estimate.calibration.friction,
            friction_map_deviation: estimate.calibration.friction_deviation,
            engaged: estimate.engaged.map(i32::from),
            phase: estimate.phase as i32,
            valid: i32::from(estimate.valid),
            fault: estimate.fault.map_or(0, |fault| fault as i32),
        }
    }
}
