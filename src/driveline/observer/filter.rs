//! Predict and correct of a Kalman filter on the driveline, with scalar measurements one after another.
//!
//! Six states move: (ω_e, ω_o, ω_w, T_s) of [`Speeds`], and T_k of the damper in place of T_c1 or T_c2; all others are
//! constants but for their noise. So only six rows of Φ differ from the identity, and a step costs six rows, not N.

use crate::observer::speeds::Speeds;
use nalgebra::{ComplexField, Matrix4, SMatrix, SVector};

/// States that move: ω_e, ω_o, ω_w, T_s, T_c1, T_c2.
pub const MOVING: usize = 6;
/// Rows of Φ that are not those of the identity.
pub type Rows<const N: usize> = SMatrix<f64, MOVING, N>;
/// Those of ω_e, ω_o, ω_w, T_s.
pub type Motion<const N: usize> = SMatrix<f64, 4, N>;

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

    /// P⁺ = Φ (P + Q/2) Φᵀ + Q/2 for the diagonal Q of a step, shape (N); x̂ is left to the caller.
    ///
    /// In place: Φ P, column by column; its first rows turned into the first columns, as (Φ P)ᵀ; Φ (Φ P)ᵀ. `rows`: the
    /// rows of Φ that move, shape (6, N); `acting`: the states that they move with.
    #[inline]
    pub fn spread(&mut self, rows: &Rows<N>, acting: &[usize], q: &SVector<f64, N>) {
        self.add_noise(q);
        advance(rows, acting, &mut self.p.data.0);
        self.turn();
        advance(rows, acting, &mut self.p.data.0[..MOVING]);
        for (i, j) in pairs(MOVING) {
            let mean = (self.p[(i, j)] + self.p[(j, i)]) * 0.5;
            (self.p[(i, j)], self.p[(j, i)]) = (mean, mean);
        }
        self.add_noise(q);
    }

    /// First rows of P into its first columns, and what of these is among the rows into them.
    fn turn(&mut self) {
        for (i, j) in pairs(MOVING) {
            self.p.swap((i, j), (j, i));
        }
        for i in 0..MOVING {
            for j in MOVING..N {
                self.p[(j, i)] = self.p[(i, j)];
            }
        }
    }

    /// State `k` is `x` with a deviation of `sigma`, independent of the others.
    pub fn forget(&mut self, k: usize, x: f64, sigma: f64) {
        self.x[k] = x;
        self.p.row_mut(k).fill(0.0);
        self.p.column_mut(k).fill(0.0);
        self.p[(k, k)] = sigma * sigma;
    }

    /// State `to` becomes itself plus `factor` times state `from`.
    pub fn add(&mut self, to: usize, from: usize, factor: f64) {
        let Self { x, p } = self;
        x[to] += factor * x[from];
        let row = p.row(from) * factor;
        let mut into = p.row_mut(to);
        into += row;
        let column = p.column(from) * factor;
        let mut into = p.column_mut(to);
        into += column;
    }

    /// Half of the noise of a step, on the diagonal.
    fn add_noise(&mut self, q: &SVector<f64, N>) {
        for j in 0..N {
            self.p[(j, j)] += 0.5 * q[j];
        }
    }

    /// Takes a measurement hᵀ x + noise of variance `r` that misses its prediction by `residual`.
    ///
    /// P⁺ = P − K S Kᵀ, symmetric as written. Returns residual²/S, which is 1 in the mean where the
    /// filter is right about itself.
    pub fn correct(&mut self, h: Terms<'_>, residual: f64, r: f64) -> f64 {
        let p_h = self.column(h);
        let s = along(h, &p_h) + r;
        let k = p_h / s;
        self.x += k * residual;
        self.p.ger(-1.0, &k, &p_h, 1.0); // column by column: no second matrix
        residual * residual / s
    }

    /// P h, shape (N).
    fn column(&self, h: Terms<'_>) -> SVector<f64, N> {
        let mut sum = SVector::zeros();
        for (j, factor) in h {
            sum += self.p.column(*j) * *factor;
        }
        sum
    }

    /// Standard deviation of hᵀ x.
    pub fn deviation(&self, h: Terms<'_>) -> f64 {
        let entry = |j: usize| {
            h.iter()
                .fold(0.0, |sum, (k, by)| sum + self.p[(j, *k)] * by)
        };
        let variance: f64 = h.iter().map(|(j, factor)| factor * entry(*j)).sum();
        ComplexField::sqrt(variance.max(0.0))
    }
}

