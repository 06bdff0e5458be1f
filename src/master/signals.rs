//! The inputs or outputs of one FMU: value references beside their values, one group per type.

use fmi::fmi2::Fmi2Error;
use fmi::fmi2::instance::{Common, InstanceCS};
use fmi::fmi2::schema::{ScalarVariable, ScalarVariableElement};

/// FMI's get/set family of a variable; an enumeration travels as an integer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `fmi2Real`.
    Real,
    /// `fmi2Integer` and enumerations.
    Integer,
    /// `fmi2Boolean`.
    Boolean,
}

/// The family of a variable; strings have none here.
pub fn kind(variable: &ScalarVariable) -> Option<Kind> {
    match variable.elem {
        ScalarVariableElement::Real(_) => Some(Kind::Real),
        ScalarVariableElement::Integer(_) | ScalarVariableElement::Enumeration => {
            Some(Kind::Integer)
        }
        ScalarVariableElement::Boolean(_) => Some(Kind::Boolean),
        ScalarVariableElement::String => None,
    }
}

/// References and values of one type, always equally long.
#[derive(Debug, Default)]
struct Group<T> {
    references: Vec<u32>,
    values: Vec<T>,
}

impl<T: Default> Group<T> {
    fn push(&mut self, reference: u32) {
        self.references.push(reference);
        self.values.push(T::default());
    }
}

/// Inputs or outputs of one FMU: reals first, then integers, then booleans.
#[derive(Debug, Default)]
pub struct Signals {
    names: Vec<(String, Kind)>,
    reals: Group<f64>,
    integers: Group<i32>,
    booleans: Group<i32>,
}

impl Signals {
    /// Lays out the variables that are wanted.
    pub fn new<'a>(variables: impl Iterator<Item = &'a ScalarVariable> + Clone) -> Self {
        let mut signals = Self::default();
        for group in [Kind::Real, Kind::Integer, Kind::Boolean] {
            for variable in variables
                .clone()
                .filter(|variable| kind(variable) == Some(group))
            {
                signals.names.push((variable.name.clone(), group));
                match group {
                    Kind::Real => signals.reals.push(variable.value_reference),
                    Kind::Integer => signals.integers.push(variable.value_reference),
                    Kind::Boolean => signals.booleans.push(variable.value_reference),
                }
            }
        }
        signals
    }

    /// Names and types in the order of the values.
    pub fn names(&self) -> &[(String, Kind)] {
        &self.names
    }

    /// Sets the FMU's variables; `values` come in the order of the names.
    pub fn set(
        &mut self,
        instance: &mut InstanceCS,
        mut values: impl Iterator<Item = f64>,
    ) -> Result<(), (&'static str, Fmi2Error)> {
        self.reals
            .values
            .iter_mut()
            .zip(&mut values)
            .for_each(|(to, from)| *to = from);
        let narrow = self
            .integers
            .values
            .iter_mut()
            .chain(&mut self.booleans.values);
        narrow
            .zip(values)
            .for_each(|(to, from)| *to = integer(from));
        let Self {
            reals,
            integers,
            booleans,
            ..
        } = self;
        if !reals.values.is_empty() {
            let done = instance.set_real(&reals.references, &reals.values);
            done.map_err(|status| ("fmi2SetReal", status))?;
        }
        if !integers.values.is_empty() {
            let done = instance.set_integer(&integers.references, &integers.values);
            done.map_err(|status| ("fmi2SetInteger", status))?;
        }
        if !booleans.values.is_empty() {
            let done = instance.set_boolean(&booleans.references, &booleans.values);
            done.map_err(|status| ("fmi2SetBoolean", status))?;
        }
        Ok(())
    }

    /// Reads the FMU's variables into `values`, in the order of the names.
    pub fn get(
        &mut self,
        instance: &mut InstanceCS,
        values: &mut [f64],
    ) -> Result<(), (&'static str, Fmi2Error)> {
        let Self {
            reals,
            integers,
            booleans,
            ..
        } = self;
        if !reals.values.is_empty() {
            let done = instance.get_real(&reals.references, &mut reals.values);
            done.map_err(|status| ("fmi2GetReal", status))?;
        }
        if !integers.values.is_empty() {
            let done = instance.get_integer(&integers.references, &mut integers.values);
            done.map_err(|status| ("fmi2GetInteger", status))?;
        }
        if !booleans.values.is_empty() {
            let done = instance.get_boolean(&booleans.references, &mut booleans.values);
            done.map_err(|status| ("fmi2GetBoolean", status))?;
        }
        let narrow = integers
            .values
            .iter()
            .chain(&booleans.values)
            .map(|value| f64::from(*value));
        let all = reals.values.iter().copied().chain(narrow);
        values.iter_mut().zip(all).for_each(|(to, from)| *to = from);
        Ok(())
    }
}

/// A world value as an integer: exact for every i32, saturating beyond.
#[allow(clippy::cast_possible_truncation)] // saturation is what is wanted
fn integer(value: f64) -> i32 {
    value as i32
}
