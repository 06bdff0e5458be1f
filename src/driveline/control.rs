//! Clutch control: the position that makes a clutch carry a requested torque.
//!
//! ```text
//! request ──> capacity C (its sense against the slip) ──> (1 + z) C − k_d s Ṫ_o ──> F_map⁻¹(·/(μ r_c N)) ──> limits ──> θ_m
//!                 └──> e = C − |T̂_c| ──> z' = k_c e/C, not while a limit holds ──┘           μ̂ ──┘
//! ```
//!
//! (21) turned round: T = μ F_map(θ) r_c N, so θ = F_map⁻¹(T / (μ r_c N)). With feedback μ is the
//! friction that the observer learnt while the clutch slipped, without it the nominal one, which is the
//! map-based control that the paper starts from. Two more loops close over the estimates, while a clutch
//! slips: its own torque T̂_c trims what friction learnt alone does not explain (a lining that fades while
//! both clutches carry), and the rate of the drive-shaft torque T̂_o damps a driveline that swings.
//!
//! ```
//! use dct_driveline::{Params, control::position};
//!
//! let clutch = &Params::TABLE_1.clutch[0];
//! let theta = position(clutch, 40.0, 0.26);
//! assert!((0.26 * clutch.map.force(theta) * clutch.r_c_n - 40.0).abs() < 1e-9);
//! ```

use crate::kept::Kept;
use crate::observer::{lock, within};
use crate::params::ClutchParams;
use nalgebra::ComplexField;

/// Smallest friction coefficient a position is computed with [1].
const MU_MIN: f64 = 0.02;
/// Capacity below which an error of the torque says little of the friction [N·m].
const LEVER: f64 = 10.0;
/// Bounds of the trim z [1]: what is beyond is no clutch that wears or warms, but a fault.
const TRIM: [f64; 2] = [-0.5, 1.0];
/// τ: time constant of the rate of the drive-shaft torque [s].
const TAU: f64 = 0.02;

/// θ_m [m] at which a slipping clutch carries `torque` [N·m], by friction `mu` [1].
///
/// Between open (0) and the end of the map. No torque, or none that is a number: fully open.
pub fn position(clutch: &ClutchParams, torque: f64, mu: f64) -> f64 {
    if torque.is_nan() || torque <= 0.0 {
        return 0.0;
    }
    clutch
        .map
        .position(torque / (mu.max(MU_MIN) * clutch.r_c_n))
}

/// Follows `target` from `last` [m] no faster than `rate` [m/s] over `h` [s].
pub fn limit_rate(last: f64, target: f64, rate: f64, h: f64) -> f64 {
    within(target, last - rate * h, last + rate * h)
}

/// Sign of a slip [rad/s]: 0 where the clutch may stick.
pub fn sense(slip: f64) -> f64 {
    if slip.abs() > lock::SLIP {
        slip.signum()
    } else {
        0.0
    }
}

/// Capacity C ≥ 0 that a torque request [N·m] asks for, at the sense of the slip; `None`: wait at the
/// touch point.
///
/// A clutch carries torque against its slip, whatever is asked. So a request ≥ 0 is a capacity. A request
/// below 0 asks the clutch to brake with the engine: it is one too, except while the engine is faster,
/// where closing would drive instead.
pub fn capacity(request: f64, sense: f64) -> Option<f64> {
    if request < 0.0 && sense > 0.0 {
        None
    } else {
        Some(request.abs())
    }
}

/// What the actuator can do, and how strongly the estimates correct.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Fastest motion of the actuator [m/s].
    pub rate: f64,
    /// Smallest and largest position of the actuator [m].
    pub stroke: [f64; 2],
    /// k_c: gain of the clutch-torque feedback [1/s]; 0: none.
    pub torque_gain: f64,
    /// k_d: gain of the drive-shaft-torque feedback [s]; 0: none.
    pub damping: f64,
}

impl Tuning {
    /// k_c [1/s]: far below the bandwidth of the estimate, which follows within some 50 ms.
    pub const TORQUE_GAIN: f64 = 10.0;
}

/// What is asked of a clutch and known of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Demand {
    /// Requested torque [N·m].
    pub request: f64,
    /// ω_e − ω_c [rad/s].
    pub slip: f64,
    /// Friction coefficient to count on [1].
    pub mu: f64,
    /// T̂_c [N·m], where the estimates may close loops.
    pub torque: Option<f64>,
    /// Rate of T̂_o [N·m/s].
    pub t_o_rate: f64,
}

