//! What the observer says in the log.

use super::{Observer, table};
use core::fmt;
use dct_driveline::observer::leap::{LONGEST, Leaps};
use dct_driveline::observer::{Fault, Method, SPEEDS, Sample};
use fmi2_cosim::{Log, Seconds};

impl Observer {
    /// Logs what changed since an estimate that was `valid` with clutches `engaged`, shape (2).
    #[cold]
    #[inline(never)]
    pub(super) fn tell(&self, valid: bool, engaged: [bool; 2], time: f64, log: &mut Log<'_>) {
        if let Some(fault) = self.y.fault.filter(|_| valid) {
            log.warning(format_args!(
                "t = {} s: status.valid = false: {fault} ({}); {}",
                Seconds(time),
                Evidence(self, fault),
                remedy(fault, table::method(self.method))
            ));
        }
        for i in (0..2).filter(|i| engaged[*i] != self.y.engaged[*i]) {
            let now = if self.y.engaged[i] {
                "engaged"
            } else {
                "not engaged"
            };
            log.event(format_args!(
                "t = {} s: clutch {} is {now}",
                Seconds(time),
                i + 1
            ));
        }
    }
}

/// Whose speeds ω_e, ω_c1, ω_c2, ω_w are.
const SHAFTS: [&str; SPEEDS] = ["engine", "clutch1", "clutch2", "wheel"];

/// Logs speeds of the sample `u` that leapt and are held now, of which those that were held before have been told.
///
/// `time` and the `step` that led there [s].
#[cold]
#[inline(never)]
pub(super) fn leaps(u: &Sample, leaps: &Leaps, [time, step]: [f64; 2], log: &mut Log<'_>) {
    if !u.is_finite() {
        return; // neither held nor believed
    }
    let (now, [held, last]) = (u.speeds(), leaps.held());
    for j in (0..SPEEDS).filter(|j| held[*j] == step) {
        log.warning(format_args!(
            "t = {} s: {name}.speed = {} rad/s is not believed: {} was to come in a step of {} s, and no driveline is \
             that fast; it is taken as that until its sensor is back, for {} s at most; check the sensor and its bus",
            Seconds(time),
            short(now[j]),
            short(last[j]),
            short(step),
            short(LONGEST),
            name = SHAFTS[j],
        ));
    }
}

/// Logs encoders that were recognised, or no longer are, since `before`; ticks of ω_e, ω_c1, ω_c2, ω_w [1], shape (4).
#[inline(never)] // most speeds are not counted
pub(super) fn ticks(before: [f64; 4], now: [f64; 4], time: f64, log: &mut Log<'_>) {
    let time = Seconds(time);
    let changed = |sensor: &usize| before[*sensor] != now[*sensor];
    for sensor in (0..4).filter(changed) {
        let (name, ticks) = (SHAFTS[sensor], now[sensor]);
        if ticks > 0.0 {
            log.event(format_args!(
                "t = {time} s: {name}.speed is counted by an encoder of {ticks} ticks per revolution, and is followed \
                 as such; set {name}.encoderTicks where that is wrong"
            ));
        } else {
            log.event(format_args!(
                "t = {time} s: {name}.speed is not counted by an encoder of {} ticks after all",
                before[sensor]
            ));
        }
    }
}

/// What `calibrating` learns, in the order of its values.
pub(super) const LEARNT: [&str; 8] = [
    "torqueScale",
    "torqueBias",
    "inertiaError",
    "wheelSpeedBias",
    "stiffnessError",
    "dampingError",
    "gearboxInertiaError",
    "vehicleInertiaError",
];

/// The variables that show a fault, with their values.
struct Evidence<'a>(&'a Observer, Fault);

impl fmt::Display for Evidence<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Observer { u, y, method, .. }, fault) = self;
        match fault {
            Fault::NotFinite | Fault::NoSpeed | Fault::Frozen => write!(
                f,
                "engine.speed = {}, clutch1.speed = {}, clutch2.speed = {}, wheel.speed = {} rad/s",
                short(u.omega_e),
                short(u.omega_c[0]),
                short(u.omega_c[1]),
                short(u.omega_w)
            ),
            Fault::Saturated if table::method(*method) == Method::Calibrating => {
                let told = LEARNT.iter().zip(y.calibration.value).enumerate();
                told.into_iter().try_for_each(|(k, (name, value))| {
                    let comma = if k == 0 { "" } else { ", " };
                    write!(f, "{comma}calibration.{name} = {}", short(value))
                })
            }
            Fault::Saturated => write!(
                f,
                "clutch1.friction = {}, clutch2.friction = {}",
                short(y.friction[0]),
                short(y.friction[1])
            ),
            Fault::Diverged => write!(
                f,
                "innovation.x1 = {}, innovation.x2 = {} rad/s",
                short(y.innovation[0]),
                short(y.innovation[1])
            ),
            Fault::Inconsistent => write!(f, "innovation.consistency = {}", short(y.consistency)),
        }
    }
}

/// A value to three digits.
fn short(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// What the user can do about a fault.
const fn remedy(fault: Fault, method: Method) -> &'static str {
    match fault {
        Fault::NotFinite => "give every input a number",
        Fault::NoSpeed | Fault::Frozen => "check the speed sensors and their connections",
        Fault::Saturated if matches!(method, Method::Calibrating) => {
            "check the engine torque, the speed sensors, and the inertias and stiffness believed"
        }
        Fault::Saturated => "check the force-position maps and nominal frictions",
        Fault::Diverged => "check the ratios, inertias and gains",
        Fault::Inconsistent => "check the sensors, their deviation among the gains, and the ratios",
    }
}