/// Φ times `columns`, shape (N) each, in place: only the states that move change, by those that are `acting`. The others
/// have columns of zeros in `rows`.
#[inline]
fn advance<const N: usize>(rows: &Rows<N>, acting: &[usize], columns: &mut [[f64; N]]) {
    let rows = &rows.data.0;
    let Some((first, others)) = acting.split_first() else {
        return;
    };
    for column in columns {
        let mut moved = rows[*first].map(|entry| entry * column[*first]);
        for j in others {
            for (sum, entry) in moved.iter_mut().zip(rows[*j]) {
                *sum += entry * column[*j];
            }
        }
        for (state, moved) in column.iter_mut().zip(moved) {
            *state = moved;
        }
    }
}

/// i < j below `end`.
fn pairs(end: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..end).flat_map(|j| (0..j).map(move |i| (i, j)))
}

/// h as the entries that are not 0: where they stand, and what they are. A sensor shows one or two states of all.
pub type Terms<'a> = &'a [(usize, f64)];

/// hᵀ x.
pub fn along<const N: usize>(h: Terms<'_>, x: &SVector<f64, N>) -> f64 {
    h.iter().map(|(j, factor)| factor * x[*j]).sum()
}

/// The free motion over a step: Φ = exp(A h) and Γ = ∫ exp(A t) dt, shape (4, 4), both clutches free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flow {
    /// Φ.
    pub phi: Matrix4<f64>,
    /// Γ: effect of a constant slope [s].
    pub gamma: Matrix4<f64>,
}

impl Flow {
    /// Over a step `h` [s]: series on h/2ⁿ, doubled n times.
    pub fn new(model: &Speeds, h: f64) -> Self {
        const REACH: f64 = 0.1; // of a term over the one before; REACH^9/10! < 1e-15
        let a = model.a();
        let swing = ComplexField::sqrt(model.k / model.j_out);
        let rate = swing + 2.0 * model.c / model.j_out + model.drag / model.j_v;
        let (mut t, mut doublings) = (h, 0);
        while t * rate > REACH && doublings < 30 {
            t *= 0.5;
            doublings += 1;
        }
        let mut term = Matrix4::identity() * t; // transposed, as Γ until it is summed
        let mut gamma = term;
        for n in 2..=10 {
            term = before(&term, &a, t / f64::from(n));
            gamma += term;
        }
        let mut phi = Matrix4::identity() + before(&gamma, &a, 1.0).transpose();
        gamma.transpose_mut();
        for _ in 0..doublings {
            gamma += phi * gamma;
            phi *= phi;
        }
        Self { phi, gamma }
    }

    /// Rows of Φ for states that drive the motion by `by`, shape (4, N), of which the last N − 4 columns count.
    pub fn rows<const N: usize>(&self, by: &Motion<N>) -> Motion<N> {
        let mut rows = Motion::<N>::zeros();
        rows.fixed_columns_mut::<4>(0).copy_from(&self.phi);
        for k in 4..N {
            for j in (0..4).filter(|j| by[(*j, k)] != 0.0) {
                rows.column_mut(k)
                    .axpy(by[(j, k)], &self.gamma.column(j), 1.0);
            }
        }
        rows
    }
}

/// (A M)ᵀ `scale` of Mᵀ, by the entries of A that are not 0: damper and drive shaft join neighbours.
fn before(transposed: &Matrix4<f64>, a: &Matrix4<f64>, scale: f64) -> Matrix4<f64> {
    const JOINED: [&[usize]; 4] = [&[0, 1], &[0, 1, 2, 3], &[1, 2, 3], &[1, 2]];
    let mut product = Matrix4::zeros();
    for (i, joined) in JOINED.into_iter().enumerate() {
        let mut row = [0.0; 4];
        for j in joined {
            let (entry, with) = (a[(i, *j)], &transposed.data.0[*j]);
            for (sum, with) in row.iter_mut().zip(with) {
                *sum += entry * with;
            }
        }
        product.data.0[i] = row.map(|sum| sum * scale);
    }
    product
}

/// All rows of Φ that move, from those of (ω_e, ω_o, ω_w, T_s) with T_k held.
///
/// T_k' = k_d (ω_e − g ω_o) is split: half a step before the motion and half a step after it.
pub fn with_damper<const N: usize>(motion: &Motion<N>, model: &Speeds, h: f64) -> Rows<N> {
    let mut rows = Rows::<N>::identity();
    let mut motion = *motion;
    if let Some(i) = model.engaged {
        let (k, half) = (4 + i, model.twist().map(|twist| 0.5 * h * twist));
        for j in [0, 1] {
            let change = motion.column(k) * half[j];
            let mut column = motion.column_mut(j);
            column += change;
            rows[(k, j)] = half[j];
        }
        let change = motion.row(0) * half[0] + motion.row(1) * half[1];
        let mut row = rows.row_mut(k);
        row += change;
    }
    rows.fixed_rows_mut::<4>(0).copy_from(&motion);
    rows
}

