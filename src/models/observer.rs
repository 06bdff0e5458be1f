//! `DctObserver`: both clutch torques and the drive-shaft torque from production signals, as an FMU.
//!
//! All outputs are written by a step, so at a communication point they depend on states only: no
//! algebraic loop, whatever the importer couples.

mod table;

use crate::step::check_step;
use crate::vehicle::{Vehicle, check_maps, invalid};
use dct_driveline::Params;
use dct_driveline::observer::{
    self as driveline, Estimate, LoadMethod, Observer as _, Paper, Sample, Settings,
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
    state: Paper,
    y: Estimate,
}

impl Default for Observer {
    fn default() -> Self {
        Self {
            p: Params::TABLE_1,
            settings: Settings::CASE_1,
            method: table::PAPER,
            load: table::MOMENTUM,
            u: Sample {
                gear: [1, 2],
                ..Sample::default()
            },
            state: Paper::default(),
            y: Estimate {
                friction: Settings::CASE_1.mu_n,
                ..Estimate::default()
            },
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

    /// Both gears are needed to define x1 and x2 at the start.
    fn check_gears(&self) -> Result<(), Failure> {
        let ratios = self.p.g(self.u.gear);
        match ratios.iter().position(|g| *g == 0.0) {
            Some(i) => {
                let remedy = "names no gear with a ratio: preselect one on each shaft at the start";
                Err(invalid(
                    crate::ports::SHAFT_GEAR[i],
                    f64::from(self.u.gear[i]),
                    remedy,
                ))
            }
            None => Ok(()),
        }
    }

    fn check_finite(&self, time: f64) -> Result<(), Failure> {
        if self.y.t_o.is_finite() {
            Ok(())
        } else {
            Err(Failure::Diverged {
                variable: crate::ports::DRIVE_SHAFT_TORQUE,
                time,
            })
        }
    }
}

impl Model for Observer {
    const NAME: &'static str = "DctObserver";
    const DESCRIPTION: &'static str = "Adaptive observer of both clutch torques and the drive-shaft torque of a dual-clutch driveline";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const LICENSE: &'static str = env!("CARGO_PKG_LICENSE");
    const VARIABLES: &'static [Variable<Self>] = table::VARIABLES;
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 30.0,
        step: 1e-3,
    };

    fn initialize(&mut self, _time: f64, _log: &mut Log<'_>) -> Result<(), Failure> {
        check_maps(&self.p)?;
        self.check_gears()?;
        self.take_settings();
        self.y = self.state.start(&self.p, &self.settings, &self.u);
        Ok(())
    }

    fn step(&mut self, time: f64, step: f64, log: &mut Log<'_>) -> Result<(), Failure> {
        check_step(step, table::LONGEST_STEP)?;
        self.take_settings();
        let (valid, engaged) = (self.y.valid, self.y.engaged);
        self.y = self.state.step(&self.p, &self.settings, &self.u, step);
        self.check_finite(time + step)?;
        let end = time + step;
        if valid && !self.y.valid {
            log.warning(format_args!(
                "t = {end} s: status.valid = false: a friction is at its physical bound of {} for {} s; \
                 the inputs do not fit the model",
                driveline::friction::Friction::PHYSICAL, driveline::paper::SATURATION,
            ));
        }
        for i in (0..2).filter(|i| engaged[*i] != self.y.engaged[*i]) {
            let now = if self.y.engaged[i] {
                "engaged"
            } else {
                "not engaged"
            };
            log.event(format_args!("t = {end} s: clutch {} is {now}", i + 1));
        }
        Ok(())
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        let Paper {
            x_hat,
            epsilon,
            innovation,
            load,
            lock,
            friction,
            f_n,
            saturated,
            g,
            ..
        } = &mut self.state;
        fields.reals(x_hat.as_mut_slice());
        fields.reals(epsilon);
        fields.reals(innovation.as_mut_slice());
        for value in [
            &mut load.momentum,
            &mut load.torque,
            &mut load.running,
            &mut load.t_v,
        ] {
            fields.real(value);
        }
        fields.boolean(&mut load.found);
        fields.reals(&mut lock.since);
        for values in [&mut friction.mu, &mut friction.slipping, &mut friction.seen] {
            fields.reals(values);
        }
        fields.reals(f_n);
        fields.real(saturated);
        fields.reals(g);
    }
}
