//! `DctPlant`: the driveline (1)-(11) as an FMU.
//!
//! Inputs act as forces and torques, the driveline steps, outputs are read. Speeds, slips, clutch
//! states and spring torques depend on states only; what a slipping or engaged clutch carries
//! depends on the positions at the communication point as well, and the table says so.

mod efficiency;
mod hidden;
mod inputs;
mod lining;
mod losses;
mod propagation;
mod road;
mod sets;
mod shared;
mod shelf;
mod start;
mod table;
mod thermal;
mod tie;

use crate::step::{SCENARIO, check_step};
use crate::vehicle::{Vehicle, check_maps};
use dct_driveline::Params;
use dct_driveline::jerk::JerkFilter;
use dct_driveline::matrices::{C, D, E, O, State, W};
use dct_driveline::plant::modes::Mode;
use dct_driveline::plant::{self as driveline, InputRate, Output};
use fmi2_cosim::{Experiment, Failure, Log, Model, Seconds, StateFields, Variable};
use inputs::{Inputs, Pressed};
use propagation::{OneStep, Propagation};
use shared::Shared;

/// What has a mode, in the order of `all_modes`.
const PARTS: [&str; 6] = [
    "clutch 1",
    "clutch 2",
    "brake",
    "synchroniser 1",
    "synchroniser 2",
    "output",
];

/// The plant: parameters, inputs, the driveline's state, outputs.
#[derive(Clone)]
pub struct Plant {
    p: Shared,
    engine_speed_start: f64,
    vehicle_speed_start: f64,
    /// τ of the jerk's filter [s].
    jerk_time: f64,
    u: Inputs,
    /// Time derivatives of the inputs.
    u_rate: Inputs,
    /// What the forces of the inputs were worked out for last, with parameters that are there since.
    pressed: Pressed,
    /// Gears asked for, as the importer set them.
    gear: [i32; 2],
    /// Gears that were refused last, so that each refusal is logged once.
    refused: [i32; 2],
    state: driveline::Plant,
    y: Output,
    jerk_filter: JerkFilter,
    /// dV/dt through the filter [m/s²], and jerk [m/s³].
    comfort: [f64; 2],
    /// Clutch states 1, 2, 3.
    clutch_state: [i32; 2],
    propagation: Propagation,
}

impl Default for Plant {
    fn default() -> Self {
        let state = driveline::Plant::AT_REST;
        let y = Output {
            temperature: state.temperature,
            ..Output::default()
        };
        Self {
            p: Shared::default(),
            engine_speed_start: 0.0,
            vehicle_speed_start: 0.0,
            jerk_time: 0.016,
            u: Inputs::default(),
            u_rate: Inputs::default(),
            pressed: Pressed::NOWHERE,
            gear: state.gear,
            refused: state.gear,
            state,
            y,
            jerk_filter: JerkFilter::at(0.0),
            comfort: [0.0; 2],
            clutch_state: y.state.map(|state| state as i32),
            propagation: Propagation::default(),
        }
    }
}

impl Vehicle for Plant {
    fn params(&mut self) -> &mut Params {
        &mut self.p
    }
}

impl Plant {
    /// Logs which preselected gears are ignored, each once, and which ones are taken.
    #[cold]
    fn tell_gears(
        &mut self,
        input: &driveline::Input,
        rate: &InputRate,
        time: f64,
        log: &mut Log<'_>,
    ) {
        let granted = self.state.gear_granted(input, rate);
        for i in (0..2).filter(|i| granted[*i] != self.gear[*i]) {
            let dropped = granted[i] != self.state.gear[i];
            if dropped || self.refused[i] != self.gear[i] {
                log.warning(format_args!(
                    "t = {} s: shaft{}.gear = {} is ignored while clutch {} transmits; gear {} stays",
                    Seconds(time), i + 1, self.gear[i], i + 1, granted[i]
                ));
            }
        }
        self.refused = self.gear;
        if granted != self.state.gear {
            self.tell_neutral(granted, time, log);
            log.event(format_args!(
                "t = {} s: gears {:?} become {granted:?}",
                Seconds(time),
                self.state.gear
            ));
        }
    }

