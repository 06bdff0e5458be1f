//! Clutch modes (6), (7) and the guards that end them.
//!
//! At zero slip the sets {stuck, forward, backward} per clutch are enumerated and the consistent one is
//! taken: a stuck clutch needs |T_c| ≤ μ_s F_n r_c N, a slipping one a slip that grows in its
//! direction. Most clutches stuck wins; of two, the more loaded one slips.

use crate::Params;
use crate::matrices::{State, System, Systems, Torques, slip};

/// Slip below which two shafts turn together [rad/s]: round-off of a step of constrained motion.
pub(crate) const ZERO_SLIP: f64 = 1e-10;
/// Round-off of a capacity [1].
pub(crate) const CAPACITY_MARGIN: f64 = 1e-12;
/// Round-off of a guard that starts at zero: slip [rad/s] and torque [N·m].
pub(crate) const GUARD_TOLERANCE: f64 = 1e-10;

/// What a clutch does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// No normal force: T_c = 0.
    Open,
    /// Slipping, engine side faster: T_c = μ_k F_n r_c N.
    Forward,
    /// Slipping, engine side slower: T_c = −μ_k F_n r_c N.
    Backward,
    /// No slip: T_c is the constraint torque.
    Stuck,
}

impl Mode {
    /// sgn(slip) of a slipping clutch, 0 otherwise [1].
    pub const fn direction(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Backward => -1.0,
            Self::Open | Self::Stuck => 0.0,
        }
    }

    /// Whether it is one of the two that slip.
    pub(crate) const fn slips(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }

    pub(crate) const fn slipping(direction: f64) -> Self {
        if direction >= 0.0 {
            Self::Forward
        } else {
            Self::Backward
        }
    }
}

/// The engaged clutches of a pair as a set (bit i: clutch i).
pub(crate) fn stuck_set(modes: [Mode; 2]) -> usize {
    usize::from(modes[0] == Mode::Stuck) | usize::from(modes[1] == Mode::Stuck) << 1
}

/// What happened to clutches and brake at an instant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Event {
    /// The slip came to zero, shape (2).
    pub(crate) reached: [bool; 2],
    /// The torque went beyond what sticks, shape (2).
    pub(crate) broken: [bool; 2],
    /// The normal force came to zero, shape (2).
    pub(crate) opened: [bool; 2],
    /// A shaft came to the speed of the gear that it is synchronised to, shape (2).
    pub(crate) synchronised: [bool; 2],
    /// A gear mesh that loses power is unloaded, or the output begins or ends to turn in one.
    pub(crate) mesh: bool,
    /// The output speed came to zero in meshes that lose power.
    pub(crate) output_reached: bool,
    /// The wheel speed came to zero under the brake.
    pub(crate) wheel_reached: bool,
    /// The torque on held wheels went beyond what the brake holds.
    pub(crate) wheel_broken: bool,
}

impl Event {
    /// Whether nothing happened.
    pub(crate) fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Whether nothing happened but to slips and torques of clutches.
    pub(crate) fn is_of_clutches(&self) -> bool {
        let (reached, broken) = (self.reached, self.broken);
        *self
            == Self {
                reached,
                broken,
                ..Self::default()
            }
    }

    /// Notes which guards of a clutch, or of the brake, were crossed: see `Block::guards`.
    #[inline(always)]
    pub(crate) fn note(&mut self, part: usize, found: [bool; 2], modes: [Mode; 2], brake: Mode) {
        let any = found != [false; 2];
        let Some(&mode) = modes.get(part) else {
            self.wheel_reached = found[0] && brake != Mode::Stuck;
            self.wheel_broken = any && brake == Mode::Stuck;
            return;
        };
        self.reached[part] = found[0] && mode.slips();
        self.broken[part] = any && mode == Mode::Stuck;
        self.opened[part] = found[1] && mode.slips();
        self.synchronised[part] = found[0] && mode == Mode::Open;
    }
}

/// A value that must stay ≥ 0, with its rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guard {
    /// Value, in the unit of what is watched.
    pub(crate) value: f64,
    /// Rate of the value [1/s].
    pub(crate) rate: f64,
}

/// What an interval between two guards shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Crossing {
    /// Stayed ≥ 0.
    None,
    /// May have gone below zero and returned: look closer.
    Possible,
    /// Below zero at the end.
    Found,
}

impl Guard {
    /// A guard that nothing happens to.
    pub(crate) const QUIET: Self = Self {
        value: 0.0,
        rate: 0.0,
    };

