//! Predict and correct of a Kalman filter, with scalar measurements one after another.

use nalgebra::{SMatrix, SVector};

/// x̂ and P of a filter with N states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief<const N: usize> {
    /// x̂, shape (N).
    pub x: SVector<f64, N>,
    /// P: covariance of the error, shape (N, N), symmetric.
    pub p: SMatrix<f64, N, N>,
}

impl<const N: usize> Belief<N> {
    /// x̂ with standard deviations `sigma`, shape (N), that are independent.
    pub fn new(x: SVector<f64, N>, sigma: SVector<f64, N>) -> Self {
        Self {
            x,
            p: SMatrix::from_diagonal(&sigma.component_mul(&sigma)),
        }
    }

    /// P⁺ = Φ P Φᵀ + Q; x̂ is left to the caller.
    pub fn spread(&mut self, phi: &SMatrix<f64, N, N>, q: &SMatrix<f64, N, N>) {
        let p = phi * self.p * phi.transpose() + q;
        self.p = (p + p.transpose()) * 0.5;
    }

    /// Takes a measurement hᵀ x + noise of variance `r` that misses its prediction by `residual`.
    ///
    /// P⁺ = P − K S Kᵀ, symmetric as written. Returns residual²/S, which is 1 in the mean where the
    /// filter is right about itself.
    pub fn correct(&mut self, h: &SVector<f64, N>, residual: f64, r: f64) -> f64 {
        let p_h = self.p * h;
        let s = h.dot(&p_h) + r;
        let k = p_h / s;
        self.x += k * residual;
        self.p -= k * k.transpose() * s;
        residual * residual / s
    }

    /// Standard deviation of hᵀ x.
    pub fn deviation(&self, h: &SVector<f64, N>) -> f64 {
        let variance = h.dot(&(self.p * h));
        nalgebra::ComplexField::sqrt(variance.max(0.0))
    }
}

/// Φ = exp(A h) and Q = ∫ Φ(t) Q_c Φ(t)ᵀ dt over a step `h` [s], exactly: Q(2t) = Q(t) + Φ(t) Q(t) Φ(t)ᵀ.
///
/// `a`: shape (N, N). `q_c`: intensities per second, shape (N).
pub fn discretise<const N: usize>(
    a: &SMatrix<f64, N, N>,
    q_c: &SVector<f64, N>,
    h: f64,
) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    const REACH: f64 = 1e-3; // terms of third order are left out of Q(t) at the start
    let (mut t, mut doublings) = (h, 0);
    while (a * t).amax() > REACH && doublings < 30 {
        t *= 0.5;
        doublings += 1;
    }
    let q_c = SMatrix::from_diagonal(q_c);
    let drift = a * q_c;
    let second = (a * drift + drift.transpose() * a.transpose()) + drift * a.transpose() * 2.0;
    let mut q = q_c * t + (drift + drift.transpose()) * (t * t / 2.0) + second * (t * t * t / 6.0);
    let mut phi = crate::reduced::exponential(&(a * t));
    for _ in 0..doublings {
        q += phi * q * phi.transpose();
        phi = phi * phi;
    }
    (phi, q)
}

#[cfg(test)]
mod tests {
    use super::{Belief, discretise};
    use nalgebra::{Matrix2, Vector2};

    /// Closed form of an integrator driven by a random walk.
    #[test]
    fn a_random_walk_that_is_integrated_spreads_with_the_cube_of_time() {
        let a = Matrix2::new(0.0, 3.0, 0.0, 0.0);
        let (q, h) = (2.0, 0.7);
        let (phi, spread) = discretise(&a, &Vector2::new(0.0, q), h);
        let expected = Matrix2::new(
            9.0 * q * h * h * h / 3.0,
            3.0 * q * h * h / 2.0,
            3.0 * q * h * h / 2.0,
            q * h,
        );
        assert!((phi - Matrix2::new(1.0, 3.0 * h, 0.0, 1.0)).amax() < 1e-12);
        assert!(
            (spread - expected).amax() < 1e-9 * expected.amax(),
            "{spread}"
        );
    }

    /// Two measurements of one state are their weighted mean.
    #[test]
    fn measurements_are_averaged_by_their_variances() {
        let mut belief = Belief::new(Vector2::new(0.0, 5.0), Vector2::new(1e6, 1.0));
        let h = Vector2::new(1.0, 0.0);
        for (z, r) in [(1.0, 1.0), (4.0, 2.0)] {
            let residual = z - belief.x[0];
            belief.correct(&h, residual, r);
        }
        assert!((belief.x[0] - 2.0).abs() < 1e-9 && belief.x[1] == 5.0);
        assert!((belief.deviation(&h).powi(2) - 2.0 / 3.0).abs() < 1e-4);
    }
}