#[cfg(test)]
mod tests {
    use super::{Belief, Flow, Motion, with_damper};
    use crate::Params;
    use crate::observer::speeds::Speeds;
    use crate::reduced::exponential;
    use nalgebra::{SMatrix, SVector, Vector2};

    #[test]
    fn flow_is_the_exponential_of_the_free_motion() {
        let model = Speeds::new(&Params::TABLE_1, [1, 2]);
        for h in [1e-4, 1e-3, 2e-2, 0.3] {
            let mut m = SMatrix::<f64, 8, 8>::zeros();
            m.fixed_view_mut::<4, 4>(0, 0).copy_from(&model.a());
            m.fixed_view_mut::<4, 4>(0, 4).fill_with_identity();
            let expected = exponential(&(m * h));
            let flow = Flow::new(&model, h);
            let [phi, gamma] = [0, 4].map(|j| expected.fixed_view::<4, 4>(0, j).into_owned());
            assert!((flow.phi - phi).amax() < 1e-10 * phi.amax(), "{h}");
            assert!((flow.gamma - gamma).amax() < 1e-10 * gamma.amax(), "{h}");
        }
    }

    /// With an engaged clutch the whole motion is the exponential but for the splitting, of third order in h.
    #[test]
    fn damper_moves_with_the_motion() {
        const N: usize = 6;
        let p = Params::TABLE_1;
        for i in [0, 1] {
            let model = Speeds::new(&p, [1, 2]).behind(&p, Some(i), 1.0);
            let mut a = SMatrix::<f64, N, N>::zeros();
            a.fixed_view_mut::<4, 4>(0, 0).copy_from(&model.a());
            let b = model.b();
            a.fixed_view_mut::<4, 2>(0, 4)
                .copy_from(&b.fixed_columns::<2>(1));
            [a[(4 + i, 0)], a[(4 + i, 1)]] = model.twist();
            let mut by = Motion::<N>::zeros();
            by.fixed_columns_mut::<2>(4)
                .copy_from(&b.fixed_columns::<2>(1));
            let units = SVector::<f64, N>::from([1.0, 0.1, 0.1, 500.0, 50.0, 50.0]);
            let error = |h: f64| {
                let rows = with_damper(&Flow::new(&model, h).rows(&by), &model, h);
                let wrong = rows - exponential(&(a * h));
                SMatrix::<f64, N, N>::from_fn(|j, k| wrong[(j, k)] * units[k] / units[j]).amax()
            };
            assert!(error(1e-3) < 2e-4, "clutch {i}: {}", error(1e-3));
            assert!(
                error(5e-4) < error(1e-3) / 6.0,
                "clutch {i} {}",
                error(5e-4)
            );
        }
    }

    /// The dense product that the six rows save.
    #[test]
    fn six_rows_spread_as_the_whole_matrix_does() {
        let half = SMatrix::<f64, 8, 8>::from_iterator((1..=64_u8).map(|k| 1.0 / f64::from(k)));
        let p = half * half.transpose();
        let q = SVector::<f64, 8>::from([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]);
        let mut phi = SMatrix::<f64, 8, 8>::identity();
        for (i, j) in [(0, 1), (0, 7), (1, 0), (2, 4), (3, 3), (5, 6)] {
            phi[(i, j)] += 0.3;
        }
        let noise = SMatrix::from_diagonal(&q) * 0.5;
        let expected = phi * (p + noise) * phi.transpose() + noise;
        let mut belief = Belief {
            x: SVector::zeros(),
            p,
        };
        let rows = phi.fixed_rows::<6>(0).into_owned();
        belief.spread(&rows, &[0, 1, 2, 3, 4, 5, 6, 7], &q);
        assert!((belief.p - expected).amax() < 1e-12);
    }

    /// Two measurements of one state are their weighted mean.
    #[test]
    fn measurements_are_averaged_by_their_variances() {
        let mut belief = Belief::new(Vector2::new(0.0, 5.0), Vector2::new(1e6, 1.0));
        let h = &[(0, 1.0)];
        for (z, r) in [(1.0, 1.0), (4.0, 2.0)] {
            let residual = z - belief.x[0];
            belief.correct(h, residual, r);
        }
        assert!((belief.x[0] - 2.0).abs() < 1e-9 && belief.x[1] == 5.0);
        assert!((belief.deviation(h).powi(2) - 2.0 / 3.0).abs() < 1e-4);
    }
}
