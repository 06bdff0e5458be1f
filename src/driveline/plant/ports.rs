//! What enters and what leaves the plant.

use crate::plant::modes::Mode;

/// Inputs of the plant at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Input {
    /// T_e: engine torque [N·m].
    pub t_e: f64,
    /// F_n of both clutches [N], shape (2), ≥ 0.
    pub force: [f64; 2],
    /// Gears preselected on the odd and on the even shaft, shape (2); 0 is neutral.
    pub gear: [i32; 2],
    /// Brake torque at the wheels [N·m], ≥ 0: acts against the motion, holds up to itself at standstill.
    pub t_brake: f64,
    /// φ: road grade [rad].
    pub phi: f64,
}

/// Time derivatives of the inputs; all zero where inputs are held over a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InputRate {
    /// Rate of the engine torque [N·m/s].
    pub t_e: f64,
    /// Rates of the normal forces [N/s], shape (2).
    pub force: [f64; 2],
    /// Rate of the brake torque [N·m/s].
    pub t_brake: f64,
    /// Rate of the grade [rad/s].
    pub phi: f64,
}

impl InputRate {
    /// Whether all inputs are held.
    #[inline(always)]
    pub(crate) const fn is_held(&self) -> bool {
        let [one, two] = self.force;
        let bits = self.t_e.to_bits() | one.to_bits() | two.to_bits() | self.t_brake.to_bits();
        (bits | self.phi.to_bits()) << 1 == 0 // but for signs of zeros
    }
}

impl Input {
    /// The inputs `t` [s] later; forces and brake do not fall below zero.
    pub fn after(&self, rate: &InputRate, t: f64) -> Self {
        Self {
            t_e: self.t_e + rate.t_e * t,
            force: [0, 1].map(|i| (self.force[i] + rate.force[i] * t).max(0.0)),
            gear: self.gear,
            t_brake: (self.t_brake + rate.t_brake * t).max(0.0),
            phi: self.phi + rate.phi * t,
        }
    }
}

/// Work done since the start of a run [J].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Work {
    /// By the engine.
    pub engine: f64,
    /// Done against the road load, dry rolling resistance included.
    pub load: f64,
    /// Lost in the clutches, shape (2).
    pub friction: [f64; 2],
    /// Lost in dampers and shafts.
    pub viscous: f64,
    /// Lost in synchronisers, elastic energy let go by gears that go out included.
    pub synchroniser: f64,
    /// Lost in the brake.
    pub brake: f64,
}

/// State of a clutch as users see it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ClutchState {
    /// No normal force.
    #[default]
    Disengaged = 1,
    /// Normal force and slip.
    Slipping = 2,
    /// Normal force and no slip.
    Engaged = 3,
}

impl From<Mode> for ClutchState {
    fn from(mode: Mode) -> Self {
        match mode {
            Mode::Open => Self::Disengaged,
            Mode::Forward | Mode::Backward => Self::Slipping,
            Mode::Stuck => Self::Engaged,
        }
    }
}

/// Outputs of the plant at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Output {
    /// ω_e [rad/s].
    pub omega_e: f64,
    /// ω_d [rad/s].
    pub omega_d: f64,
    /// ω_c1, ω_c2 [rad/s], shape (2).
    pub omega_c: [f64; 2],
    /// ω_o [rad/s].
    pub omega_o: f64,
    /// ω_w [rad/s].
    pub omega_w: f64,
    /// V = r_w ω_w [m/s].
    pub vehicle_speed: f64,
    /// dV/dt [m/s²].
    pub vehicle_acceleration: f64,
    /// T_d of (3) [N·m].
    pub t_d: f64,
    /// T_c1, T_c2 [N·m], shape (2); positive when the engine drives the gearbox.
    pub t_c: [f64; 2],
    /// T_t1, T_t2 [N·m], shape (2).
    pub t_t: [f64; 2],
    /// T_o of (10) [N·m].
    pub t_o: f64,
    /// T_v of (11) with the brake [N·m]; positive when it brakes forward motion.
    pub t_v: f64,
    /// ω_d − ω_ci [rad/s], shape (2); 0 in an engaged clutch.
    pub slip: [f64; 2],
    /// States of the clutches, shape (2).
    pub state: [ClutchState; 2],
    /// The wheels stand and brake or rolling resistance holds them.
    pub held: bool,
    /// Friction power [W], shape (2), ≥ 0.
    pub friction_power: [f64; 2],
    /// Friction energy since the start [J], shape (2).
    pub friction_energy: [f64; 2],
    /// Temperatures of the clutches [K], shape (2).
    pub temperature: [f64; 2],
    /// Volume worn off each lining since the start [m³], shape (2): specific wear times friction energy.
    pub wear: [f64; 2],
    /// Friction power of the brake [W], ≥ 0.
    pub brake_power: f64,
    /// Friction energy of the brake since the start [J].
    pub brake_energy: f64,
    /// A gear is preselected that is not in yet: its synchroniser rubs, shape (2).
    pub synchronising: [bool; 2],
    /// Energy lost in synchronisers since the start [J].
    pub synchroniser_energy: f64,
    /// Energy balance since the start: work in − stored − lost [J]; 0 but for round-off.
    pub energy_residual: f64,
}
