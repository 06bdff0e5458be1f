//! `DctObserver`: both clutch torques and the drive-shaft torque from production signals, as an FMU.
//!
//! All outputs are written by a step, so at a communication point they depend on states only: no
//! algebraic loop, whatever the importer couples.

mod table;

use crate::step::{SCENARIO, check_step};
use crate::vehicle::{Vehicle, check_maps};
use core::fmt;
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
                "t = {} s: status.valid = false: {fault} ({}); {}",
                Seconds(time),
                Evidence(self, fault),
                remedy(fault, table::method(self.method))
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

/// What `calibrating` learns, in the order of its values.
const LEARNT: [&str; 8] = [
    "torqueScale",
    "torqueBias",
    "inertiaError",
    "wheelSpeedBias",
    "stiffnessError",
    "dampingError",
    "gearboxInertiaError",
    "vehicleInertiaError",
];

/// The variables that show a fault, with their values.
struct Evidence<'a>(&'a Observer, Fault);

impl fmt::Display for Evidence<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Observer { u, y, method, .. }, fault) = self;
        let short = |value: f64| (value * 1e3).round() / 1e3;
        match fault {
            Fault::NotFinite | Fault::NoSpeed | Fault::Frozen => write!(
                f,
                "engine.speed = {}, clutch1.speed = {}, clutch2.speed = {}, wheel.speed = {} rad/s",
                short(u.omega_e),
                short(u.omega_c[0]),
                short(u.omega_c[1]),
                short(u.omega_w)
            ),
            Fault::Saturated if table::method(*method) == Method::Calibrating => {
                let told = LEARNT.iter().zip(y.calibration.value).enumerate();
                told.into_iter().try_for_each(|(k, (name, value))| {
                    let comma = if k == 0 { "" } else { ", " };
                    write!(f, "{comma}calibration.{name} = {}", short(value))
                })
            }
            Fault::Saturated => write!(
                f,
                "clutch1.friction = {}, clutch2.friction = {}",
                short(y.friction[0]),
                short(y.friction[1])
            ),
            Fault::Diverged => write!(
                f,
                "innovation.x1 = {}, innovation.x2 = {} rad/s",
                short(y.innovation[0]),
                short(y.innovation[1])
            ),
            Fault::Inconsistent => write!(f, "innovation.consistency = {}", short(y.consistency)),
        }
    }
}

/// What the user can do about a fault.
const fn remedy(fault: Fault, method: Method) -> &'static str {
    match fault {
        Fault::NotFinite => "give every input a number",
        Fault::NoSpeed | Fault::Frozen => "check the speed sensors and their connections",
        Fault::Saturated if matches!(method, Method::Calibrating) => {
            "check the engine torque, the speed sensors, and the inertias and stiffness believed"
        }
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
        self.state
            .step_to(&self.p, &self.settings, &self.u, step, &mut self.y);
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
    use super::{LEARNT, Observer};
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

    /// What is logged of a drive in first gear whose engine stands still from the start.
    fn told(method: i32) -> Vec<String> {
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
                (Reference::named("engine.speed"), 150.0),
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
    fn a_fault_is_told_with_time_variables_values_and_remedy() {
        for method in 1..=5 {
            let said = told(method);
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
