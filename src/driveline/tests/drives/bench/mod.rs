//! The exact plant driven through scripted scenarios, its sensors, and the score of an observer.

pub mod faded;
mod random;
pub mod scenarios;
pub mod sensors;
pub mod wet;

use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::observer::calibrating::Gains;
use dct_driveline::observer::prior::Prior;
use dct_driveline::observer::{Estimate, LoadMethod, Method, Observer, Sample, Selected, Settings};
use dct_driveline::params::Actuation;
use dct_driveline::plant::{Input, InputRate, Output, Plant};

/// Knots (time [s], value), linear between, constant outside.
pub type Knots = Vec<(f64, f64)>;

/// A scripted drive.
#[derive(Debug, Clone)]
pub struct Scenario {
    pub name: String,
    pub p: Params,
    pub stop: f64,
    /// Start of engine [rad/s] and vehicle [m/s].
    pub omega_e: f64,
    pub v: f64,
    /// T_e [N·m], before the governors of idle and highest speed.
    pub t_e: Knots,
    /// Positions of the clutches [m].
    pub theta: [Knots; 2],
    /// Pressures on the pistons of wet clutches [Pa].
    pub pressure: [Knots; 2],
    pub t_brake: Knots,
    pub phi: Knots,
    /// (time [s], gears preselected from then on).
    pub gears: Vec<(f64, [i32; 2])>,
}

/// One step of a drive: the truth at its end, and what a perfect sensor measures of it.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    pub time: f64,
    pub y: Output,
    pub sample: Sample,
}

/// A drive as it happened: the sample at the start, then every step.
#[derive(Debug, Clone)]
pub struct Drive {
    pub name: String,
    pub h: f64,
    pub p: Params,
    pub start: Sample,
    pub moments: Vec<Moment>,
}

/// Linear between knots, constant outside.
pub fn at(knots: &Knots, time: f64) -> f64 {
    let end = knots.partition_point(|(t, _)| *t <= time);
    match (end.checked_sub(1), knots.get(end)) {
        (None, _) => knots.first().map_or(0.0, |(_, y)| *y),
        (Some(start), None) => knots[start].1,
        (Some(start), Some((t1, y1))) => {
            let (t0, y0) = knots[start];
            y0 + (y1 - y0) * (time - t0) / (t1 - t0)
        }
    }
}

impl Scenario {
    /// T_e with the governors: the engine neither stalls nor races, whatever the script says.
    fn engine_torque(&self, time: f64, omega_e: f64) -> f64 {
        const IDLE: f64 = 75.0;
        const HIGHEST: f64 = 550.0;
        const GOVERNOR: f64 = 1.5;
        let scripted = at(&self.t_e, time);
        scripted + GOVERNOR * ((IDLE - omega_e).max(0.0) - (omega_e - HIGHEST).max(0.0))
    }

    fn gear(&self, time: f64) -> [i32; 2] {
        let begun = self.gears.iter().rev().find(|(from, _)| *from <= time);
        begun.map_or([1, 2], |(_, gear)| *gear)
    }

    fn actuation(&self, time: f64) -> [Actuation; 2] {
        [0, 1].map(|i| Actuation {
            position: at(&self.theta[i], time),
            pressure: at(&self.pressure[i], time),
        })
    }

    pub fn input(&self, time: f64, omega_e: f64) -> Input {
        let actuation = self.actuation(time);
        Input {
            t_e: self.engine_torque(time, omega_e),
            force: [0, 1].map(|i| self.p.clutch[i].force(actuation[i])),
            gear: self.gear(time),
            t_brake: at(&self.t_brake, time).max(0.0),
            phi: at(&self.phi, time),
        }
    }

