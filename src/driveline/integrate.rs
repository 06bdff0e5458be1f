//! The propagator: exact motion of the driveline between events, on a dyadic ladder of steps.
//!
//! With z = (x, v, v') (state, torques, their ramps) the driveline between two events is z' = M z,
//! so z(t) = Ψ(t) z(0) with Ψ = exp(M t): stiffness (−42 673 1/s with Table 1) costs nothing. A
//! communication step h is cut into 2^LADDER ticks; level k of the ladder spans 2^k ticks. Each level
//! holds E = Ψ − 1, which doubles without cancellation: E(2t) = 2 E(t) + E(t)². Work integrals
//! double alike: ∫₀²ᵗ = ∫₀ᵗ + (∫₀ᵗ)∘Ψ(t), so energies are exact, not sampled.
//!
//! ```
//! use dct_driveline::{Params, integrate::Propagators};
//!
//! let propagators = Propagators::new(&Params::TABLE_1, [1, 2], 1e-3);
//! assert!(propagators.fits([1, 2], 1e-3 * (1.0 + 1e-12)));
//! assert!(!propagators.fits([1, 2], 2e-3));
//! ```

use nalgebra::{SMatrix, SVector};

use crate::Params;
use crate::plant_matrices::{
    AUGMENTED, C, D, E, STATES, State, System, Systems, TORQUES, Torques, W,
};

/// Levels of the ladder below a whole step: events are located to h/2^LADDER.
pub const LADDER: usize = 12;
/// Ticks in a communication step.
pub const TICKS: u32 = 1 << LADDER;
/// Two communication steps count as the same within this [1].
const SAME_STEP: f64 = 1e-9;
/// ‖M t‖ below which the series below is exact to round-off [1].
const SERIES_REACH: f64 = 0.05;
/// Terms of the exponential series: SERIES_REACH^11 / 11! < 1e-21.
const SERIES_TERMS: u32 = 10;

/// State, torques and their ramps, shape (18).
pub type Augmented = SVector<f64, AUGMENTED>;
type Square = SMatrix<f64, AUGMENTED, AUGMENTED>;
/// ω_e, slip 1, slip 2, ω_w: the speeds that torques work on.
type Worked = SMatrix<f64, 4, AUGMENTED>;

/// Motion over one level of the ladder with one choice of engaged clutches.
#[derive(Debug, Clone, Copy)]
pub struct Rung {
    /// Time the rung spans [s].
    pub t: f64,
    /// x(t) − x(0) from z(0), shape (10, 18).
    change: SMatrix<f64, STATES, AUGMENTED>,
    /// ∫ ω dτ of the worked speeds from z(0), shape (4, 18).
    angle: Worked,
    /// ∫ τ ω dτ of the worked speeds from z(0), shape (4, 18).
    moment: Worked,
    /// ∫ viscous power dτ as a quadratic form of z(0).
    viscous: Form,
}

impl Rung {
    /// x(t) from z(0).
    pub fn end(&self, z: &Augmented) -> State {
        z.fixed_rows::<STATES>(0) + self.change * z
    }

    /// ω_w(t) [rad/s] from z(0).
    pub fn wheel_speed(&self, z: &Augmented) -> f64 {
        z[W] + (self.change.fixed_rows::<1>(W) * z)[0]
    }

    /// ∂ω_w(t) / ∂T_v' [s²/(kg·m²)]: effect of the ramp of the load on the wheel speed.
    pub fn wheel_speed_by_load_ramp(&self) -> f64 {
        self.change[(W, AUGMENTED - 1)]
    }

    /// Work of T_e, T_c1, T_c2, T_v on ω_e, slip 1, slip 2, ω_w [J], shape (4).
    pub fn work(&self, z: &Augmented) -> Torques {
        let torque = z.fixed_rows::<TORQUES>(STATES);
        let ramp = z.fixed_rows::<TORQUES>(STATES + TORQUES);
        torque.component_mul(&(self.angle * z)) + ramp.component_mul(&(self.moment * z))
    }

