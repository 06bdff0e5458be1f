//! Outputs of one FMU that nobody reads and nobody records, looked at now and then.
//!
//! A run that keeps a few signals does not ask for the others. One of them that is no number would pass
//! unseen: most values of that kind stay what they are, so a look now and then finds them.

use crate::description::Variable;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::signals::Signals;

/// Steps from one look to the next; the first and the last communication point are looked at besides.
pub const EVERY: usize = 128;

/// Outputs, and room for their values.
#[derive(Debug, Default)]
pub struct Rest {
    names: Vec<String>,
    signals: Signals,
    values: Vec<f64>,
}

impl Rest {
    /// For outputs of a component, which come sorted by family.
    pub fn new(component: &str, outputs: &[&Variable]) -> Self {
        let full = |output: &&Variable| format!("{component}.{}", output.name);
        Self {
            names: outputs.iter().map(full).collect(),
            signals: Signals::new(outputs.iter().copied()),
            values: vec![0.0; outputs.len()],
        }
    }

    /// Reads them at `time` [s].
    ///
    /// # Errors
    ///
    /// One of them is no finite number.
    pub fn look(&mut self, fmu: &mut Fmu, time: f64) -> Result<(), Error> {
        fmu.get(&mut self.signals, &mut self.values)?;
        let mut all = self.names.iter().zip(&self.values);
        let bad = all.find(|(_, value)| !value.is_finite());
        bad.map_or(Ok(()), |(name, value)| {
            Err(Error::no_number(name, *value, time))
        })
    }
}
