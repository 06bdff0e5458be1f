//! Friction that varies: a block of motion whose friction torques follow slip and temperature.
//!
//! Over a block the friction torque of a slipping clutch is a ramp, like the load. The ramps are those
//! that meet μ_k φ(|slip|) θ(T) F_n r_c N, T as the friction power at the start makes it, and (11) at both ends of the block, found together by Newton's method
//! on the exact motion of the rung: second order in the block, as slip and friction bend within it by
//! the square of its length. Blocks are a quarter of the communication step and 1 ms at most, and one that is long
//! beside the time in which friction answers to slip is refused: the ladder takes a shorter one.

use nalgebra::{Matrix3, Vector3};

use crate::Params;
use crate::friction::CURVE_POINTS;
use crate::integrate::Rung;
use crate::integrate::{LADDER, TICKS, ticks};
use crate::matrices::slip;
use crate::params::ClutchParams;
use crate::plant::Plant;
use crate::plant::block::Block;
use crate::plant::modes::Mode;
use crate::plant::ports::{Input, InputRate};

/// Newton steps on the ramps; between kinks of a curve each squares the error left.
const ITERATIONS: u32 = 8;
/// Change of slip or wheel speed [rad/s] below which the ramps are settled.
const SETTLED: f64 = 1e-10;
/// Largest share of its own cause by which friction answers to slip within a block [1]: half of λ h, with
/// λ the rate at which slip and friction follow each other.
const ANSWER: f64 = 0.25;
/// Longest block while friction varies [s]: where a curve bends a ramp across the bend is a few 10⁻³ of the
/// torque off over 1 ms, and the square of it over more.
const LONGEST: f64 = 1e-3;
/// First torque that may follow the slip, T_c1; T_c2 and T_v come next.
const FIRST: usize = 1;

/// Level of the longest block: while friction varies a quarter of the communication step `h` [s], or less.
pub(crate) fn longest(varies: bool, h: f64) -> usize {
    if !varies {
        return LADDER;
    }
    let span = |level: usize| h * f64::from(ticks(level)) / f64::from(TICKS);
    (0..LADDER)
        .rev()
        .find(|level| span(*level) <= LONGEST)
        .unwrap_or(0)
}

impl Params {
    /// Whether the friction of a slipping clutch is anything but μ_k.
    pub(crate) const fn friction_varies(&self) -> bool {
        let [one, two] = &self.clutch;
        let bits = one.variation() | two.variation();
        bits != 0 && (one.varies() || two.varies())
    }

    /// These parameters; where friction varies, with a static friction of the present temperature that is
    /// not below the friction at slip 0: a clutch that breaks away must not be held at once by more than
    /// what held it. An engaged clutch cools slowly, so its static friction is held over a step.
    ///
    /// `temperature`: of both clutches [K], shape (2).
    pub(crate) fn with_static_friction<'a>(
        &'a self,
        place: &'a mut Option<Self>,
        temperature: [f64; 2],
    ) -> &'a Self {
        if !self.friction_varies() {
            return self;
        }
        let new = place.insert(*self);
        for (clutch, temperature) in new.clutch.iter_mut().zip(temperature) {
            let least = clutch.mu_k * clutch.curve.at(0.0).0;
            clutch.mu_s = clutch.mu_s.max(least) * clutch.thermal.at(temperature).0;
        }
        new
    }
}

impl ClutchParams {
    const fn varies(&self) -> bool {
        self.curve.varies() || self.thermal.is_on()
    }

    /// Bits of what [`Self::varies`] asks, of which most clutches have none.
    const fn variation(&self) -> u64 {
        self.curve.slip[CURVE_POINTS - 1].to_bits() | self.thermal.capacity.to_bits()
    }
}

impl Plant {
    /// φ θ of both clutches at their slip and temperature [1], shape (2).
    pub(crate) fn friction_factor(&self, p: &Params) -> [f64; 2] {
        let slip = slip(&self.x);
        [0, 1].map(|i| {
            let (clutch, temperature) = (&p.clutch[i], self.temperature[i]);
            clutch.curve.at(slip[i].abs()).0 * clutch.thermal.at(temperature).0
        })
    }

    /// Friction torque [N·m] of clutch `i` at a slip, and its slope by it [N·m·s/rad]; that of the
    /// synchroniser, or 0, unless it slips.
    ///
    /// `force`: normal force [N]. `slip`: slip [rad/s].
    pub(crate) fn friction_at(&self, p: &Params, i: usize, force: f64, slip: f64) -> (f64, f64) {
        if self.modes[i] == Mode::Open {
            return (self.synchroniser_torque(p)[i], 0.0);
        }
        let (direction, clutch) = (self.modes[i].direction(), &p.clutch[i]);
        let (factor, slope) = clutch.curve.at(direction * slip);
        let warm = clutch.thermal.at(self.temperature[i]).0;
        let capacity = clutch.mu_k * force * clutch.r_c_n * warm;
        (
            direction * capacity * factor,
            direction * direction * capacity * slope,
        )
    }

