//! Clutches: force-position map (Fig. 6).

/// Number of points of a force-position map.
pub const MAP_POINTS: usize = 10;

/// Normal force of a clutch over the position of its actuator (Fig. 6).
///
/// Linear between points, constant outside. `position` [m] ascends strictly; `force` [N] is ≥ 0 and
/// does not descend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceMap {
    /// Actuator positions [m], shape (MAP_POINTS).
    pub position: [f64; MAP_POINTS],
    /// Normal forces [N], shape (MAP_POINTS).
    pub force: [f64; MAP_POINTS],
}

impl ForceMap {
    /// Clutch 1 of the preset `paper`. `assumed:` shaped like Fig. 6, which has no numbers.
    pub const CLUTCH_1: Self = Self {
        position: [0.0, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3],
        force: [0.0, 0.0, 250.0, 700.0, 1350.0, 2200.0, 3300.0, 4700.0, 6400.0, 8500.0],
    };
    /// Clutch 2 of the preset `paper`. `assumed:` as for clutch 1.
    pub const CLUTCH_2: Self = Self {
        position: [0.0, 2.2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3, 8e-3, 9e-3, 10e-3],
        force: [0.0, 0.0, 220.0, 680.0, 1330.0, 2200.0, 3350.0, 4800.0, 6600.0, 8800.0],
    };
}
