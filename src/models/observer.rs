//! `DctObserver`: both clutch torques and the drive-shaft torque from production signals, as an FMU.
//!
//! All outputs are written by a step, so at a communication point they depend on states only: no
//! algebraic loop, whatever the importer couples.

mod table;

use crate::step::{SCENARIO, check_step};
use crate::vehicle::{Vehicle, check_maps};
use dct_driveline::Params;
use dct_driveline::observer::{
    Estimate, Fault, LoadMethod, Method, Observer as _, Phase, Sample, Selected, Settings,
};
use fmi2_cosim::{Experiment, Failure, Log, Model, Seconds, StateFields, Variable};

/// The observer: the vehicle it believes in, settings, inputs, state, estimate.
#[derive(Clone)]
pub struct Observer {
    p: Params,
    settings: Settings,
    /// `observer.method`.
    method: i32,
    /// `load.method`.
    load: i32,
    u: Sample,
    state: Selected,
    y: Estimate,
    /// `status.phase`.
    phase: i32,
}

impl Default for Observer {
    fn default() -> Self {
        Self {
            p: Params::TABLE_1,
            settings: Settings::CASE_1,
            method: Method::Paper as i32,
            load: table::MOMENTUM,
            u: Sample {
                gear: [1, 2],
                ..Sample::default()
            },
            state: Selected::default(),
            y: Estimate {
                friction: Settings::CASE_1.mu_n,
                ..Estimate::default()
            },
            phase: Phase::Open as i32,
        }
    }
}

impl Vehicle for Observer {
    fn params(&mut self) -> &mut Params {
        &mut self.p
    }
}

impl Observer {
    fn take_settings(&mut self) {
        self.settings.load = match self.load {
            table::GRADE => LoadMethod::Grade,
            table::ENGINE => LoadMethod::Engine,
            _ => LoadMethod::Momentum,
        };
    }
}

impl Observer {
    /// Logs what changed since an estimate that was `valid` with clutches `engaged`, shape (2).
    #[cold]
    #[inline(never)]
    fn tell(&self, valid: bool, engaged: [bool; 2], time: f64, log: &mut Log<'_>) {
        if let Some(fault) = self.y.fault.filter(|_| valid) {
            log.warning(format_args!(
                "t = {} s: status.valid = false: {fault}; {}",
                Seconds(time),
                remedy(fault)
            ));
        }
        for i in (0..2).filter(|i| engaged[*i] != self.y.engaged[*i]) {
            let now = if self.y.engaged[i] {
                "engaged"
            } else {
                "not engaged"
            };
            log.event(format_args!(
                "t = {} s: clutch {} is {now}",
                Seconds(time),
                i + 1
            ));
        }
    }
}

/// Logs encoders that were recognised, or no longer are, since `before`; ticks of ω_e, ω_c1, ω_c2, ω_w [1], shape (4).
#[inline(never)] // most speeds are not counted
fn tell_ticks(before: [f64; 4], now: [f64; 4], time: f64, log: &mut Log<'_>) {
    let time = Seconds(time);
    let changed = |sensor: &usize| before[*sensor] != now[*sensor];
    for sensor in (0..4).filter(changed) {
        let (name, ticks) = (
            ["engine", "clutch1", "clutch2", "wheel"][sensor],
            now[sensor],
        );
        if ticks > 0.0 {
            log.event(format_args!(
                "t = {time} s: {name}.speed is counted by an encoder of {ticks} ticks per revolution, and is followed \
                 as such; set {name}.encoderTicks where that is wrong"
            ));
        } else {
            log.event(format_args!(
                "t = {time} s: {name}.speed is not counted by an encoder of {} ticks after all",
                before[sensor]
            ));
        }
    }
}

/// What the user can do about a fault.
const fn remedy(fault: Fault) -> &'static str {
    match fault {
        Fault::NotFinite => "give every input a number",
        Fault::NoSpeed | Fault::Frozen => "check the speed sensors and their connections",
        Fault::Saturated => "check the force-position maps and nominal frictions",
        Fault::Diverged => "check the ratios, inertias and gains",
        Fault::Inconsistent => "check the sensors, their deviation among the gains, and the ratios",
    }
}

