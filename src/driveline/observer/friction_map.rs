//! Friction over the position: where along its stroke a clutch carries more or less than map and friction tell.
//!
//! T_c = μ(θ) F_map(θ) r_c N of (21), with μ linear between five points from the touch point to the end of the map. What
//! of it is no friction but an error of the force-position map looks the same, and is corrected the same:
//!
//! ```text
//! μ(θ) = Σ w_k(θ) μ_k         z = T̂_c/(F_map r_c N) = wᵀ μ + noise of variance (σ_Tc/(F_map r_c N))² τ/h
//! P_jk = σ_j σ_k ρ^|j−k|       at the start: neighbours are alike, so a point that was never driven follows them
//! ```
//!
//! A clutch teaches while it slips and the other one is open, one scalar measurement per sample; its noise is not
//! white but lasts for some τ, so each counts for h/τ. A walk common to all points forgets a lining that warms.
//! The table is fixed in size and in work: 30 numbers per clutch.
//!
//! ```
//! use dct_driveline::ForceMap;
//! use dct_driveline::observer::friction_map::{FrictionMap, positions};
//!
//! let map = ForceMap::CLUTCH_1;
//! assert_eq!(positions(&map)[2], 6e-3);
//! let mut learnt = FrictionMap::new(0.4, [0.3; 5]);
//! (0..1000).for_each(|_| learnt.learn(&map, 6e-3, 0.26, 1e-4, 1e-3));
//! assert!((learnt.mu()[2] - 0.26).abs() < 1e-3 && learnt.deviation()[2] < 0.01);
//! assert!(learnt.mu()[4] < 0.32 && learnt.deviation()[4] > 0.1);
//! ```

use crate::ForceMap;
use crate::observer::Visit;
use crate::observer::filter::Belief;
use nalgebra::{ComplexField, SMatrix, SVector};

/// Number of points of the table.
pub const POINTS: usize = 5;
/// ρ: correlation of neighbours at the start [1].
const ALIKE: f64 = 0.9;
/// τ: time for which an error of T̂_c lasts [s].
const TAU: f64 = 0.05;
/// Intensity of the walk of all points [1/s].
const WALK: f64 = 1e-6;

/// θ of the points [m], shape (5): evenly from the touch point to the end of the map.
pub fn positions(map: &ForceMap) -> [f64; POINTS] {
    let (touch, end) = ends(map);
    [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| touch + (end - touch) * share)
}

fn ends(map: &ForceMap) -> (f64, f64) {
    let [.., end] = map.position;
    (map.touch_point(), end)
}

/// w of a position [m], shape (5): what each point contributes; constant outside.
fn weights(map: &ForceMap, theta: f64) -> SVector<f64, POINTS> {
    let (touch, end) = ends(map);
    let reach = (end - touch).max(f64::MIN_POSITIVE);
    let place = ((theta - touch) / reach).clamp(0.0, 1.0) * 4.0;
    SVector::from([0.0, 1.0, 2.0, 3.0, 4.0]).map(|k| (1.0 - (place - k).abs()).max(0.0))
}

/// The force-position map that carries with one friction `reference` [1] what `map` carries with `mu` [1], shape (5):
/// F_map(θ) μ(θ)/μ_ref at its points, not descending.
pub fn corrected(map: &ForceMap, mu: [f64; POINTS], reference: f64) -> ForceMap {
    let (mut force, mut least) = (map.force, 0.0);
    for (force, theta) in force.iter_mut().zip(map.position) {
        let share = weights(map, theta).dot(&SVector::from(mu)) / reference;
        least = (*force * share).max(least);
        *force = least;
    }
    ForceMap { force, ..*map }
}

/// Friction over the position of one clutch, and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionMap(Belief<POINTS>);

impl Default for FrictionMap {
    fn default() -> Self {
        Self::new(0.0, [0.0; POINTS])
    }
}

