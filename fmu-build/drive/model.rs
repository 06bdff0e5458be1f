//! A model of this program as a component: what its FMU does, without the FMU.

use super::{Kind, Part, Place, Role, Signal, whole};
use crate::description::names;
use crate::outside::Fault;
use crate::{Error, Result};
use fmi2_cosim::{Access, Causality, Instance, Log, Model, Resources};
use std::path::Path;

/// An instance of `M` with its signals.
pub(crate) struct Driven<M: Model> {
    instance: Instance<M>,
    signals: Vec<Signal>,
}

impl<M: Model> Driven<M> {
    /// A fresh instance that has loaded what its model reads from the folder `resources` of its package.
    pub(crate) fn loaded(package: &Path) -> Result<Box<dyn Part>> {
        let mut driven = Self::new();
        if M::RESOURCES {
            let folder = package.join("resources");
            let found = Resources::at(&folder);
            let loaded =
                found.and_then(|found| driven.instance.load(Some(&found), &mut Log::silent()));
            loaded.map_err(|fault| {
                let said = fault.to_string();
                Error::Outside(Fault::Resources { folder, said })
            })?;
        }
        Ok(Box::new(driven))
    }

    /// A fresh instance.
    #[cfg(feature = "dct")]
    pub(crate) fn boxed() -> Box<dyn Part> {
        Box::new(Self::new())
    }

    fn new() -> Self {
        let signals = names::all(M::VARIABLES).filter_map(|named| {
            let reference = u32::try_from(named.reference).ok()?;
            let role = match named.causality() {
                Causality::Input => Role::Input,
                Causality::Output => Role::Output,
                Causality::Parameter => Role::Parameter,
                Causality::Local => return None,
            };
            let kind = match named.row.access {
                Access::Real(_) => Kind::Real,
                Access::Integer(_) | Access::Enumeration(..) => Kind::Integer,
                Access::Boolean(_) => Kind::Boolean,
                Access::String(_) => return None, // a table holds numbers
            };
            let place = Place { kind, reference };
            Some(Signal {
                name: named.name().into(),
                role,
                place,
            })
        });
        Self {
            instance: Instance::default(),
            signals: signals.collect(),
        }
    }
}

/// What the model logs is for importers.
fn silent<T>(
    call: impl FnOnce(&mut Log<'_>) -> std::result::Result<T, fmi2_cosim::Error>,
) -> Result<T> {
    call(&mut Log::silent()).map_err(Error::Model)
}

impl<M: Model> Part for Driven<M> {
    fn name(&self) -> &str {
        M::NAME
    }

    fn signals(&self) -> &[Signal] {
        &self.signals
    }

    fn set(&mut self, Place { kind, reference }: Place, value: f64) -> Result<()> {
        let at = [reference];
        silent(|_| match kind {
            Kind::Real => self.instance.set(&at, [value].into_iter()),
            Kind::Integer => self.instance.set(&at, [whole(value)].into_iter()),
            Kind::Boolean => self.instance.set(&at, [value != 0.0].into_iter()),
        })
    }

    fn get(&mut self, Place { kind, reference }: Place) -> Result<f64> {
        let at = [reference];
        let value = silent(|log| {
            Ok(match kind {
                Kind::Real => self.instance.get(&at, log)?.next(),
                Kind::Integer => self.instance.get::<i32>(&at, log)?.next().map(f64::from),
                Kind::Boolean => self.instance.get::<bool>(&at, log)?.next().map(f64::from),
            })
        })?;
        Ok(value.unwrap_or(f64::NAN))
    }

    fn initialize(&mut self, time: f64) -> Result<()> {
        silent(|_| {
            self.instance.setup_experiment(time, None)?;
            self.instance.enter_initialization()
        })
    }

    fn start(&mut self) -> Result<()> {
        silent(|log| self.instance.exit_initialization(log))
    }

    fn step(&mut self, time: f64, step: f64) -> Result<()> {
        silent(|log| self.instance.step(time, step, log))
    }

    fn terminate(&mut self) -> Result<()> {
        silent(|_| self.instance.terminate())
    }
}