    /// Energy lost in the dampers [J].
    pub fn viscous_loss(&self, z: &Augmented) -> f64 {
        self.viscous.of(z)
    }

    fn zero() -> Self {
        Self {
            t: 0.0,
            change: SMatrix::zeros(),
            angle: Worked::zeros(),
            moment: Worked::zeros(),
            viscous: Form::zero(),
        }
    }

    /// Rung of twice the span.
    fn doubled(&self) -> Self {
        let change = full_change(&self.change, self.t);
        let psi = Square::identity() + change;
        let angle = self.angle * psi;
        let first = self.viscous.matrix();
        Self {
            t: 2.0 * self.t,
            change: self.change * 2.0 + self.change * change,
            angle: self.angle + angle,
            moment: self.moment + self.moment * psi + angle * self.t,
            viscous: Form::new(&(first + psi.transpose() * first * psi)),
        }
    }

    /// Rung of a span with ‖M t‖ ≤ SERIES_REACH; integrals by Gauss' rule of order 6.
    fn base(system: &System, viscous: &SMatrix<f64, STATES, STATES>, t: f64) -> Self {
        let m = generator(system);
        let change = series(&m, t);
        let mut rung = Self {
            t,
            change: change.fixed_rows::<STATES>(0).into_owned(),
            angle: Worked::zeros(),
            moment: Worked::zeros(),
            viscous: Form::zero(),
        };
        let mut loss = Square::zeros();
        for (node, weight) in gauss(t) {
            let psi = Square::identity() + series(&m, node);
            let x = psi.fixed_rows::<STATES>(0);
            let worked = worked_speeds(&psi) * weight;
            rung.angle += worked;
            rung.moment += worked * node;
            loss += x.transpose() * viscous * x * weight;
        }
        rung.viscous = Form::new(&loss);
        rung
    }
}

/// Entries of the upper triangle of an (18, 18) matrix.
const TRIANGLE: usize = AUGMENTED * (AUGMENTED + 1) / 2;

/// A quadratic form of z: upper triangle by columns, entries off the diagonal doubled.
#[derive(Debug, Clone, Copy)]
struct Form([f64; TRIANGLE]);

impl Form {
    const fn zero() -> Self {
        Self([0.0; TRIANGLE])
    }

    fn new(symmetric: &Square) -> Self {
        let mut form = Self::zero();
        let entries = (0..AUGMENTED).flat_map(|j| (0..=j).map(move |i| (i, j)));
        for (place, (i, j)) in form.0.iter_mut().zip(entries) {
            *place = symmetric[(i, j)] + if i == j { 0.0 } else { symmetric[(j, i)] };
        }
        form
    }

    fn matrix(&self) -> Square {
        let mut matrix = Square::zeros();
        let entries = (0..AUGMENTED).flat_map(|j| (0..=j).map(move |i| (i, j)));
        for (value, (i, j)) in self.0.iter().zip(entries) {
            matrix[(i, j)] += 0.5 * value;
            matrix[(j, i)] += 0.5 * value;
        }
        matrix
    }

    /// Value of the form at z.
    fn of(&self, z: &Augmented) -> f64 {
        let mut sum = 0.0;
        let mut rest = &self.0[..];
        for j in 0..AUGMENTED {
            let (column, next) = rest.split_at(j + 1);
            sum += z[j] * column.iter().zip(z.iter()).map(|(a, z)| a * z).sum::<f64>();
            rest = next;
        }
        sum
    }
}

/// Propagators of a step h for every choice of engaged clutches and every level of the ladder.
#[derive(Debug, Clone)]
pub struct Propagators {
    /// Communication step [s].
    pub h: f64,
    /// The driveline they were built for.
    pub systems: Systems,
    /// By engaged clutches (none, 1, 2, both), then by level: level k spans 2^k ticks.
    rungs: [[Rung; LADDER + 1]; 4],
}

