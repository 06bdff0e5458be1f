//! Clutches: force-position map (Fig. 6).

/// Number of points of a force-position map.
pub const MAP_POINTS: usize = 10;

/// Steps that lead from the first point of a map to any other one, each half of those that are left.
const HALVES: [usize; 4] = [5, 2, 1, 1];
const _: () = assert!(HALVES[0] + HALVES[1] + HALVES[2] + HALVES[3] == MAP_POINTS - 1);

/// Normal force of a clutch over the position of its actuator (Fig. 6).
///
/// Linear between points, constant outside. `position` [m] ascends strictly; `force` [N] is ≥ 0 and
/// does not descend.
#[derive(Debug, Clone, Copy)]
pub struct ForceMap {
    /// Actuator positions [m], shape (MAP_POINTS).
    pub position: [f64; MAP_POINTS],
    /// Normal forces [N], shape (MAP_POINTS).
    pub force: [f64; MAP_POINTS],
}

/// Bit by bit: every start of a plant asks whether another one has its parameters.
impl PartialEq for ForceMap {
    fn eq(&self, other: &Self) -> bool {
        apart(&self.position, &other.position) | apart(&self.force, &other.force) == 0
    }
}

/// The bits by which numbers differ; all of them, as that takes less time than to stop at the first.
pub(crate) fn apart<const N: usize>(one: &[f64; N], other: &[f64; N]) -> u64 {
    let differ = |bits, (a, b): (&f64, &f64)| bits | (a.to_bits() ^ b.to_bits());
    one.iter().zip(other).fold(0, differ)
}

impl ForceMap {
    /// Clutch 1 of the preset `paper`. `assumed:` shaped like Fig. 6, which has no numbers.
    pub const CLUTCH_1: Self = Self {
        position: [0.0, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3],
        force: [
            0.0, 0.0, 250.0, 700.0, 1350.0, 2200.0, 3300.0, 4700.0, 6400.0, 8500.0,
        ],
    };
    /// Clutch 2 of the preset `paper`. `assumed:` as for clutch 1.
    pub const CLUTCH_2: Self = Self {
        position: [0.0, 2.2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3],
        force: [
            0.0, 0.0, 220.0, 680.0, 1330.0, 2200.0, 3350.0, 4800.0, 6600.0, 8800.0,
        ],
    };

    /// F_n of Fig. 6: normal force [N] at an actuator position, constant outside the map.
    ///
    /// `theta`: actuator position θ_m [m].
    #[inline(always)]
    pub fn force(&self, theta: f64) -> f64 {
        interpolate(&self.position, &self.force, theta)
    }

    /// [`Self::force`] that looks first between point `piece` and the next, and leaves there where it found it.
    #[inline(always)]
    pub fn force_near(&self, theta: f64, piece: &mut usize) -> f64 {
        let xs = &self.position;
        if theta <= xs[0] {
            return self.force[0];
        }
        let (start, end) = (*piece, *piece + 1);
        if end >= MAP_POINTS || theta <= xs[start] || xs[end] < theta {
            *piece = piece_of(xs, theta);
        }
        on_piece(xs, &self.force, *piece, theta)
    }

    /// dF_n/dθ_m [N/m] on the side of a position towards which it moves: a map has corners.
    ///
    /// `theta`: actuator position θ_m [m]. `rate`: its rate or direction; below 0: the left side.
    pub fn slope(&self, theta: f64, rate: f64) -> f64 {
        let before = |end: &f64| {
            if rate < 0.0 {
                theta <= *end
            } else {
                theta < *end
            }
        };
        match self.position.iter().position(before) {
            Some(end) if end > 0 => {
                (self.force[end] - self.force[end - 1])
                    / (self.position[end] - self.position[end - 1])
            }
            _ => 0.0,
        }
    }

    /// Smallest actuator position [m] that gives a normal force, inverse of [`Self::force`].
    ///
    /// `force`: normal force [N]; outside the map's range the position of the nearest end of it.
    pub fn position(&self, force: f64) -> f64 {
        interpolate(&self.force, &self.position, force)
    }

    /// Touch point (kiss point): largest position [m] at which the force is still 0.
    ///
    /// The first position of the map where even that presses.
    pub fn touch_point(&self) -> f64 {
        let open = self.force.iter().filter(|force| **force <= 0.0).count();
        self.position[open.saturating_sub(1)]
    }
}

/// Value of the piecewise linear `y(x)`, at the left end of a vertical piece, constant outside.
#[inline(always)]
fn interpolate(xs: &[f64; MAP_POINTS], ys: &[f64; MAP_POINTS], x: f64) -> f64 {
    if x <= xs[0] {
        return ys[0];
    }
    on_piece(xs, ys, piece_of(xs, x), x)
}