    /// Logs gears that are not there.
    fn tell_neutral(&self, gear: [i32; 2], time: f64, log: &mut Log<'_>) {
        let g = self.p.g(gear);
        for i in (0..2).filter(|i| gear[*i] != 0 && g[*i] == 0.0) {
            log.warning(format_args!(
                "t = {2} s: shaft{0}.gear = {1} has no ratio on shaft {0}: neutral; give it one, or choose a gear that is fitted",
                i + 1, gear[i], Seconds(time)
            ));
        }
    }

    /// V [m/s].
    fn speed(&self) -> f64 {
        self.p.road.r_w * self.state.x[W]
    }

    /// Puts the speeds of the outputs where rows point that read them from the state.
    fn show_speeds(&mut self) {
        let (x, y) = (&mut self.state.x, &self.y);
        (x[E], x[D], x[O], x[W]) = (y.omega_e, y.omega_d, y.omega_o, y.omega_w);
        [x[C], x[C + 1]] = y.omega_c;
    }

    /// Outputs with the inputs at the communication point.
    fn read_outputs(&mut self, input: &driveline::Input) {
        let coupling = self.state.coupling();
        let systems = self.propagation.systems(&self.p, coupling);
        self.state
            .write_outputs(&self.p, systems, input, &mut self.y);
        self.clutch_state = self.y.state.map(|state| state as i32);
        self.comfort = [
            self.jerk_filter.acceleration(self.jerk_time),
            self.jerk_filter.jerk(self.y.vehicle_speed, self.jerk_time),
        ];
    }

    /// Takes a step that is plain, else does nothing: see [`driveline::Plant::step_plainly`].
    #[inline(always)]
    fn step_plainly(&mut self, input: &driveline::Input, step: f64) -> Option<f64> {
        if self.gear != self.refused || !self.u_rate.is_zero() {
            return None;
        }
        let mut ladders = OneStep {
            propagation: &mut self.propagation,
            step,
        };
        self.state.step_plainly(&self.p, &mut ladders, input)
    }

    /// Takes a step that may hold events, and logs them; returns [`driveline::Plant::size`].
    #[cold]
    #[inline(never)]
    fn step_closely(
        &mut self,
        input: &driveline::Input,
        time: f64,
        step: f64,
        log: &mut Log<'_>,
    ) -> f64 {
        let rate = self.rate(input, step);
        let settled = self.gear == self.state.gear && self.gear == self.refused;
        if !settled || self.state.synchroniser != [Mode::Open; 2] {
            self.tell_gears(input, &rate, time, log);
        }
        let mut ladders = OneStep {
            propagation: &mut self.propagation,
            step,
        };
        let mut tell = |after, from: [Mode; 6], to: [Mode; 6]| {
            for i in (0..PARTS.len()).filter(|i| from[*i] != to[*i]) {
                let (at, part) = (Seconds(time + after), PARTS[i]);
                log.event(format_args!(
                    "t = {at} s: {part} {:?} -> {:?}",
                    from[i], to[i]
                ));
            }
        };
        self.state
            .step_in_blocks(&self.p, &mut ladders, input, &rate, &mut tell);
        self.state.size()
    }

    /// Refuses to go on with what is no number: every output is a sum of products of two of these terms.
    ///
    /// `size`: [`driveline::Plant::size`], or what a step changed of it.
    fn check_finite(&self, size: f64, time: f64) -> Result<(), Failure> {
        let [_, second] = self.jerk_filter.state; // behind the first, which is behind the speed
        if (size + second).abs() < f64::INFINITY {
            return Ok(());
        }
        let variables = [
            (crate::ports::ENGINE_SPEED, self.state.x[E]),
            (crate::ports::OUTPUT_SPEED, self.state.x[O]),
            (crate::ports::WHEEL_SPEED, self.state.x[W]),
            (crate::ports::DRIVE_SHAFT_TORQUE, self.y.t_o),
        ];
        let found = variables.iter().find(|(_, value)| !value.is_finite());
        let variable = found.map_or("energy.residual", |(variable, _)| variable);
        Err(Failure::Diverged { variable, time })
    }
}

/// Refuses parameters that do not fit together.
fn check_parameters(p: &Params) -> Result<(), Failure> {
    check_maps(p)?;
    lining::check_curves(p)?;
    thermal::check_thermal(p)?;
    road::check_road(&p.road)?;
    tie::check_ties(p)
}