impl Propagators {
    /// Propagators of a driveline for a communication step.
    ///
    /// `gear`: gears preselected on the two shafts, shape (2). `h`: communication step [s], > 0 and finite.
    pub fn new(p: &Params, gear: [i32; 2], h: f64) -> Self {
        let systems = Systems::new(p, gear);
        let mut new = Self {
            h,
            systems,
            rungs: [[Rung::zero(); LADDER + 1]; 4],
        };
        new.fill();
        new
    }

    /// Turns these into the propagators of other gears or another step, in place.
    ///
    /// Same arguments as [`Self::new`].
    pub fn rebuild(&mut self, p: &Params, gear: [i32; 2], h: f64) {
        self.h = h;
        self.systems = Systems::new(p, gear);
        self.fill();
    }

    fn fill(&mut self) {
        for (rungs, system) in self.rungs.iter_mut().zip(&self.systems.by_stuck) {
            fill_ladder(rungs, system, &self.systems.viscous, self.h);
        }
    }

    /// Whether they serve a step of `h` [s] with these gears; within 1e-9 relative they do.
    pub fn fits(&self, gear: [i32; 2], h: f64) -> bool {
        self.systems.gear == gear && (h - self.h).abs() <= SAME_STEP * self.h
    }

    /// Rung at a level with the clutches of `stuck` (bit i: clutch i) engaged.
    pub fn rung(&self, stuck: usize, level: usize) -> &Rung {
        &self.rungs[stuck & 3][level.min(LADDER)]
    }
}

fn fill_ladder(
    rungs: &mut [Rung; LADDER + 1],
    system: &System,
    viscous: &SMatrix<f64, STATES, STATES>,
    h: f64,
) {
    let norm = system
        .a
        .abs()
        .row_sum()
        .amax()
        .max(system.a.abs().column_sum().amax());
    let mut below = 0;
    let mut t = h / f64::from(TICKS);
    while norm * t > SERIES_REACH {
        t *= 0.5;
        below += 1;
    }
    let mut rung = Rung::base(system, viscous, t);
    for _ in 0..below {
        rung = rung.doubled();
    }
    for place in rungs {
        *place = rung;
        rung = rung.doubled();
    }
}

/// M of z' = M z, shape (18, 18).
fn generator(system: &System) -> Square {
    let mut m = Square::zeros();
    m.fixed_view_mut::<STATES, STATES>(0, 0)
        .copy_from(&system.a);
    m.fixed_view_mut::<STATES, TORQUES>(0, STATES)
        .copy_from(&system.b);
    m.fixed_view_mut::<TORQUES, TORQUES>(STATES, STATES + TORQUES)
        .fill_with_identity();
    m
}

/// exp(M t) − 1 by its series, shape (18, 18).
fn series(m: &Square, t: f64) -> Square {
    let step = m * t;
    let mut term = step;
    let mut sum = term;
    for k in 2..=SERIES_TERMS {
        term = term * step / f64::from(k);
        sum += term;
    }
    sum
}

/// Ψ(t) − 1 from its first ten rows: torques grow by their ramps.
fn full_change(change: &SMatrix<f64, STATES, AUGMENTED>, t: f64) -> Square {
    let mut full = Square::zeros();
    full.fixed_rows_mut::<STATES>(0).copy_from(change);
    for k in STATES..STATES + TORQUES {
        full[(k, k + TORQUES)] = t;
    }
    full
}

fn worked_speeds(psi: &Square) -> Worked {
    let mut rows = Worked::zeros();
    rows.set_row(0, &psi.row(E));
    rows.set_row(1, &(psi.row(D) - psi.row(C)));
    rows.set_row(2, &(psi.row(D) - psi.row(C + 1)));
    rows.set_row(3, &psi.row(W));
    rows
}

