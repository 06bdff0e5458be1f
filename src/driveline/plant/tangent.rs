//! Exact derivatives of the plant's outputs, by its inputs and by time.
//!
//! While the modes of clutches and brake stay, state rates and outputs are linear in the state and in the
//! torques v, and v is smooth in the inputs:
//!
//! ```text
//! x' = A x + B v,  y = C x + D v      ⇒      δy = C δx + D δv,   δv = ∂v/∂u δu + ∂v/∂x δx
//! ```
//!
//! with A to D of the modes that act. δx = 0 gives a directional derivative by the inputs, δx = x' and
//! δu = u' the time derivative. Friction power is the one product, T_c · slip.
//!
//! ```
//! use dct_driveline::{Params, plant::{Input, InputRate, Plant}, matrices::{State, Systems}};
//!
//! let p = Params::TABLE_1;
//! let input = Input { force: [1500.0, 0.0], gear: [1, 2], ..Input::default() };
//! let (plant, systems) = (Plant::start(&p, &input, 90.0, 0.0), Systems::new(&p, input.gear));
//! let by_force = InputRate { force: [1.0, 0.0], ..InputRate::default() };
//! let y = plant.tangent(&p, &systems, &input, &State::zeros(), &by_force);
//! assert!((y.t_c[0] - p.clutch[0].mu_k * p.clutch[0].r_c_n).abs() < 1e-15);
//! ```

use crate::Params;
use crate::matrices::springs::drive_shaft_torque;
use crate::matrices::{C, D, E, O, State, Systems, Torques, W, slip};
use crate::plant::Plant;
use crate::plant::block::torques;
use crate::plant::modes::{Mode, stuck_set};
use crate::plant::ports::{Input, InputRate, Output};

impl Plant {
    /// Change of the outputs for a change `dx` of the state and `du` of the inputs, in the modes that act.
    ///
    /// Each field of the result is the change of the output of its name; energies do not change.
    pub fn tangent(
        &self,
        p: &Params,
        systems: &Systems,
        input: &Input,
        dx: &State,
        du: &InputRate,
    ) -> Output {
        self.tangent_with(p, systems, input, dx, du, [0.0; 2])
    }

    /// [`Self::tangent`] with a change `heat` of the temperatures [K], shape (2), as well.
    fn tangent_with(
        &self,
        p: &Params,
        systems: &Systems,
        input: &Input,
        dx: &State,
        du: &InputRate,
        heat: [f64; 2],
    ) -> Output {
        let now = self.outputs(p, systems, input);
        let mut dv = self.torque_change(p, input, dx, du);
        let [one, two] = self.friction_by_heat(p, input.force, heat);
        (dv[1], dv[2]) = (dv[1] + one, dv[2] + two);
        let system = &systems.by_stuck[stuck_set(self.modes)];
        let t_c = [0, 1].map(|i| system.rows.torque[i].of(dx, &dv));
        let slip = [0, 1].map(|i| match self.modes[i] {
            Mode::Stuck => 0.0,
            _ => dx[D] - dx[C + i],
        });
        let [t_d, mut t_t @ .., t_o] = systems.spring_torques(dx);
        for i in (0..2).filter(|i| systems.rigid_ratio[*i] != 0.0) {
            let omega_c_dot = system.rate(C + i, dx, &dv);
            t_t[i] = p.i_t(i, self.gear[i]) * (t_c[i] - systems.storage[C + i] * omega_c_dot);
        }
        Output {
            omega_e: dx[E],
            omega_d: dx[D],
            omega_c: [dx[C], dx[C + 1]],
            omega_o: dx[O],
            omega_w: dx[W],
            vehicle_speed: p.road.r_w * dx[W],
            vehicle_acceleration: p.road.r_w * system.rows.wheel_rate.of(dx, &dv),
            t_d,
            t_c,
            t_t,
            t_o,
            t_v: dv[3],
            slip,
            friction_power: [0, 1].map(|i| t_c[i] * now.slip[i] + now.t_c[i] * slip[i]),
            brake_power: self.brake_power_change(input, dx[W], du.t_brake),
            ..Output::default()
        }
    }