    /// T' of both clutches [K/s], shape (2).
    ///
    /// `power`: friction power [W], shape (2).
    pub(crate) fn temperature_rate(&self, p: &Params, power: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| p.clutch[i].thermal.rate(self.temperature[i], power[i]))
    }

    /// Change of the friction torque of each slipping clutch [N·m] by one of its temperature [K].
    pub(crate) fn friction_by_heat(&self, p: &Params, force: [f64; 2], d: [f64; 2]) -> [f64; 2] {
        let slip = slip(&self.x);
        [0, 1].map(|i| {
            let (direction, clutch) = (self.modes[i].direction(), &p.clutch[i]);
            let factor = clutch.curve.at(slip[i].abs()).0;
            let capacity = clutch.mu_k * force[i] * clutch.r_c_n * factor;
            direction * capacity * clutch.thermal.at(self.temperature[i]).1 * d[i]
        })
    }

    /// Heats the clutches by the friction work since `before` [J], shape (2), in `t` [s], and cools them.
    pub(crate) fn warm(&mut self, p: &Params, before: [f64; 2], t: f64) {
        for (i, clutch) in p.clutch.iter().enumerate() {
            let work = self.work.friction[i] - before[i];
            self.temperature[i] = clutch.thermal.after(self.temperature[i], work, t);
        }
    }

    /// The plant as warm as the friction power at the start of a block makes it by its end.
    fn ahead(&self, p: &Params, input: &Input, t: f64) -> Self {
        let slip = slip(&self.x);
        let power = [0, 1].map(|i| {
            let slipping = self.modes[i].direction() != 0.0;
            let torque = self.friction_at(p, i, input.force[i], slip[i]).0;
            if slipping { torque * slip[i] } else { 0.0 }
        });
        let rate = self.temperature_rate(p, power);
        Self {
            temperature: [0, 1].map(|i| self.temperature[i] + rate[i] * t),
            ..*self
        }
    }
}

/// The ramps of T_c1, T_c2 and T_v over a block, and what they do to slip 1, slip 2 and ω_w at its end.
struct Ramps {
    /// Torques at the start [N·m], shape (3).
    torque: Vector3<f64>,
    /// Ramps to begin with [N·m/s], shape (3).
    first: Vector3<f64>,
    /// What has to be added to them [N·m/s], shape (3).
    added: Vector3<f64>,
    /// Slip 1, slip 2, ω_w at the end without what is added [rad/s], shape (3).
    speed: Vector3<f64>,
    /// Their change by what is added [s²/(kg·m²)], shape (3, 3).
    gain: Matrix3<f64>,
}

impl Ramps {
    fn new(rung: &Rung, block: &Block) -> Self {
        let start = &block.start;
        Self {
            torque: [0, 1, 2].map(|q| start.torque(FIRST + q)).into(),
            first: [0, 1, 2].map(|q| start.ramp(FIRST + q)).into(),
            added: Vector3::zeros(),
            speed: block.motion.worked_speeds(&start.x).into(),
            gain: Matrix3::from_columns(
                &[0, 1, 2].map(|q| rung.worked_speeds_by_ramp(FIRST + q).into()),
            ),
        }
    }

    /// Finds what meets `wanted` at the end of a block of `t` [s]; false: the block is too long.
    ///
    /// `wanted`: torques [N·m] at slips and wheel speed, and their slopes [N·m·s/rad], each shape (3).
    fn settle(&mut self, t: f64, wanted: impl Fn(&Vector3<f64>) -> [Vector3<f64>; 2]) -> bool {
        for _ in 0..ITERATIONS {
            let [torque, slope] = wanted(&(self.speed + self.gain * self.added));
            let answer = Matrix3::from_diagonal(&slope) * self.gain / t;
            let missing = (torque - self.torque) / t - self.first - self.added;
            let Some(inverse) = (Matrix3::identity() - answer).try_inverse() else {
                return false;
            };
            let change = inverse * missing;
            self.added += change;
            if (self.gain * change).amax() < SETTLED {
                return answer[(0, 0)].abs().max(answer[(1, 1)].abs()) < ANSWER;
            }
        }
        false
    }
}

impl Block {
    /// The block over a rung, and whether it may be so long.
    ///
    /// `varies`: friction may follow the slip.
    #[inline(always)]
    pub(crate) fn over(
        p: &Params,
        plant: &Plant,
        rung: &Rung,
        input: &Input,
        rate: &InputRate,
        varies: bool,
    ) -> (Self, bool) {
        if varies {
            Self::with_varying_friction(p, plant, rung, input, rate)
        } else {
            (Self::new(p, plant, rung, input, rate), true)
        }
    }

    /// The block over a rung with friction that follows the slip; false: it is too long for that.
    #[cold]
    #[inline(never)] // other steps need not have stack for its matrices
    fn with_varying_friction(
        p: &Params,
        plant: &Plant,
        rung: &Rung,
        input: &Input,
        rate: &InputRate,
    ) -> (Self, bool) {
        let mut block = Self::begin(p, plant, rung, input, rate, plant.friction_factor(p));
        let (end, grade, direction) = (block.input_end, block.grade_end, plant.brake.direction());
        let (mut ramps, ahead) = (Ramps::new(rung, &block), plant.ahead(p, input, rung.t));
        let settled = ramps.settle(rung.t, |speed| {
            let [one, two] = [0, 1].map(|i| ahead.friction_at(p, i, end.force[i], speed[i]));
            let load = end.load_torque(p, &grade, speed[2], direction);
            [[one.0, two.0, load.0].into(), [one.1, two.1, load.1].into()]
        });
        for (q, ramp) in ramps.added.iter().enumerate() {
            block.add_ramp(rung, FIRST + q, *ramp);
        }
        (block, settled)
    }
}
