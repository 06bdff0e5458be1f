//! Vehicles that are driven so that they turn as another one does.

use crate::bench::{Drive, Moment, Scenario};
use dct_driveline::Params;
use dct_driveline::integrate::Propagators;
use dct_driveline::matrices::{E, State, TWIST_D, TWIST_O, TWIST_T, W, slip};
use dct_driveline::observer::Sample;
use dct_driveline::plant::{Input, InputRate, Output, Plant};
use std::ops::Range;

pub const H: f64 = 1e-3;
/// Slip of a clutch that is not stuck [rad/s].
const SLIPS: f64 = 1e-9;

/// φ on which the load is `more` [N·m] than on `phi` [rad], by secants, at the speed of the vehicle `omega_w` [rad/s].
fn steeper(p: &Params, omega_w: f64, phi: f64, more: f64) -> f64 {
    let load = |phi| p.road.load_torque(omega_w, phi);
    let slope = (load(phi + 1e-3) - load(phi)) / 1e-3;
    let goal = load(phi) + more;
    (0..5).fold(phi, |phi, _| phi + (goal - load(phi)) / slope)
}

/// When a torque goes over from clutch 2 to clutch 1 [s].
pub type Handover = Range<f64>;
/// In a drive that ends before.
pub const NEVER: Handover = f64::INFINITY..f64::INFINITY;
/// Time over which it begins and ends to go over [s].
const BEND: f64 = 0.05;
/// Times within which the engine and the wheels turn as they should again [s].
const FOLLOWS: [f64; 2] = [2e-2, 5e-2];

/// Part that has gone over at a time [1], its rate [1/s], and how fast that rises [1/s²], shape (3).
fn gone(handover: &Handover, time: f64) -> [f64; 3] {
    let whole = handover.end - handover.start;
    let (since, most) = (time - handover.start, 1.0 / (whole - BEND));
    let left = whole - since;
    if since <= 0.0 {
        [0.0; 3]
    } else if left <= 0.0 {
        [1.0, 0.0, 0.0]
    } else if since < BEND {
        [since * since, 2.0 * since, 2.0].map(|x| x * most / (2.0 * BEND))
    } else if left < BEND {
        let [part, rate, bend] = [left * left, 2.0 * left, 2.0].map(|x| x * most / (2.0 * BEND));
        [1.0 - part, rate, -bend]
    } else {
        [(since - 0.5 * BEND) * most, most, 0.0]
    }
}

/// What a vehicle carries more than the first one at an instant.
struct More {
    /// T_c1, T_c2 [N·m], shape (2).
    t_c: [f64; 2],
    /// T_v [N·m].
    t_v: f64,
}

impl More {
    /// With so much `more` engine torque [N·m] at a time [s], in a state `x` where the first vehicle was at `first`.
    fn new(p: &Params, g: [f64; 2], more: f64, gone: [f64; 3], x: &State, first: [f64; 2]) -> Self {
        let [part, rate, bend] = gone;
        let (gap, lag) = ((g[0] - g[1]) * more, p.c_o / p.k_o * rate);
        let [e, w] = [x[E] - first[0], x[W] - first[1] + gap * rate / p.k_o];
        let turns = gap * bend / p.k_o + w / FOLLOWS[1];
        let mut t_c = [(part + lag) * more, (1.0 - part - lag) * more];
        t_c[usize::from(part < 0.5)] += p.j_ed() * e / FOLLOWS[0];
        Self {
            t_c,
            t_v: g[1] * more + gap * (part + lag) + p.j_v * turns,
        }
    }
}

/// A vehicle with so much `more` engine torque [N·m], which the load takes, and clutches whose friction, static and kinetic,
/// carries as much more.
pub struct Twin<'a> {
    pub scenario: &'a Scenario,
    pub more: f64,
    pub handover: &'a Handover,
}

impl Twin<'_> {
    /// g1, g2 up to the handover.
    fn g(&self) -> [f64; 2] {
        self.scenario.p.g(self.scenario.gears[0].1)
    }

    /// Inputs from a time [s] on, in a state `x` where ω_e, ω_w of the first vehicle are `first`.
    fn input(&self, time: f64, x: &State, first: [f64; 2]) -> Input {
        let p = &self.scenario.p;
        let more = More::new(p, self.g(), self.more, gone(self.handover, time), x, first);
        let mut u = self.scenario.input(time, first[0]);
        u.t_e += self.more;
        u.phi = steeper(p, self.scenario.v / p.road.r_w, u.phi, more.t_v);
        for (i, slip) in slip(x).into_iter().enumerate() {
            let clutch = &p.clutch[i];
            let (mu, sign) = if slip.abs() > SLIPS {
                (clutch.mu_k, slip.signum())
            } else {
                (clutch.mu_s, 1.0)
            };
            if u.force[i] > 0.0 {
                u.force[i] = (u.force[i] + sign * more.t_c[i] / (mu * clutch.r_c_n)).max(0.0);
            }
        }
        u
    }

    /// At the start, with all that is wound up by so much more.
    fn start(&self, u: &Input) -> Plant {
        let (p, g) = (&self.scenario.p, self.g()[1]);
        let mut plant = Plant::start(p, u, self.scenario.omega_e, self.scenario.v);
        plant.x[TWIST_D] += self.more / p.k_d;
        plant.x[TWIST_T + 1] += g / p.i_f[1] * self.more / p.k_t[1];
        plant.x[TWIST_O] += g * self.more / p.k_o;
        plant
    }

    /// What is driven, and measured, after every step where the first vehicle drives `first`.
    pub fn drive(&self, first: &[Moment], drive: &Drive) -> Drive {
        let p = &self.scenario.p;
        let mut turns = [self.scenario.omega_e, self.scenario.v / p.road.r_w];
        let mut x = State::zeros();
        [x[E], x[W]] = turns;
        let mut u = self.input(0.0, &x, turns);
        let mut propagators = Propagators::new(p, u.gear, H);
        let mut plant = self.start(&u);
        let moved = |moment: &Moment| {
            u = self.input(moment.time - H, &plant.x, turns);
            turns = [moment.y.omega_e, moment.y.omega_w];
            plant.step(p, &mut propagators, &u, &InputRate::default());
            let y = plant.outputs(p, &propagators.systems, &u);
            let sample = seen(&y, moment.sample);
            Moment {
                y,
                sample,
                ..*moment
            }
        };
        let moments = first.iter().map(moved).collect();
        Drive {
            moments,
            ..drive.clone()
        }
    }
}

/// A sample with the speeds of `y`.
fn seen(y: &Output, sample: Sample) -> Sample {
    Sample {
        omega_e: y.omega_e,
        omega_c: y.omega_c,
        omega_w: y.omega_w,
        ..sample
    }
}