    /// Drives the exact plant in steps of `h` [s], inputs held over each.
    pub fn drive(&self, h: f64) -> Drive {
        let p = &self.p;
        let mut u = self.input(0.0, self.omega_e);
        let mut propagators = Propagators::new(p, u.gear, h);
        let mut plant = Plant::start(p, &u, self.omega_e, self.v);
        let y = plant.outputs(p, &propagators.systems, &u);
        let start = measure(self.actuation(0.0), &u, &y);
        let mut moments = Vec::new();
        for k in 0..(self.stop / h).round() as u32 {
            let time = f64::from(k) * h;
            u = self.input(time, plant.x[0]);
            plant.step(p, &mut propagators, &u, &InputRate::default());
            let y = plant.outputs(p, &propagators.systems, &u);
            let sample = measure(self.actuation(time), &u, &y);
            moments.push(Moment {
                time: time + h,
                y,
                sample,
            });
        }
        Drive {
            name: self.name.clone(),
            h,
            p: self.p,
            start,
            moments,
        }
    }
}

/// What is measured at the end of a step over which `u` acted.
fn measure(actuation: [Actuation; 2], u: &Input, y: &Output) -> Sample {
    Sample {
        t_e: u.t_e,
        omega_e: y.omega_e,
        omega_c: y.omega_c,
        omega_w: y.omega_w,
        actuation,
        gear: u.gear,
        t_brake: u.t_brake,
        phi: u.phi,
        t_y: 0.0,
    }
}

/// Sums of squares of truth and errors of T_c1, T_c2, T_o [(N·m)²].
#[derive(Debug, Default, Clone, Copy)]
pub struct Score {
    pub truth: [f64; 3],
    pub error: [f64; 3],
}

impl Score {
    pub fn add(&mut self, y: &Output, estimate: &Estimate) {
        let truth = [y.t_c[0], y.t_c[1], y.t_o];
        let ours = [estimate.t_c[0], estimate.t_c[1], estimate.t_o];
        for i in 0..3 {
            self.truth[i] += truth[i].powi(2);
            self.error[i] += (ours[i] - truth[i]).powi(2);
        }
    }

    /// RMSE in % of the RMS torque, shape (3); 0 for a clutch that never transmits.
    pub fn percent(&self) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            if self.truth[i] > 0.0 {
                100.0 * (self.error[i] / self.truth[i]).sqrt()
            } else {
                0.0
            }
        })
    }
}

/// Runs an observer that believes in `p` along a drive; `each` sees every moment and estimate.
pub fn observe(
    drive: &Drive,
    observer: &mut dyn Observer,
    p: &Params,
    settings: &Settings,
    mut sensors: impl FnMut(Sample) -> Sample,
    mut each: impl FnMut(&Moment, &Estimate),
) -> Score {
    observer.start(p, settings, &sensors(drive.start));
    let mut score = Score::default();
    for moment in &drive.moments {
        let estimate = observer.step(p, settings, &sensors(moment.sample), drive.h);
        score.add(&moment.y, &estimate);
        each(moment, &estimate);
    }
    score
}

/// Runs `calibrating` with true parameters along a drive: RMSE in % of the RMS torque, shape (3), and what it said last.
pub fn calibrated(
    drive: &Drive,
    settings: &Settings,
    sensors: fn(Sample) -> Sample,
) -> ([f64; 3], Estimate) {
    let (mut observer, mut last) = (Selected::new(Method::Calibrating), Estimate::default());
    let each = |_: &_, estimate: &Estimate| last = *estimate;
    let score = observe(drive, &mut observer, &drive.p, settings, sensors, each);
    (score.percent(), last)
}

/// The road of (11) is vouched for: `load.method` = grade.
pub const VOUCHED: Settings = Settings {
    load: LoadMethod::Grade,
    ..Settings::CASE_1
};

/// Settings of a drive that starts with what another has learnt.
pub fn after(learnt: &Estimate) -> Settings {
    Settings {
        mu_n: learnt.friction,
        calibrating: Gains {
            prior: Prior(learnt.calibration.value),
            sigma: learnt.calibration.deviation,
            ..Gains::DEFAULT
        },
        ..Settings::CASE_1
    }
}
