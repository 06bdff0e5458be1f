//! What the driveline is doing, and how much of the clutches' friction it shows.

use crate::Params;
use crate::observer::Sample;
use crate::observer::instant::Instant;
use crate::observer::lock::SLIP;
use nalgebra::ComplexField;

/// What the two clutches do, from actuators and measured slip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Phase {
    /// No clutch transmits.
    #[default]
    Open = 1,
    /// One clutch transmits and slips: launch, creep.
    Slipping = 2,
    /// One clutch is engaged, the other open: drive.
    Engaged = 3,
    /// Both clutches transmit: shift.
    Handover = 4,
}

impl Phase {
    /// The phase of a sample, given which clutches are engaged.
    pub fn of(p: &Params, sample: &Sample, engaged: [bool; 2]) -> Self {
        Self::from_clutches(pressed(p, sample), engaged)
    }

    /// The phase, given which clutches are above their touch point and which are engaged.
    pub(super) fn from_clutches(pressed: [bool; 2], engaged: [bool; 2]) -> Self {
        match pressed {
            [false, false] => Self::Open,
            [true, true] => Self::Handover,
            [one, _] if engaged[usize::from(!one)] => Self::Engaged,
            _ => Self::Slipping,
        }
    }
}

/// Clutches above their touch point, shape (2).
pub fn pressed(p: &Params, sample: &Sample) -> [bool; 2] {
    [0, 1].map(|i| p.clutch[i].force(sample.actuation[i]) > 0.0)
}

/// The clutch that is above its touch point while the other is not.
pub fn alone(now: &Instant<'_>) -> Option<usize> {
    match now.pressed() {
        [true, false] => Some(0),
        [false, true] => Some(1),
        _ => None,
    }
}

/// How well speeds show the friction of the clutches that slip [1], 0 to 1.
///
/// A torque T_ci moves (ω_e, ω_o) by the direction d_i = (−1/√J_ed, g_i/√J_out), scaled by energy. One
/// clutch slipping alone is seen fully: 1. Two are told apart by the sine of the angle between d_1 and
/// d_2. No clutch that slips shows no friction: 0.
pub fn excitation(p: &Params, sample: &Sample) -> f64 {
    let now = Instant::new(p, sample);
    shown(&now, now.pressed())
}

/// As [`excitation`], given which clutches are above their touch point.
pub(super) fn shown(now: &Instant<'_>, pressed: [bool; 2]) -> f64 {
    let slips = [0, 1].map(|i| pressed[i] && now.sample.slip()[i].abs() > SLIP);
    match (slips, pressed) {
        ([false, false], _) => 0.0,
        (_, [true, true]) => angle(now.p, now.g),
        _ => 1.0,
    }
}

/// |sin| of the angle between the effects of the two clutches [1].
fn angle(p: &Params, g: [f64; 2]) -> f64 {
    let (j_ed, j_out) = (p.j_ed(), p.j_out(g));
    let length = g.map(|g| ComplexField::sqrt(1.0 / j_ed + g * g / j_out));
    let cross = (g[1] - g[0]) / ComplexField::sqrt(j_ed * j_out);
    (cross / (length[0] * length[1])).abs()
}

#[cfg(test)]
mod tests {
    use super::{Phase, excitation};
    use crate::Params;
    use crate::observer::Sample;
    use crate::params::Actuation;

    fn sample(positions: [f64; 2], omega_e: f64) -> Sample {
        Sample {
            omega_e,
            omega_c: [100.0, 64.0],
            gear: [1, 2],
            actuation: positions.map(|position| Actuation {
                position,
                pressure: 0.0,
            }),
            ..Sample::default()
        }
    }

    #[test]
    fn phases_follow_the_actuators_and_the_slip() {
        let p = Params::TABLE_1;
        let cases = [
            ([0.0, 0.0], [false, false], Phase::Open),
            ([5e-3, 0.0], [false, false], Phase::Slipping),
            ([5e-3, 0.0], [true, false], Phase::Engaged),
            ([0.0, 5e-3], [false, true], Phase::Engaged),
            ([0.0, 5e-3], [true, false], Phase::Slipping),
            ([5e-3, 5e-3], [true, false], Phase::Handover),
        ];
        for (positions, engaged, phase) in cases {
            let sample = sample(positions, 150.0);
            assert_eq!(Phase::of(&p, &sample, engaged), phase, "{positions:?}");
        }
    }

    #[test]
    fn two_clutches_show_less_than_one_and_an_open_one_shows_nothing() {
        let p = Params::TABLE_1;
        let both = excitation(&p, &sample([5e-3, 5e-3], 150.0));
        assert_eq!(excitation(&p, &sample([5e-3, 0.0], 150.0)), 1.0);
        assert!(both > 0.0 && both < 1.0, "{both}");
        assert_eq!(excitation(&p, &sample([0.0, 0.0], 150.0)), 0.0);
        assert_eq!(excitation(&p, &sample([5e-3, 0.0], 100.0)), 0.0);
    }
}
