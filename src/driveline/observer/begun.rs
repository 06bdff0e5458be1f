//! How `calibrating` begins: from rest, or in the middle of a drive, with a drive shaft that is wound up.
//!
//! No speed shows at once what a pressed clutch carries and by how much the drive shaft is wound up, ω_o' and ω_w' do within some
//! 10 ms. Until then an error of T_s looks like one of inertia: of a start in first gear under 560 N·m, with nothing wrong,
//! it made J_ed 60 % too large, and T_o 300 N·m wrong for seconds. So:
//!
//! ```text
//! a clutch slips:      T_c, T_s within what its friction, as believed, can carry; find
//! one is engaged:      as from rest; where within 50 ms Σ (θ̂/σ)² > 1.25, again, within what T_e can carry; find
//! find:                1 s in which T_c, T_s, T_v are estimated and nothing is learnt; then all deviations are those of a start
//! ```
//!
//! Σ counts β, δ, w, κ, γ, λ, ν. Of 14 starts in gear under 285 to 654 N·m it is 1.4 to 5.9 within 50 ms, in steps of 1, 5 and 10 ms, with and
//! without noise; of one under 236 N·m, 0.7, so it goes unnoticed and costs 28 N·m of T_o. Of tip-in and kick-down, which begin with an
//! engaged clutch and nothing wound up, 0.2 with parameters 20 % wrong or T_e 5 % and 2 N·m; with 0.1 rad/s of noise 1.4 at most of 100
//! seeds of tip-in, 2.1 of 60 of kick-down in steps of 10 ms, and such a seed begins again for nothing.

use crate::observer::calibrating::{Calibrating, WHEEL};
use crate::observer::calibrating_model::{LEARNT, N, Vector};
use crate::observer::instant::Instant;
use crate::observer::tracker::{SHARED, T_C, T_S, T_V, Tracker};
use crate::observer::{Settings, lasting};
use nalgebra::ComplexField;

/// Time for which torques are found before anything is learnt [s].
const FIND: f64 = lasting(1.0);
/// Time for which a start in gear may turn out to be one with a drive shaft that is wound up [s].
const SUSPECT: f64 = lasting(0.05);
/// Σ (θ̂/σ)² by which it does [1].
const TOO_MUCH: f64 = 1.25;

impl Calibrating {
    /// Starts from measurements, of a drive shaft that is not wound up.
    pub(super) fn begin(&mut self, now: &Instant<'_>, settings: &Settings) {
        self.tracker.start(now, WHEEL);
        let resistance = self.view(now.p, now.sample).resistance();
        self.tracker.belief.x[T_V] -= resistance;
        self.believe_road(now, settings);
        self.walk.mean = self.tracker.belief.x[T_V];
    }

    /// With a clutch engaged T_v is that of (11), as far as it is vouched for: behind it no speed tells T_v from β.
    fn believe_road(&mut self, now: &Instant<'_>, settings: &Settings) {
        let Instant { p, sample, .. } = *now;
        let t_v = p.road.load_torque(sample.omega_w, sample.phi);
        let vouched = settings.load.vouched(p, t_v);
        if let (Some(variance), Some(_)) = (vouched, self.tracker.engaged) {
            let grade = t_v - self.view(p, sample).resistance();
            let belief = &mut self.tracker.belief;
            belief.forget(T_V, grade, ComplexField::sqrt(variance));
        }
    }

    /// What a start leaves to be found.
    pub(super) fn suspect(&mut self, now: &Instant<'_>) {
        match (self.tracker.engaged, now.pressed()) {
            (Some(_), _) => self.finding = -SUSPECT,
            (None, [false, false]) => {}
            _ => self.wind(now),
        }
    }

    /// The drive shaft may be wound up; torques are found first.
    fn wind(&mut self, now: &Instant<'_>) {
        self.tracker.wind(now);
        self.finding = FIND;
    }

    /// Finds it, after a step of `h` [s].
    pub(super) fn find(&mut self, now: &Instant<'_>, settings: &Settings, h: f64) {
        if self.finding < 0.0 && self.learnt(&settings.calibrating.start()) > TOO_MUCH {
            self.clear(settings);
            self.begin(now, settings);
            self.wind(now);
        } else if self.finding < 0.0 {
            self.finding = (self.finding + h).min(0.0);
        } else if self.finding > 0.0 {
            self.finding = (self.finding - h).max(0.0);
            self.unlearn(now, settings);
        }
    }

    /// Σ (θ̂/σ)² of the parameters [1], σ: deviations of the states at the start, shape (15).
    fn learnt(&self, sigma: &Vector) -> f64 {
        let shares = (SHARED..SHARED + LEARNT).filter(|k| sigma[*k] > 0.0);
        let squares = shares.map(|k| {
            let share = self.tracker.belief.x[k] / sigma[k];
            share * share
        });
        squares.sum()
    }

    /// Parameters as at the start, and, once torques are found, their deviations.
    fn unlearn(&mut self, now: &Instant<'_>, settings: &Settings) {
        let (gains, belief) = (&settings.calibrating, &mut self.tracker.belief);
        let sigma = gains.start();
        (SHARED..N).for_each(|k| belief.forget(k, 0.0, sigma[k]));
        gains.correlate(&mut belief.p);
        if self.finding == 0.0 {
            (T_S..SHARED).for_each(|k| belief.forget(k, belief.x[k], sigma[k]));
            self.believe_road(now, settings);
        }
    }
}

impl<const K: usize> Tracker<K> {
    /// Clutches that are pressed may carry, and have wound the drive shaft by, as much as the engine gives or, of one that slips,
    /// the friction believed can.
    fn wind(&mut self, now: &Instant<'_>) {
        let (levers, t_e) = (now.levers(), now.sample.t_e);
        let p = &mut self.belief.p;
        for i in [0, 1] {
            let engaged = self.engaged == Some(i);
            let slips = self.friction.mu[i] * levers[i];
            let carried = if engaged { t_e } else { slips };
            let shaft = self.g[i] * carried;
            p[(T_C + i, T_C + i)] += carried * carried;
            p[(T_S, T_S)] += shaft * shaft;
        }
    }
}