impl Model for Plant {
    const NAME: &'static str = "DctPlant";
    const DESCRIPTION: &'static str =
        "Driveline with dual-clutch transmission: engine, damper, two clutches, shafts, vehicle";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [Variable<Self>] = table::VARIABLES;
    const STEPS_STAY_FINITE: bool = true;
    const TANGENT: bool = true;
    const EXPERIMENT: Experiment = SCENARIO;

    fn initialize(&mut self, time: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        let (gears, step) = (self.gear.into(), Self::EXPERIMENT.step);
        self.propagation
            .begin(&mut self.p, check_parameters, gears, step)?;
        self.tell_neutral(self.gear, time, log);
        self.refused = self.gear;
        self.pressed = Pressed::NOWHERE;
        let input = self.input();
        let (omega_e, v) = (self.engine_speed_start, self.vehicle_speed_start);
        let free = self.propagation.of(&self.p, gears, step);
        self.state = driveline::Plant::start_with(&self.p, &free.systems, &input, omega_e, v);
        let coupling = self.state.coupling();
        self.propagation.turn_to(&self.p, coupling, step);
        self.jerk_filter = JerkFilter::at(v);
        self.read_outputs(&input);
        self.check_finite(self.state.size(), time)
    }

    fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        check_step(step, table::LONGEST_STEP)?;
        let (input, speed) = (self.input(), self.speed());
        let size = match self.step_plainly(&input, step) {
            Some(size) => size,
            None => self.step_closely(&input, time, step, log),
        };
        self.jerk_filter
            .advance(speed, self.speed(), step, self.jerk_time);
        self.y.t_o = self.state.drive_shaft_torque(&self.p);
        self.check_finite(size, time + step)
    }

    fn update_outputs(&mut self) {
        let input = self.input();
        self.read_outputs(&input);
    }

    fn tangent(&mut self, direction: &mut Self) {
        let (input, du) = (self.input(), self.input_change(&direction.u));
        let coupling = self.state.coupling();
        let systems = self.propagation.systems(&self.p, coupling);
        direction.y = self
            .state
            .tangent(&self.p, systems, &input, &State::zeros(), &du);
        direction.show_speeds();
    }

    fn slopes(&mut self, copy: &mut Self) {
        let (input, rate) = (self.input(), self.input_change(&self.u_rate));
        let coupling = self.state.coupling();
        let systems = self.propagation.systems(&self.p, coupling);
        copy.y = self.state.output_rates(&self.p, systems, &input, &rate);
        let (v, acceleration) = (self.speed(), self.y.vehicle_acceleration);
        let jerk_rate = self.jerk_filter.jerk_rate(v, acceleration, self.jerk_time);
        copy.comfort = [self.comfort[1], jerk_rate];
    }

    fn consistent(&self) -> Result<(), Failure> {
        check_parameters(&self.p)
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        // All fields by name: one that is added does not compile before somebody has decided what it is.
        let Self {
            refused,
            state,
            jerk_filter: JerkFilter {
                state: filtered, ..
            }, // its other field is kept, not state
            // Variables of the table, and what is found again from them.
            p: _,
            engine_speed_start: _,
            vehicle_speed_start: _,
            jerk_time: _,
            u: _,
            u_rate: _,
            pressed: _,
            gear: _,
            y: _,
            comfort: _,
            clutch_state: _,
            propagation: _,
        } = self;
        hidden::visit(state, refused, fields);
        fields.reals(filtered);
    }

    fn restored(&mut self) {
        self.pressed = Pressed::NOWHERE;
        let (coupling, step) = (self.state.coupling(), Self::EXPERIMENT.step);
        // It fails where a run has not begun yet: its parameters do not fit together, but may still be changed.
        let _ = self
            .propagation
            .begin(&mut self.p, check_parameters, coupling, step);
    }
}

#[cfg(test)]
mod tests {
    use super::{Output, Params, Plant, driveline};
    use dct_driveline::matrices::Systems;

    #[test]
    fn a_fresh_plant_is_one_that_started_at_rest() {
        let (mut fresh, gear) = (Plant::default(), [1, 2]);
        let input = driveline::Input {
            gear,
            ..driveline::Input::default()
        };
        let started = driveline::Plant::start(&Params::TABLE_1, &input, 0.0, 0.0);
        let y: Output = started.outputs(&fresh.p, &Systems::new(&fresh.p, gear), &input);
        assert_eq!((fresh.state, fresh.y, fresh.input()), (started, y, input));
    }
}
