//! First time derivatives of some of an FMU's inputs or outputs.

use crate::description::Variable;
use crate::signals::Failure;
use cosim_raw::Instance;

/// Order of all derivatives here.
const FIRST: i32 = 1;

/// Which of a vector of variables have derivatives, and their values.
#[derive(Debug, Default)]
pub struct Derivatives {
    references: Vec<u32>,
    orders: Vec<i32>,
    /// Places in the vector.
    places: Vec<usize>,
    values: Vec<f64>,
}

impl Derivatives {
    /// Of the variables that pass `choose`.
    pub fn new(variables: &[&Variable], choose: impl Fn(&Variable) -> bool) -> Self {
        let all = variables.iter().enumerate();
        let (places, references): (Vec<_>, Vec<_>) = all
            .filter(|(_, variable)| choose(variable))
            .map(|(place, variable)| (place, variable.reference))
            .unzip();
        Self {
            orders: vec![FIRST; places.len()],
            values: vec![0.0; places.len()],
            places,
            references,
        }
    }

    /// Sets those of inputs; `slopes` has one for each variable of the vector.
    pub fn set(&mut self, instance: &mut Instance, slopes: &[f64]) -> Result<(), Failure> {
        if self.places.is_empty() {
            return Ok(());
        }
        let values = self.values.iter_mut().zip(&self.places);
        values.for_each(|(value, place)| {
            *value = slopes.get(*place).copied().unwrap_or(f64::NAN);
        });
        let done = instance.set_slopes(&self.references, &self.orders, &self.values);
        done.map_err(|status| ("fmi2SetRealInputDerivatives", status))
    }

    /// Gets those of outputs; all others are 0.
    pub fn get(&mut self, instance: &mut Instance, slopes: &mut [f64]) -> Result<(), Failure> {
        slopes.fill(0.0);
        if self.places.is_empty() {
            return Ok(());
        }
        let done = instance.get_slopes(&self.references, &self.orders, &mut self.values);
        done.map_err(|status| ("fmi2GetRealOutputDerivatives", status))?;
        for (place, value) in self.places.iter().zip(&self.values) {
            if let Some(slope) = slopes.get_mut(*place) {
                *slope = *value;
            }
        }
        Ok(())
    }
}

/// Brings inputs on along their slopes for so many seconds; without slopes they stay.
pub fn advance(values: &mut [f64], slopes: &[f64], seconds: f64) {
    for (value, slope) in values.iter_mut().zip(slopes) {
        *value += slope * seconds;
    }
}