    /// Compares the guard at both ends of an interval of `t` [s].
    ///
    /// A dip lies above the two end tangents where it is convex, so it is safe when they meet above zero.
    pub(crate) fn crossing(self, end: Self, t: f64) -> Crossing {
        if end.value < -GUARD_TOLERANCE {
            return Crossing::Found;
        }
        if self.rate >= 0.0 || end.rate <= 0.0 {
            return Crossing::None;
        }
        let meet = (end.value - end.rate * t - self.value) / (self.rate - end.rate);
        let low = self.value + self.rate * meet.clamp(0.0, t);
        if low < -GUARD_TOLERANCE {
            Crossing::Possible
        } else {
            Crossing::None
        }
    }
}

/// Normal forces and torques at the instant at which modes are chosen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Load {
    /// T_e, what acts in place of open clutches, and T_v with the brake [N·m].
    pub(crate) torques: Torques,
    /// Friction torque of each slipping clutch, μ_k φ F_n r_c N [N·m], shape (2).
    pub(crate) kinetic: [f64; 2],
    /// Largest torque of each engaged clutch, μ_s F_n r_c N [N·m], shape (2).
    pub(crate) peak: [f64; 2],
    /// A normal force acts just after the instant, shape (2).
    pub(crate) pressed: [bool; 2],
}

impl Load {
    /// Load with normal forces `force` [N] on the clutches of `p`, whose μ_k becomes `factor` [1] times it.
    pub(crate) fn new(
        p: &Params,
        torques: Torques,
        force: [f64; 2],
        factor: [f64; 2],
        pressed: [bool; 2],
    ) -> Self {
        let capacity = |i: usize| force[i] * p.clutch[i].r_c_n;
        Self {
            torques,
            kinetic: [0, 1].map(|i| p.clutch[i].mu_k * capacity(i) * factor[i]),
            peak: [0, 1].map(|i| p.clutch[i].mu_s * capacity(i)),
            pressed,
        }
    }

    /// v with the friction torques of slipping clutches, shape (4).
    fn torques_in(&self, modes: [Mode; 2]) -> Torques {
        let mut v = self.torques;
        for i in (0..2).filter(|i| modes[*i] != Mode::Open) {
            v[1 + i] = modes[i].direction() * self.kinetic[i];
        }
        v
    }
}

/// Removes the slip of the clutches in `set` by impulses in them; momentum is kept.
pub fn project(systems: &Systems, set: usize, x: &mut State) {
    if set == 0 {
        return;
    }
    let removed = slip(x);
    *x -= systems.by_stuck[set].projection * nalgebra::Vector2::from(removed);
}

/// Modes that are consistent just after an instant.
///
/// `before`: modes up to the instant. `event`: what happened at it; a clutch that broke away may not stick.
pub(crate) fn resolve(
    systems: &Systems,
    x: &State,
    load: &Load,
    before: [Mode; 2],
    event: &Event,
) -> [Mode; 2] {
    let slip = slip(x);
    let choices = [0, 1].map(|i| {
        let at_zero = before[i] == Mode::Stuck || slip[i].abs() <= ZERO_SLIP;
        choices(load.pressed[i], at_zero, event.broken[i], slip[i])
    });
    if let ([one], [two]) = (choices[0], choices[1]) {
        return [*one, *two];
    }
    if let Some(modes) = all_stuck(systems, x, load, choices) {
        return modes;
    }
    let mut best: Option<([Mode; 2], usize, f64)> = None;
    for &one in choices[0] {
        for &two in choices[1] {
            let modes = [one, two];
            let Some((stuck, loading)) = consistent(systems, x, load, choices, modes) else {
                continue;
            };
            if best.is_none_or(|(_, most, least)| stuck > most || stuck == most && loading < least)
            {
                best = Some((modes, stuck, loading));
            }
        }
    }
    best.map_or_else(
        || by_constraint_torque(systems, x, load, choices),
        |(modes, ..)| modes,
    )
}

fn choices(pressed: bool, at_zero: bool, broken: bool, slip: f64) -> &'static [Mode] {
    match (pressed, at_zero, broken) {
        (false, ..) => &[Mode::Open],
        (true, true, false) => &[Mode::Stuck, Mode::Forward, Mode::Backward],
        (true, true, true) => &[Mode::Forward, Mode::Backward],
        (true, false, _) if slip > 0.0 => &[Mode::Forward],
        (true, false, _) => &[Mode::Backward],
    }
}

/// Every clutch stuck that stands at zero slip, where all of them may be: no other set engages more.
fn all_stuck(
    systems: &Systems,
    x: &State,
    load: &Load,
    choices: [&[Mode]; 2],
) -> Option<[Mode; 2]> {
    let modes = choices.map(|choices| choices.first().copied().unwrap_or(Mode::Open));
    let rows = &systems.by_stuck[stuck_set(modes)].rows;
    let v = load.torques_in(modes);
    let holds = |i: usize| {
        let torque = rows.torque[i].of(x, &v);
        modes[i] == Mode::Stuck && torque.abs() <= load.peak[i] * (1.0 + CAPACITY_MARGIN)
    };
    let all = (0..2).all(|i| choices[i].len() == 1 || holds(i));
    all.then_some(modes)
}