    /// Time derivatives of the outputs while the inputs change by `rate`.
    ///
    /// Each field of the result is the rate of the output of its name, per second.
    pub fn output_rates(
        &self,
        p: &Params,
        systems: &Systems,
        input: &Input,
        rate: &InputRate,
    ) -> Output {
        let now = self.outputs(p, systems, input);
        let heat = self.temperature_rate(p, now.friction_power);
        let factor = self.friction_factor(p);
        let v = torques(p, self.modes, factor, input.t_e, input.force, now.t_v);
        let v = self.with_synchronisers(p, v);
        let x_dot = systems.by_stuck[stuck_set(self.modes)].derivative(&self.x, &v);
        Output {
            friction_energy: now.friction_power,
            temperature: heat,
            wear: [0, 1].map(|i| p.clutch[i].specific_wear * now.friction_power[i]),
            brake_energy: now.brake_power,
            synchroniser_energy: self.synchroniser_power(p),
            ..self.tangent_with(p, systems, input, &x_dot, rate, heat)
        }
    }

    /// δv: change of T_e, T_c1, T_c2 and T_v [N·m]; linear in the inputs, so the same function that makes v
    /// makes it, and friction that varies with slip adds its slope.
    fn torque_change(&self, p: &Params, input: &Input, dx: &State, du: &InputRate) -> Torques {
        let t_v = if self.brake == Mode::Stuck {
            drive_shaft_torque(p, dx)
        } else {
            self.load_change(p, input, dx[W], du)
        };
        let factor = self.friction_factor(p);
        let mut dv = torques(p, self.modes, factor, du.t_e, du.force, t_v);
        let (at, by) = (slip(&self.x), slip(dx));
        for i in [0, 1] {
            dv[1 + i] += self.friction_at(p, i, input.force[i], at[i]).1 * by[i];
        }
        dv
    }

    /// Change of T_v of (11) with the brake [N·m].
    fn load_change(&self, p: &Params, input: &Input, d_omega_w: f64, du: &InputRate) -> f64 {
        let grade = self.grade.at(p, input.phi);
        let direction = self.brake_direction();
        let (_, slope) = input.load_torque(p, &grade, self.x[W], direction);
        let rolls = if p.road.v_eps > 0.0 {
            p.road.direction(self.x[W])
        } else {
            direction
        };
        let by_phi = grade.level - p.road.c_rr * grade.climb * rolls;
        slope * d_omega_w + by_phi * du.phi + direction * du.t_brake
    }
}

#[cfg(test)]
mod tests {
    use crate::Params;
    use crate::friction::FrictionCurve;
    use crate::integrate::Propagators;
    use crate::matrices::State;
    use crate::plant::modes::Mode;
    use crate::plant::{ClutchState, Input, InputRate, Output, Plant};
    use crate::thermal::Thermal;

    /// Of the largest value; the differences below are exact but for round-off where y is linear in u.
    const ROUND_OFF: f64 = 1e-6;

    fn numbers(y: &Output) -> [f64; 20] {
        let ([a, b], [c, d], [e, f]) = (y.t_c, y.t_t, y.friction_power);
        let ([g, h], [i, j]) = (y.omega_c, y.slip);
        let speeds = [y.omega_e, y.omega_d, y.omega_o, y.omega_w];
        let [k, l, m, n] = speeds;
        [
            a,
            b,
            c,
            d,
            e,
            f,
            g,
            h,
            i,
            j,
            k,
            l,
            m,
            n,
            y.vehicle_acceleration,
            y.t_d,
            y.t_o,
            y.t_v,
            y.temperature[0],
            y.temperature[1],
        ]
    }

    /// One input more by `delta`.
    fn moved(input: &Input, which: usize, delta: f64) -> (Input, InputRate) {
        let (mut moved, mut rate) = (*input, InputRate::default());
        let fields = [
            (&mut moved.t_e, &mut rate.t_e),
            (&mut moved.t_brake, &mut rate.t_brake),
            (&mut moved.phi, &mut rate.phi),
        ];
        for (i, (value, unit)) in fields.into_iter().enumerate() {
            if i == which {
                (*value, *unit) = (*value + delta, 1.0);
            }
        }
        if which >= 3 {
            moved.force[which - 3] += delta;
            rate.force[which - 3] = 1.0;
        }
        (moved, rate)
    }