/// State of one clutch's control.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Servo {
    /// θ_m [m].
    pub position: f64,
    /// z: share by which the torque feedback asks for more than friction and map tell [1].
    pub trim: f64,
    /// Friction that the trim was found with [1]; 0: none yet.
    pub mu: f64,
}

impl Servo {
    /// At the position that `demand` asks for, without a limit of rate.
    pub fn start(clutch: &ClutchParams, tuning: &Tuning, demand: &Demand) -> Self {
        let [low, high] = tuning.stroke;
        Self {
            position: within(target(clutch, tuning, demand, 0.0), low, high),
            trim: 0.0,
            mu: demand.mu,
        }
    }

    /// Friction that is learnt explains what was trimmed: the trim gives back as much, so that the two do
    /// not add up.
    fn hand_over(&mut self, mu: f64) {
        if mu == self.mu {
            return;
        }
        let kept = (1.0 + self.trim) * mu / self.mu - 1.0;
        if kept.is_finite() {
            self.trim = kept.clamp(self.trim.min(0.0), self.trim.max(0.0));
        }
        self.mu = mu;
    }

    /// Moves on by `h` [s].
    ///
    /// Anti-windup: the trim stays while a limit keeps the actuator from what the trim already asks for.
    pub fn step(&mut self, clutch: &ClutchParams, tuning: &Tuning, demand: &Demand, h: f64) {
        self.hand_over(demand.mu);
        let wanted = target(clutch, tuning, demand, self.trim);
        let [low, high] = tuning.stroke;
        let reached = limit_rate(self.position, wanted, tuning.rate, h);
        let reached = within(reached, low, high);
        let error = self.error(demand);
        let winds_up = (wanted - reached) * error > 0.0;
        self.position = reached;
        if error == 0.0 || winds_up {
            return;
        }
        let share = error / demand.request.abs().max(LEVER);
        self.trim = (self.trim + h * tuning.torque_gain * share).clamp(TRIM[0], TRIM[1]);
    }

    /// C − |T̂_c| [N·m]; 0 where it tells nothing: no estimate, no slip, no capacity asked for.
    fn error(&self, demand: &Demand) -> f64 {
        let sense = sense(demand.slip);
        match (demand.torque, capacity(demand.request, sense)) {
            (Some(torque), Some(capacity)) if sense != 0.0 && capacity > LEVER => {
                capacity - torque * sense
            }
            _ => 0.0,
        }
    }
}

/// Position [m] for a demand with a trim, before limits.
fn target(clutch: &ClutchParams, tuning: &Tuning, demand: &Demand, trim: f64) -> f64 {
    let sense = sense(demand.slip);
    let Some(capacity) = capacity(demand.request, sense) else {
        return clutch.map.touch_point();
    };
    let damping = match demand.torque {
        Some(_) if capacity > 0.0 => tuning.damping * sense * demand.t_o_rate,
        _ => 0.0,
    };
    position(clutch, capacity * (1.0 + trim) - damping, demand.mu)
}

/// Rate of a signal, through a first-order filter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rate {
    filtered: f64,
    /// e^{−h/τ} of the last step h [s].
    forget: Kept<f64, f64>,
}

impl Rate {
    /// At rest at `value`.
    pub const fn at(value: f64) -> Self {
        Self {
            filtered: value,
            forget: Kept::NOTHING,
        }
    }

    /// The filtered value, which is all that is state.
    pub const fn state(&mut self) -> &mut f64 {
        &mut self.filtered
    }

    /// The rate after `h` [s] at `value`, in its unit per second.
    pub fn step(&mut self, value: f64, h: f64) -> f64 {
        let forget = self.forget.of(h, |h| ComplexField::exp(-h / TAU));
        self.filtered = value + (self.filtered - value) * forget;
        (value - self.filtered) / TAU
    }
}

#[cfg(test)]
mod tests {
    use super::{Demand, Rate, Servo, Tuning, capacity, limit_rate, position, sense};
    use crate::Params;

    const TUNING: Tuning = Tuning {
        rate: 0.2,
        stroke: [0.0, 9e-3],
        torque_gain: Tuning::TORQUE_GAIN,
        damping: 0.0,
    };
    const H: f64 = 1e-3;

    fn slipping(request: f64, torque: f64) -> Demand {
        Demand {
            request,
            slip: 50.0,
            mu: 0.26,
            torque: Some(torque),
            t_o_rate: 0.0,
        }
    }

    #[test]
    fn no_torque_opens_the_clutch_and_too_much_closes_it() {
        let clutch = &Params::TABLE_1.clutch[0];
        assert_eq!(position(clutch, 0.0, 0.3), 0.0);
        assert_eq!(position(clutch, f64::NAN, 0.3), 0.0);
        assert_eq!(position(clutch, 1e6, 0.3), clutch.map.position[9]);
    }