/// Nodes and weights of Gauss' three-point rule on [0, t].
fn gauss(t: f64) -> [(f64, f64); 3] {
    let reach = nalgebra::ComplexField::sqrt(0.6_f64);
    [
        (0.5 * t * (1.0 - reach), t * 5.0 / 18.0),
        (0.5 * t, t * 8.0 / 18.0),
        (0.5 * t * (1.0 + reach), t * 5.0 / 18.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::{Augmented, LADDER, Propagators};
    use crate::Params;
    use crate::plant_matrices::{STATES, State, Torques, W};

    const H: f64 = 1e-3;

    fn start() -> Augmented {
        let x = [
            200.0, 198.0, 190.0, 190.0, 12.0, 11.9, 0.03, 1e-3, 2e-3, 0.05,
        ];
        let v = [60.0, 40.0, -25.0, 300.0, 2e3, -1e3, 5e2, 1e4];
        Augmented::from_iterator(x.into_iter().chain(v))
    }

    /// z at the end of a rung: torques grow by their ramps.
    fn advanced(x_end: &State, z: &Augmented, t: f64) -> Augmented {
        let mut end = *z;
        end.fixed_rows_mut::<STATES>(0).copy_from(x_end);
        for k in STATES..STATES + 4 {
            end[k] += t * z[k + 4];
        }
        end
    }

    #[test]
    fn shortest_rung_follows_the_derivative() {
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], H / 1e3);
        let z = start();
        let (x, v) = (
            z.fixed_rows::<STATES>(0).into(),
            z.fixed_rows::<4>(STATES).into(),
        );
        for set in 0..4_usize {
            let rung = propagators.rung(set, 0);
            let slope = (rung.end(&z) - x) / rung.t;
            let x_dot = propagators.systems.by_stuck[set].derivative(&x, &v);
            assert!((slope - x_dot).amax() < 1e-3 * x_dot.amax(), "{set}");
        }
    }

    #[test]
    fn a_rung_is_twice_the_one_below() {
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], H);
        let z = start();
        for (set, level) in (0..4).flat_map(|set| (1..=LADDER).map(move |level| (set, level))) {
            let (long, half) = (
                propagators.rung(set, level),
                propagators.rung(set, level - 1),
            );
            let middle = advanced(&half.end(&z), &z, half.t);
            assert!((long.end(&z) - half.end(&middle)).amax() < 1e-9);
            let work: Torques = half.work(&z) + half.work(&middle);
            assert!((long.work(&z) - work).amax() < 1e-9 * work.amax());
            let loss = half.viscous_loss(&z) + half.viscous_loss(&middle);
            assert!((long.viscous_loss(&z) - loss).abs() < 1e-9 * loss);
        }
    }

    #[test]
    fn effect_of_the_load_ramp_is_the_one_of_the_motion() {
        let propagators = Propagators::new(&Params::TABLE_1, [1, 2], H);
        let rung = propagators.rung(1, LADDER);
        let mut z = start();
        let before = rung.wheel_speed(&z);
        assert!((before - rung.end(&z)[W]).abs() < 1e-12);
        z[17] += 1e6;
        let change = rung.wheel_speed(&z) - before;
        assert!((change - 1e6 * rung.wheel_speed_by_load_ramp()).abs() < 1e-9 * change.abs());
    }

    #[test]
    fn rebuilt_equals_new() {
        let p = Params::TABLE_1;
        let mut rebuilt = Propagators::new(&p, [1, 2], H);
        rebuilt.rebuild(&p, [1, 0], 3.0 * H);
        let new = Propagators::new(&p, [1, 0], 3.0 * H);
        assert!(rebuilt.fits([1, 0], 3.0 * H) && !rebuilt.fits([1, 2], 3.0 * H));
        let z = start();
        assert_eq!(rebuilt.rung(2, 5).end(&z), new.rung(2, 5).end(&z));
    }
}