/// How many clutches `modes` engages and how loaded they would be all engaged; None: inconsistent.
fn consistent(
    systems: &Systems,
    x: &State,
    load: &Load,
    choices: [&[Mode]; 2],
    modes: [Mode; 2],
) -> Option<(usize, f64)> {
    let system = &systems.by_stuck[stuck_set(modes)];
    let v = load.torques_in(modes);
    let torque = system.clutch_torque(x, &v);
    let slip_dot = slip(&system.derivative(x, &v));
    let all = loading(systems, x, load, choices);
    let (mut stuck, mut loaded) = (0, 0.0);
    for i in (0..2).filter(|i| choices[*i].len() > 1) {
        if modes[i] == Mode::Stuck {
            if torque[i].abs() > load.peak[i] * (1.0 + CAPACITY_MARGIN) {
                return None;
            }
            stuck += 1;
            loaded += all[i];
        } else if modes[i].direction() * slip_dot[i] <= 0.0 {
            return None;
        }
    }
    Some((stuck, loaded))
}

/// |T_c| / (μ_s F_n r_c N) with every clutch stuck that may be, shape (2) [1].
fn loading(systems: &Systems, x: &State, load: &Load, choices: [&[Mode]; 2]) -> [f64; 2] {
    let torque = first_torque(systems, x, load, choices);
    [0, 1].map(|i| torque[i].abs() / load.peak[i].max(f64::MIN_POSITIVE))
}

fn first_torque(systems: &Systems, x: &State, load: &Load, choices: [&[Mode]; 2]) -> [f64; 2] {
    let first = choices.map(|choices| choices.first().copied().unwrap_or(Mode::Open));
    let system: &System = &systems.by_stuck[stuck_set(first)];
    system.clutch_torque(x, &load.torques_in(first))
}

/// Round-off left no consistent set: every clutch at zero slip follows the torque that would hold it.
fn by_constraint_torque(
    systems: &Systems,
    x: &State,
    load: &Load,
    choices: [&[Mode]; 2],
) -> [Mode; 2] {
    let held = choices.map(|set| {
        if set.len() > 1 {
            &[Mode::Stuck][..]
        } else {
            set
        }
    });
    let torque = first_torque(systems, x, load, held);
    [0, 1].map(|i| match choices[i] {
        [only] => *only,
        _ => Mode::slipping(torque[i]),
    })
}

#[cfg(test)]
mod tests {
    use super::{Event, Load, Mode, resolve};
    use crate::Params;
    use crate::matrices::{C, D, E, O, State, Systems, Torques, W};

    /// Clutch 1 turns with its shaft and the damper pulls with less than what sticks.
    fn at_zero_slip() -> (Systems, State, Load) {
        let p = Params::TABLE_1;
        let mut x = State::zeros();
        (x[E], x[D], x[C], x[O], x[W]) = (90.0, 90.0, 90.0, 5.0, 5.0);
        x[C + 1] = p.g([1, 2])[1] * x[O];
        x[6] = 0.1; // 60 N·m in the damper
        let torques = Torques::from([60.0, 0.0, 0.0, 0.0]);
        let load = Load::new(&p, torques, [2500.0, 0.0], [1.0; 2], [true, false]);
        (Systems::new(&p, [1, 2]), x, load)
    }

    #[test]
    fn a_clutch_that_just_broke_away_may_not_stick_at_that_instant() {
        let (systems, x, load) = at_zero_slip();
        let before = [Mode::Stuck, Mode::Open];
        let broken = Event {
            broken: [true, false],
            ..Event::default()
        };
        assert_eq!(
            resolve(&systems, &x, &load, before, &Event::default()),
            before
        );
        let after = resolve(&systems, &x, &load, before, &broken);
        assert!(after[0].direction() != 0.0, "{after:?}");
    }

    #[test]
    fn a_clutch_sticks_up_to_its_peak_and_slips_where_it_is_pulled() {
        let (systems, x, mut load) = at_zero_slip();
        let torque = systems.by_stuck[1].clutch_torque(&x, &load.torques)[0];
        for (peak, mode) in [(1.001, Mode::Stuck), (0.999, Mode::Forward)] {
            load.peak[0] = peak * torque;
            load.kinetic[0] = 0.8 * torque;
            let after = resolve(
                &systems,
                &x,
                &load,
                [Mode::Stuck, Mode::Open],
                &Event::default(),
            );
            assert_eq!(after, [mode, Mode::Open]);
        }
    }
}
