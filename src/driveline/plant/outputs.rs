//! What the plant shows at an instant.

use crate::Params;
use crate::matrices::springs::drive_shaft_torque;
use crate::matrices::{C, D, E, O, State, Systems, TWIST_D, Torques, W};
use crate::plant::Plant;
use crate::plant::block::torques;
use crate::plant::modes::{Mode, stuck_set};
use crate::plant::ports::{ClutchState, Input, Output};

impl Plant {
    /// Outputs at the present instant with the inputs that act at it.
    pub fn outputs(&self, p: &Params, systems: &Systems, input: &Input) -> Output {
        let mut y = Output::default();
        self.write_outputs(p, systems, input, &mut y);
        y
    }

    /// T_o of (10) [N·m].
    pub fn drive_shaft_torque(&self, p: &Params) -> f64 {
        drive_shaft_torque(p, &self.x)
    }

    /// [`Self::size`] of what an ordinary step changes.
    #[inline(always)]
    pub(crate) fn moved(&self) -> f64 {
        let (squares, [one, two]) = (squares(&self.x), self.work.friction);
        squares + (self.work.engine + self.work.load + self.work.viscous + (one + two))
    }

    /// A sum of squares of states and of everything booked: not finite as soon as any of them is not.
    pub fn size(&self) -> f64 {
        let [one, two] = self.work.friction;
        let lost = one + two + self.work.viscous + self.work.synchroniser + self.work.brake;
        let [warm, hot] = self.temperature;
        squares(&self.x) + (lost + self.work.engine + self.work.load) + (warm + hot)
    }

    /// [`Self::outputs`] into their place.
    pub fn write_outputs(&self, p: &Params, systems: &Systems, input: &Input, y: &mut Output) {
        let (v, t_v) = self.acting_torques(p, input);
        let (t_c, t_t) = self.passed_torques(p, systems, input, &v);
        let (x, slip, t_o) = (&self.x, self.slip(), drive_shaft_torque(p, &self.x));
        let held = self.brake == Mode::Stuck;
        let omega_w_dot = if held { 0.0 } else { (t_o - t_v) / p.j_v };
        *y = Output {
            omega_e: x[E],
            omega_d: x[D],
            omega_c: [x[C], x[C + 1]],
            omega_o: x[O],
            omega_w: x[W],
            vehicle_speed: p.road.r_w * x[W],
            vehicle_acceleration: p.road.r_w * omega_w_dot,
            t_d: p.k_d * x[TWIST_D] + p.c_d * (x[E] - x[D]),
            t_c,
            t_t,
            t_o,
            t_v,
            slip,
            state: self.modes.map(ClutchState::from),
            held,
            friction_power: [t_c[0] * slip[0], t_c[1] * slip[1]],
            friction_energy: self.work.friction,
            synchronising: systems.coupling.synchronising,
            temperature: self.temperature,
            wear: [0, 1].map(|i| p.clutch[i].specific_wear * self.work.friction[i]),
            brake_power: self.brake_power(input.t_brake),
            brake_energy: self.work.brake,
            synchroniser_energy: self.work.synchroniser,
            energy_residual: self.energy_residual(systems),
        };
    }

    /// v of (1)-(11) at this instant, shape (4), and T_v of (11) with the brake [N·m].
    #[inline(always)]
    fn acting_torques(&self, p: &Params, input: &Input) -> (Torques, f64) {
        let t_v = if self.brake == Mode::Stuck {
            drive_shaft_torque(p, &self.x)
        } else {
            self.load_torque(p, input)
        };
        let factor = if p.friction_varies() {
            self.friction_factor(p)
        } else {
            [1.0; 2]
        };
        let mut v = torques(p, self.modes, factor, input.t_e, input.force, t_v);
        if self.synchroniser != [Mode::Open; 2] {
            v = self.with_synchronisers(p, v);
        }
        (v, t_v)
    }

    /// T_c1, T_c2 and T_t1, T_t2 [N·m], shape (2) each.
    #[inline(always)]
    fn passed_torques(
        &self,
        p: &Params,
        systems: &Systems,
        input: &Input,
        v: &Torques,
    ) -> ([f64; 2], [f64; 2]) {
        let x = &self.x;
        let system = &systems.by_stuck[stuck_set(self.modes)];
        let mut t_c = [0, 1].map(|i| match self.modes[i] {
            Mode::Stuck => system.rows.torque[i].of(x, v),
            Mode::Open => 0.0,
            _ => v[1 + i],
        });
        let mut t_t = [1, 2].map(|j| systems.spring_torque_of(j, x));
        if systems.rigid_ratio != [0.0; 2] {
            let mesh = &system.rows.mesh;
            t_t = [0, 1].map(|i| mesh[i].of(x, v) / p.i_f[i]);
            if self.is_strained(p) {
                t_c = self.shared(p, input, t_c);
                t_t = [0, 1].map(|i| p.i_t(i, self.gear[i]) * t_c[i]);
            }
        }
        if self.synchroniser != [Mode::Open; 2] {
            for i in (0..2).filter(|i| self.synchroniser[*i] != Mode::Open) {
                t_t[i] = p.i_t(i, self.gear[i]) * v[1 + i];
            }
        }
        (t_c, t_t)
    }

    /// T_v of (11) with the brake [N·m] while the wheels turn.
    #[inline(always)]
    fn load_torque(&self, p: &Params, input: &Input) -> f64 {
        let turned;
        let grade = if self.grade.is_of(input.phi) {
            &self.grade
        } else {
            turned = self.grade.at(p, input.phi);
            &turned
        };
        if input.t_brake == 0.0 && p.road.v_eps > 0.0 {
            return p.road.smooth_load(self.x[W], grade).0;
        }
        let direction = self.brake_direction();
        input.load_torque(p, grade, self.x[W], direction).0
    }
}

/// Σ x², of two lanes.
#[inline(never)] // by itself it takes pairs; beside other sums it would not
fn squares(x: &State) -> f64 {
    let mut lanes = [-0.0; 2]; // what a first sum leaves as it is
    for x in x.data.0[0].as_chunks::<2>().0 {
        lanes[0] += x[0] * x[0];
        lanes[1] += x[1] * x[1];
    }
    lanes[0] + lanes[1]
}
