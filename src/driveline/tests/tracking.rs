//! The closed loop: torque requests to positions, with and without the friction that is learnt.
//!
//! The requests are the capacities of the paper's positions with the true friction, so a control that
//! knew it would reproduce the paper's manoeuvres.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    dead_code,
    reason = "helpers of tests"
)]

mod golden_files;

use dct_driveline::Params;
use dct_driveline::control::{limit_rate, position};
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::Systems;
use dct_driveline::observer::{LoadMethod, Observer, Paper, Sample, Settings};
use dct_driveline::params::Actuation;
use dct_driveline::plant::{ClutchState, Input, InputRate, Plant};
use golden_files::Case;

const H: f64 = 1e-3;
const GEAR: [i32; 2] = [1, 2];
/// Fastest motion of the actuators [m/s].
const RATE: f64 = 0.2;

/// Sums over the samples in which a clutch slips, per clutch.
#[derive(Debug, Default)]
struct Tracking {
    count: [f64; 2],
    square: [f64; 2],
}

impl Tracking {
    fn add(&mut self, i: usize, error: f64) {
        self.count[i] += 1.0;
        self.square[i] += error * error;
    }

    /// RMS error of both clutches while they slip [N·m].
    fn rms(&self) -> f64 {
        (self.square.iter().sum::<f64>() / self.count.iter().sum::<f64>()).sqrt()
    }
}

/// RMS tracking error while slipping [N·m] over the paper's scenario.
fn run(mu_n: [f64; 2], feedback: bool) -> Tracking {
    let (p, case) = (Params::TABLE_1, Case::read("paper_compliant"));
    let settings = Settings {
        mu_n,
        load: LoadMethod::Momentum,
        ..Settings::CASE_1
    };
    let request = |time: f64| {
        ["clutch1.position", "clutch2.position"].map(|name| case.scenario.at(name, time))
    };
    let capacity = |i: usize, theta: f64| {
        let clutch = &p.clutch[i];
        clutch.mu_k * clutch.map.force(theta) * clutch.r_c_n
    };
    let mut propagators = Propagators::new(&p, GEAR, H);
    let (mut theta, mut observer) = ([0.0; 2], Paper::default());
    let mut plant: Option<Plant> = None;
    let mut tracking = Tracking::default();
    for k in 0..30_000_u32 {
        let time = f64::from(k) * H;
        let u = Input {
            t_e: case.scenario.at("engine.torque", time),
            force: [0, 1].map(|i| p.clutch[i].map.force(theta[i])),
            gear: GEAR,
            t_brake: 0.0,
            phi: case.scenario.at("road.grade", time),
        };
        let first = plant.is_none();
        let plant = plant.get_or_insert_with(|| Plant::start(&p, &u, case.omega_e, case.v));
        let measure = |plant: &Plant, systems: &Systems| {
            let y = plant.outputs(&p, systems, &u);
            let actuation = theta.map(|position| Actuation {
                position,
                pressure: 0.0,
            });
            (
                y,
                Sample {
                    t_e: u.t_e,
                    omega_e: y.omega_e,
                    omega_c: y.omega_c,
                    omega_w: y.omega_w,
                    actuation,
                    gear: GEAR,
                    t_brake: 0.0,
                    phi: u.phi,
                    t_y: 0.0,
                },
            )
        };
        if first {
            observer.start(&p, &settings, &measure(plant, &propagators.systems).1);
        }
        plant.step(&p, &mut propagators, &u, &InputRate::default());
        let (y, sample) = measure(plant, &propagators.systems);
        let estimate = observer.step(&p, &settings, &sample, H);
        let wanted = request(time);
        for i in [0, 1] {
            if y.state[i] == ClutchState::Slipping {
                tracking.add(i, y.t_c[i].abs() - capacity(i, wanted[i]));
            }
            let mu = if feedback {
                estimate.friction[i]
            } else {
                mu_n[i]
            };
            let target = position(&p.clutch[i], capacity(i, wanted[i]), mu);
            theta[i] = limit_rate(theta[i], target, RATE, H);
        }
    }
    tracking
}

#[test]
fn feedback_quarters_the_tracking_error_at_least() {
    for mu_n in [[0.4, 0.1], [0.1, 0.4]] {
        let [with, without] = [true, false].map(|feedback| run(mu_n, feedback));
        println!(
            "{mu_n:?}: {:.2} N·m with, {:.2} without; {with:?} {without:?}",
            with.rms(),
            without.rms()
        );
        assert!(with.rms() <= 0.25 * without.rms());
    }
}
