//! `DctObserver`: both clutch torques and the drive-shaft torque from production signals, as an FMU.
//!
//! All outputs are written by a step, so at a communication point they depend on states only: no
//! algebraic loop, whatever the importer couples.

mod table;
mod told;

use crate::step::{SCENARIO, check_step};
use crate::vehicle::{Vehicle, check_maps};
use dct_driveline::Params;
use dct_driveline::observer::{
    Estimate, LoadMethod, Method, Observer as _, Phase, Sample, Selected, Settings,
};
use fmi2_cosim::{Experiment, Failure, Log, Model, StateFields, Variable};

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
        self.state
            .step_to(&self.p, &self.settings, &self.u, step, &mut self.y);
        self.phase = self.y.phase as i32;
        if valid && !self.y.valid || engaged != self.y.engaged {
            self.tell(valid, engaged, time + step, log);
        }
        if let Some(ticks) = ticks {
            told::ticks(ticks, self.state.recognised_ticks(), time + step, log);
        }
        if self.state.leaps().holds() {
            told::leaps(&self.u, self.state.leaps(), [time + step, step], log);
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
    use super::told::LEARNT;
    use core::fmt;
    use fmi2_cosim::{Access, Category, Error, Instance, Log, Model as _, Reference};

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

    /// What is logged of a drive in first gear; `spoil` sees time [s] and engine speed [rad/s].
    fn told(method: i32, spoil: fn(f64, f64) -> f64) -> Vec<String> {
        let mut said = vec![];
        let mut sink = |_: Category, text: fmt::Arguments<'_>| said.push(text.to_string());
        let log = &mut Log::new(&mut sink);
        let mut observer = Instance::<Observer>::default();
        observer
            .write(Reference::named("observer.method"), method)
            .unwrap();
        let drive = |observer: &mut Instance<Observer>, time: f64| {
            let [one, wheel] = [150.0 + time, (150.0 + time) / 18.0];
            for (name, value) in [
                (Reference::named("engine.torque"), 60.0 + 100.0 * time),
                (Reference::named("engine.speed"), spoil(time, one)),
                (Reference::named("clutch1.speed"), one),
                (Reference::named("clutch2.speed"), 11.52 * wheel),
                (Reference::named("wheel.speed"), wheel),
            ] {
                observer.write(name, value).unwrap();
            }
        };
        drive(&mut observer, 0.0);
        observer.setup_experiment(0.0, None).unwrap();
        observer.enter_initialization().unwrap();
        observer.exit_initialization(log).unwrap();
        for k in 0..250 {
            let time = f64::from(k) * 1e-3;
            drive(&mut observer, time);
            observer.step(time, 1e-3, log).unwrap();
        }
        said
    }

    #[test]
    fn a_speed_that_leaps_is_told_once_with_value_time_and_remedy() {
        let glitch = |time: f64, speed: f64| {
            if (0.0995..0.1025).contains(&time) {
                0.0
            } else {
                speed
            }
        };
        for method in 1..=5 {
            let mut said = told(method, glitch);
            said.retain(|line| line.contains("is not believed"));
            let [leap] = &said[..] else {
                panic!("method {method}: {said:?}");
            };
            let start = "t = 0.101 s: engine.speed = 0 rad/s is not believed: 150.1 was to come in a step of 0.001 s";
            assert!(leap.starts_with(start), "method {method}: {leap}");
        }
    }

    #[test]
    fn a_fault_is_told_with_time_variables_values_and_remedy() {
        for method in 1..=5 {
            let said = told(method, |_, _| 150.0);
            let [fault] = &said[..] else {
                panic!("method {method}: {said:?}");
            };
            let start = if method == 5 {
                "t = 0.11 s: status.valid = false: what is learnt is at its physical bound (calibration.torqueScale ="
            } else {
                "t = 0.199 s: status.valid = false: a speed is frozen though what moves with it changes \
                         (engine.speed = 150, clutch1.speed = 150.198, clutch2.speed = 96.127, wheel.speed = 8.344 \
                         rad/s); check the speed sensors"
            };
            assert!(fault.starts_with(start), "method {method}: {fault}");
        }
    }

    #[test]
    fn what_is_learnt_is_told_by_the_names_of_the_table() {
        let mut observer = Observer::default();
        for (k, name) in LEARNT.into_iter().enumerate() {
            let name = format!("calibration.{name}");
            let row = Observer::VARIABLES.iter().find(|row| row.name == name);
            let Some(Access::Real(field)) = row.map(|row| row.access) else {
                panic!("no {name}");
            };
            observer.y.calibration.value[k] = 1.5;
            assert_eq!(*field(&mut observer), 1.5, "{name}");
        }
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