/// The last point left of `x`, which is right of the first one.
#[inline(always)]
fn piece_of(xs: &[f64; MAP_POINTS], x: f64) -> usize {
    HALVES.into_iter().fold(0, |start, step| {
        let later = start + step;
        if xs[later] < x { later } else { start } // without a branch
    })
}

/// Value right of point `start`, up to the next.
#[inline(always)]
fn on_piece(xs: &[f64; MAP_POINTS], ys: &[f64; MAP_POINTS], start: usize, x: f64) -> f64 {
    let end = start + 1;
    if end >= MAP_POINTS {
        return ys[MAP_POINTS - 1];
    }
    ys[start] + (ys[end] - ys[start]) * (x - xs[start]) / (xs[end] - xs[start])
}

#[cfg(test)]
mod tests {
    use super::{ForceMap, MAP_POINTS};

    const MAPS: [ForceMap; 2] = [ForceMap::CLUTCH_1, ForceMap::CLUTCH_2];

    #[test]
    fn force_is_linear_between_points_and_constant_outside() {
        let map = ForceMap::CLUTCH_1;
        let cases = [
            (-1e-3, 0.0),
            (0.0, 0.0),
            (1e-3, 0.0),
            (2.5e-3, 125.0),
            (3e-3, 250.0),
            (1.0, 8500.0),
        ];
        for (theta, force) in cases {
            assert!((map.force(theta) - force).abs() < 1e-9, "{theta} m");
        }
    }

    /// Plants share what they find to be equal: one that took another map for its own would compute with it.
    #[test]
    fn maps_are_equal_where_all_their_bits_are() {
        let map = ForceMap::CLUTCH_1;
        assert!(map == map && map != ForceMap::CLUTCH_2);
        for k in 0..MAP_POINTS {
            let (mut position, mut force) = (map, map);
            position.position[k] = position.position[k].next_up();
            force.force[k] = force.force[k].next_up();
            assert!(map != position && map != force, "point {k}");
        }
        let mut other = map;
        other.force[0] = -0.0;
        assert!(other != map && other == other);
        other.force[0] = f64::NAN;
        assert!(other == other, "it is found again");
    }

    #[test]
    fn force_near_is_force_from_wherever_it_starts() {
        for map in MAPS {
            for from in 0..MAP_POINTS {
                for k in -2..=230 {
                    let (mut piece, theta) = (from, f64::from(k) * 0.5e-4);
                    let force = map.force_near(theta, &mut piece);
                    assert_eq!(
                        force.to_bits(),
                        map.force(theta).to_bits(),
                        "{from} {theta}"
                    );
                    let again = map.force_near(theta, &mut piece);
                    assert_eq!(again.to_bits(), force.to_bits());
                }
            }
        }
    }

    #[test]
    fn slope_is_that_of_the_side_it_moves_to() {
        let map = ForceMap::CLUTCH_1;
        let cases = [
            (1e-3, 1.0, 0.0),
            (2e-3, 1.0, 250e3),
            (2e-3, -1.0, 0.0),
            (3e-3, -1.0, 250e3),
            (10e-3, 1.0, 0.0),
            (10e-3, -1.0, 2100e3),
            (0.0, -1.0, 0.0),
        ];
        for (theta, rate, slope) in cases {
            assert!(
                (map.slope(theta, rate) - slope).abs() < 1e-6,
                "{theta} m, {rate}"
            );
        }
    }

    #[test]
    fn position_inverts_force_above_the_touch_point() {
        for map in MAPS {
            for step in 1..=100 {
                let force = map.force[9] * f64::from(step) / 100.0;
                let theta = map.position(force);
                assert!((map.force(theta) - force).abs() < 1e-9, "{force} N");
                assert!(theta > map.touch_point());
            }
        }
    }

    #[test]
    fn position_is_the_smallest_that_gives_the_force() {
        for map in MAPS {
            assert_eq!(map.position(0.0), map.position[0]);
            assert_eq!(map.position(-1.0), map.position[0]);
            assert_eq!(map.position(1e6), map.position[9]);
        }
        let mut flat = ForceMap::CLUTCH_1;
        flat.force[5] = flat.force[4];
        assert_eq!(flat.position(flat.force[4]), flat.position[4]);
    }

    #[test]
    fn touch_point_is_where_the_force_begins() {
        assert_eq!(MAPS.map(|map| map.touch_point()), [2e-3, 2.2e-3]);
        let mut pressed = ForceMap::CLUTCH_1;
        pressed.force = pressed.force.map(|force| force + 1.0);
        assert_eq!(pressed.touch_point(), 0.0);
    }
}