    /// Every combination of clutch states that a driveline can be left in, rigid and compliant.
    #[test]
    fn derivatives_are_those_of_differences_in_every_state() {
        use ClutchState::{Disengaged, Engaged, Slipping};
        let cases = [
            ([0.0, 0.0], 90.0, [Disengaged, Disengaged]),
            ([800.0, 0.0], 90.0, [Slipping, Disengaged]),
            ([800.0, 0.0], 20.0, [Slipping, Disengaged]),
            ([0.0, 800.0], 90.0, [Disengaged, Slipping]),
            ([800.0, 600.0], 90.0, [Slipping, Slipping]),
            ([9e3, 0.0], 36.0, [Engaged, Disengaged]),
            ([0.0, 9e3], 23.04, [Disengaged, Engaged]),
            ([9e3, 300.0], 36.0, [Engaged, Slipping]),
            ([300.0, 9e3], 23.04, [Slipping, Engaged]),
        ];
        let curve = FrictionCurve {
            slip: [0.0, 10.0, 25.0, 60.0, 150.0],
            factor: [1.1, 1.0, 0.95, 1.0, 0.7],
        };
        let hot = Thermal {
            capacity: 2.0,
            conductance: 1.0,
            ambient: 300.0,
            start: 0.0,
            temperature: [250.0, 400.0, 500.0, 600.0],
            factor: [1.0, 0.5, 0.4, 0.3],
        };
        for (rigid, curve, thermal) in [
            (false, FrictionCurve::CONSTANT, Thermal::OFF),
            (true, FrictionCurve::CONSTANT, Thermal::OFF),
            (false, curve, hot),
        ] {
            for (force, omega_e, states) in cases {
                let mut p = Params {
                    rigid,
                    ..Params::TABLE_1
                };
                for clutch in &mut p.clutch {
                    (clutch.curve, clutch.thermal) = (curve, thermal);
                    clutch.specific_wear = 1.0;
                }
                let input = Input {
                    t_e: 20.0,
                    force,
                    gear: [1, 2],
                    t_brake: 30.0,
                    phi: 0.03,
                };
                let start = Plant::start(&p, &input, omega_e, 0.6);
                check(&p, &input, start, states);
                if force[1] == 0.0 {
                    let neutral = Input {
                        gear: [1, 0],
                        ..input
                    };
                    let start = Plant::start(&p, &neutral, omega_e, 0.6);
                    let rubbing = check(&p, &input, start, states);
                    assert_eq!(rubbing.synchroniser[1], Mode::Backward);
                }
            }
        }
    }

    fn check(p: &Params, input: &Input, mut plant: Plant, states: [ClutchState; 2]) -> Plant {
        let mut propagators = Propagators::new(p, input.gear, 1e-6);
        for _ in 0..200 {
            plant.step(p, &mut propagators, input, &InputRate::default());
        }
        let systems = propagators.systems;
        let y = plant.outputs(p, &systems, input);
        assert_eq!(y.state, states);
        for (which, delta) in [1.0, 1.0, 1e-5, 1.0, 1.0].into_iter().enumerate() {
            let difference = |delta: f64| {
                let (moved, rate) = moved(input, which, delta);
                (numbers(&plant.outputs(p, &systems, &moved)), rate)
            };
            let ((more, rate), (less, _)) = (difference(delta), difference(-delta));
            let slope = plant.tangent(p, &systems, input, &State::zeros(), &rate);
            let found: [f64; 20] = core::array::from_fn(|k| (more[k] - less[k]) / (2.0 * delta));
            close(&numbers(&slope), &found, ROUND_OFF, which);
        }
        let rates = numbers(&plant.output_rates(p, &systems, input, &InputRate::default()));
        let at = |plant: &Plant| numbers(&plant.outputs(p, &systems, input));
        let before = at(&plant);
        plant.step(p, &mut propagators, input, &InputRate::default());
        let middle = at(&plant);
        plant.step(p, &mut propagators, input, &InputRate::default());
        let last = at(&plant);
        let found: [f64; 20] = core::array::from_fn(|k| {
            (4.0 * middle[k] - last[k] - 3.0 * before[k]) / (2.0 * propagators.h)
        });
        // Second order in 42 673 1/s · 1 µs, the fastest eigenvalue times the step.
        close(&rates, &found, 2e-3, 99);
        plant
    }

    fn close(ours: &[f64; 20], theirs: &[f64; 20], share: f64, what: usize) {
        for (k, (one, other)) in ours.iter().zip(theirs).enumerate() {
            let scale = one.abs().max(other.abs()).max(1.0);
            assert!(
                (one - other).abs() <= share * scale,
                "{k} by {what}: {one} {other}"
            );
        }
    }
}