    #[test]
    fn a_position_moves_no_faster_than_its_actuator() {
        assert_eq!(limit_rate(1e-3, 9e-3, 0.1, 1e-2), 2e-3);
        assert_eq!(limit_rate(9e-3, 1e-3, 0.1, 1e-2), 8e-3);
        assert_eq!(limit_rate(1e-3, 1.1e-3, 0.1, 1e-2), 1.1e-3);
    }

    #[test]
    fn a_braking_request_closes_only_where_it_brakes() {
        let cases = [
            (40.0, 1.0, Some(40.0)),
            (40.0, -1.0, Some(40.0)),
            (-40.0, -1.0, Some(40.0)),
            (-40.0, 0.0, Some(40.0)),
            (-40.0, 1.0, None),
            (0.0, 1.0, Some(0.0)),
        ];
        for (request, sense, expected) in cases {
            assert_eq!(capacity(request, sense), expected, "{request} at {sense}");
        }
        assert_eq!([-4.0, -2.0, 2.0, 4.0].map(sense), [-1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_braking_request_waits_at_the_touch_point() {
        let clutch = &Params::TABLE_1.clutch[0];
        let servo = Servo::start(clutch, &TUNING, &slipping(-40.0, 0.0));
        assert_eq!(servo.position, clutch.map.touch_point());
    }

    /// A lining of 0.2 where 0.26 is known: the trim finds 0.26/0.2 − 1.
    #[test]
    fn torque_feedback_finds_what_the_friction_does_not_tell() {
        let clutch = &Params::TABLE_1.clutch[0];
        let mut servo = Servo::default();
        for _ in 0..5000 {
            let carried = 0.2 * clutch.map.force(servo.position) * clutch.r_c_n;
            servo.step(clutch, &TUNING, &slipping(40.0, carried), H);
        }
        assert!((servo.trim - 0.3).abs() < 1e-6);
    }

    #[test]
    fn the_trim_does_not_wind_up_at_the_end_of_the_stroke() {
        let clutch = &Params::TABLE_1.clutch[0];
        let mut servo = Servo::start(clutch, &TUNING, &slipping(400.0, 0.0));
        for _ in 0..1000 {
            servo.step(clutch, &TUNING, &slipping(400.0, 100.0), H);
        }
        assert_eq!((servo.position, servo.trim), (9e-3, 0.0));
    }

    #[test]
    fn what_friction_takes_over_the_trim_gives_back() {
        let clutch = &Params::TABLE_1.clutch[0];
        let cases = [
            (0.3, 0.2, 0.0),
            (0.3, 0.24, 0.2),
            (0.3, 0.3, 0.3),
            (-0.2, 0.24, -0.2),
        ];
        for (trim, mu, expected) in cases {
            let mut servo = Servo {
                trim,
                mu: 0.26,
                ..Servo::default()
            };
            let stuck = Demand {
                slip: 0.0,
                mu,
                ..slipping(40.0, 40.0)
            };
            servo.step(clutch, &TUNING, &stuck, H);
            assert!(
                (servo.trim - expected).abs() < 1e-12,
                "{trim} at {mu}: {}",
                servo.trim
            );
        }
    }

    #[test]
    fn a_clutch_that_sticks_teaches_nothing() {
        let clutch = &Params::TABLE_1.clutch[0];
        let mut servo = Servo::default();
        let stuck = Demand {
            slip: 0.1,
            ..slipping(100.0, 20.0)
        };
        (0..100).for_each(|_| servo.step(clutch, &TUNING, &stuck, H));
        assert_eq!(servo.trim, 0.0);
    }

    #[test]
    fn damping_opens_while_the_drive_shaft_winds_up() {
        let clutch = &Params::TABLE_1.clutch[0];
        let tuning = Tuning {
            damping: 1e-3,
            ..TUNING
        };
        let at = |t_o_rate| {
            Servo::start(
                clutch,
                &tuning,
                &Demand {
                    t_o_rate,
                    ..slipping(40.0, 40.0)
                },
            )
        };
        assert!(at(1000.0).position < at(0.0).position);
        assert!(at(-1000.0).position > at(0.0).position);
    }

    #[test]
    fn the_rate_of_a_ramp_is_its_slope() {
        let mut rate = Rate::at(0.0);
        let seen = (1..=1000)
            .map(|k| rate.step(f64::from(k) * H * 7.0, H))
            .last()
            .unwrap();
        assert!((seen / 7.0 - 1.0).abs() < 0.03);
    }
}