impl Model for Observer {
    const NAME: &'static str = "DctObserver";
    const DESCRIPTION: &'static str =
        "Observer of both clutch torques and the drive-shaft torque of a dual-clutch driveline";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [Variable<Self>] = table::VARIABLES;
    const EXPERIMENT: Experiment = SCENARIO;

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        self.consistent()?;
        self.take_settings();
        self.state = Selected::new(table::method(self.method));
        self.y = self.state.start(&self.p, &self.settings, &self.u);
        self.phase = self.y.phase as i32;
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        check_step(step, table::LONGEST_STEP)?;
        self.take_settings();
        let Estimate { valid, engaged, .. } = self.y;
        let counted = self.state.may_count();
        let ticks = counted.then(|| self.state.recognised_ticks());
        self.y = self.state.step(&self.p, &self.settings, &self.u, step);
        self.phase = self.y.phase as i32;
        if valid && !self.y.valid || engaged != self.y.engaged {
            self.tell(valid, engaged, time + step, log);
        }
        if let Some(ticks) = ticks {
            tell_ticks(ticks, self.state.recognised_ticks(), time + step, log);
        }
        Ok(())
    }

    fn consistent(&self) -> Result<(), Failure> {
        check_maps(&self.p)
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        // All fields by name: one that is added does not compile before somebody has decided what it is.
        let Self {
            state,
            // Variables of the table.
            p: _,
            settings: _,
            method: _,
            load: _,
            u: _,
            y: _,
            phase: _,
        } = self;
        state.visit(&mut |value| fields.real(value));
    }

    fn restored(&mut self) {
        self.state.method = table::method(self.method);
    }
}

#[cfg(test)]
mod tests {
    use super::Observer;
    use fmi2_cosim::{Error, Instance, Log, Reference};

    /// A method, and a number for a variable.
    type Given = (Reference<Observer, f64>, f64);

    /// Two clutches that slip, through two steps; `late` is set between them.
    fn drive(method: i32, start: &[Given], late: &[Given]) -> Result<(), Error> {
        let log = &mut Log::silent();
        let mut observer = Instance::<Observer>::default();
        observer.write(Reference::named("observer.method"), method)?;
        for (name, value) in [
            (Reference::named("engine.speed"), 200.0),
            (Reference::named("clutch1.speed"), 180.0),
            (Reference::named("clutch2.speed"), 115.0),
            (Reference::named("wheel.speed"), 10.0),
            (Reference::named("clutch1.position"), 5e-3),
            (Reference::named("clutch2.position"), 5e-3),
        ] {
            observer.write(name, value)?;
        }
        start
            .iter()
            .try_for_each(|(name, value)| observer.write(*name, *value))?;
        observer.setup_experiment(0.0, None)?;
        observer.enter_initialization()?;
        observer.exit_initialization(log)?;
        observer.step(0.0, 1e-3, log)?;
        late.iter()
            .try_for_each(|(name, value)| observer.write(*name, *value))?;
        observer.step(1e-3, 1e-3, log)
    }

    /// Within their limits parameters may still ask for accelerations beyond all numbers.
    #[test]
    fn a_step_ends_whatever_the_parameters() {
        let hard = [
            (Reference::named("output.inertia"), 1e-9),
            (Reference::named("vehicle.wheelInertia"), 1e-9),
        ];
        for method in 1..=5 {
            for damping in [1e303, 1e308] {
                let mut start = hard.to_vec();
                start.push((Reference::named("driveShaft.damping"), damping));
                let _ = drive(method, &start, &[]); // refused or not: that it is back is what counts
            }
        }
    }

    #[test]
    fn a_force_beyond_all_numbers_is_refused_by_name() {
        let pistons = [
            (Reference::named("clutch1.pistonArea"), 1e300),
            (Reference::named("clutch2.pistonArea"), 1e300),
            // 1 is the largest friction there is: it leaves nothing to adapt.
            (Reference::named("clutch1.nominalFriction"), 1.0),
        ];
        let pressed = [(Reference::named("clutch1.pressure"), 1e300)];
        for method in 1..=5 {
            assert!(drive(method, &pistons, &[]).is_ok(), "method {method}");
            let refused = drive(method, &pistons, &pressed);
            assert!(
                matches!(refused, Err(Error::Model(_))),
                "method {method}: {refused:?}"
            );
        }
    }
}