impl FrictionMap {
    /// The same friction `mu` [1] at every point, with standard deviations `sigma` [1], shape (5).
    pub fn new(mu: f64, sigma: [f64; POINTS]) -> Self {
        let mut belief = Belief::new(SVector::repeat(mu), SVector::zeros());
        belief.p = SMatrix::from_fn(|j, k| {
            let apart = (0..j.abs_diff(k)).fold(1.0, |alike, _| alike * ALIKE);
            sigma[j] * sigma[k] * apart
        });
        Self(belief)
    }

    /// Takes the friction `mu` [1] of variance `variance` that a clutch at `theta` [m] shows over `h` [s].
    pub fn learn(&mut self, map: &ForceMap, theta: f64, mu: f64, variance: f64, h: f64) {
        let (belief, w) = (&mut self.0, weights(map, theta));
        belief.p.add_scalar_mut(WALK * h);
        let missed = mu - w.dot(&belief.x);
        let shown = [0, 1, 2, 3, 4].map(|j| (j, w[j]));
        belief.correct(&shown, missed, variance * (TAU / h).max(1.0));
    }

    /// μ at the points [1], shape (5).
    pub fn mu(&self) -> [f64; POINTS] {
        self.0.x.into()
    }

    /// Standard deviations of μ at the points [1], shape (5).
    pub fn deviation(&self) -> [f64; POINTS] {
        let variance = self.0.p.diagonal();
        variance.map(|v| ComplexField::sqrt(v.max(0.0))).into()
    }

    /// Visits every number of the state.
    pub fn visit(&mut self, visit: Visit<'_>) {
        let Belief { x, p } = &mut self.0;
        x.iter_mut().chain(p.iter_mut()).for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::{FrictionMap, positions, weights};
    use crate::ForceMap;

    #[test]
    fn a_point_contributes_up_to_its_neighbours() {
        let map = ForceMap::CLUTCH_1;
        let [_, four, five, ..] = positions(&map);
        let cases = [
            (0.0, [1.0, 0.0, 0.0, 0.0, 0.0]),
            (four, [0.0, 1.0, 0.0, 0.0, 0.0]),
            (0.5 * (four + five), [0.0, 0.5, 0.5, 0.0, 0.0]),
            (1.0, [0.0, 0.0, 0.0, 0.0, 1.0]),
        ];
        for (theta, expected) in cases {
            let missed = weights(&map, theta) - nalgebra::SVector::from(expected);
            assert!(missed.amax() < 1e-12, "{theta} m");
        }
    }

    /// A lining that carries more the further it is pressed, seen at every position of a stroke.
    #[test]
    fn a_friction_that_follows_the_position_is_found() {
        let (map, mut learnt) = (ForceMap::CLUTCH_2, FrictionMap::new(0.1, [0.3; 5]));
        let truth = |theta: f64| 0.2 + 10.0 * theta;
        for k in 0..4000 {
            let theta = 2.2e-3 + 7.8e-3 * f64::from(k) / 4000.0;
            learnt.learn(&map, theta, truth(theta), 1e-4, 1e-3);
        }
        let found = learnt.mu().into_iter().zip(positions(&map));
        for ((mu, theta), deviation) in found.zip(learnt.deviation()) {
            assert!(
                (mu - truth(theta)).abs() < 3.0 * deviation,
                "{theta} m: {mu}"
            );
            assert!(deviation < 0.01, "{theta} m: ± {deviation}");
        }
    }

    /// Neighbours are alike, and the deviation says how far away the last one was.
    #[test]
    fn a_point_that_was_never_driven_follows_its_neighbours() {
        let (map, mut learnt) = (ForceMap::CLUTCH_1, FrictionMap::new(0.4, [0.3; 5]));
        (0..2000).for_each(|_| learnt.learn(&map, 4e-3, 0.26, 1e-4, 1e-3));
        let (mu, deviation) = (learnt.mu(), learnt.deviation());
        assert!((1..4).all(|k| mu[k] < mu[k + 1] && deviation[k] < deviation[k + 1]));
        assert!(mu[4] < 0.33);
    }
}
